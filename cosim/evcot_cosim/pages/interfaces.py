# SPDX-License-Identifier: Apache-2.0
"""One timing diagram for each interface, recorded from the simulated RTL."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from evcot.hardware.contract import RECORD, REGISTERS, Mode
from evcot.hardware.registers import register_map
from evcot.tracks.log import Kind

from ..devices.base import reset
from ..fpga.serial_host import BYTE_BITS, Receiver, levels, request
from ..rtl.build import load
from .trace import Diagram, Lane, Offer, Trace, play, wave, wire

__all__ = ["DIAGRAMS"]

_DIVISOR = 4


def uart_byte() -> Diagram:
    """The byte 'R' (0x52) from uart_tx, one column a bit."""
    sim = load("uart_tx", {"DIVISOR": _DIVISOR})
    reset(sim)
    sim.io.s_valid, sim.io.s_data = 1, ord("R")
    sim.clock.tick()
    sim.io.s_valid = 0
    line = ["1"]
    for clock in range((BYTE_BITS + 1) * _DIVISOR):
        if clock % _DIVISOR == _DIVISOR // 2:
            line.append(str(int(sim.io.tx)))
        sim.clock.tick()
    bits = ["x", "=start", *(f"={bit}" for bit in range(8)), "=stop", "x"]
    return {"signal": [{"name": "tx", **wave(line)}, {"name": "bit", **wave(bits)}], "config": {"hscale": 1}}


def uart_frames() -> Diagram:
    """The register `id` is read through uart_host, one column a byte."""
    identity = next(word for word in register_map().words if word.name == "id")
    sim = load("uart_host", {"DIVISOR": _DIVISOR})
    sim.io.rx = 1
    reset(sim)
    io = sim.io
    io.m_axil_arready = 1
    io.m_axil_rdata = int.from_bytes(b"EVCT", "big")
    question = request("R", identity.address)
    line = [1] * _DIVISOR + levels(question, _DIVISOR)
    receiver, asked = Receiver(_DIVISOR), False
    for level in line + [1] * (16 * BYTE_BITS * _DIVISOR - len(line)):
        io.rx = level
        io.m_axil_rvalid = int(asked)
        asked = bool(int(io.m_axil_arvalid)) or (asked and not int(io.m_axil_rready))
        receiver.sample(int(io.tx))
        sim.clock.tick()
    columns = 1 + len(question) + len(receiver.received) + 1
    rx, tx = ["1"] * columns, ["1"] * columns
    for i, value in enumerate(question):
        rx[1 + i] = "=" + _shown(i, value)
    first = 1 + receiver.began[0] // (BYTE_BITS * _DIVISOR)
    for i, value in enumerate(receiver.received):
        tx[first + i] = "=" + _shown(i, value)
    meaning = ["x", "=read", "=address", "=address", *["=data"] * 4]
    response = ["=read", "=resp", *["=data"] * 4, "=sum"]
    meaning += ["x"] * (first - len(meaning)) + response + ["x"] * (columns - first - len(response))
    lanes = [("rx", rx), ("tx", tx), ("", meaning)]
    return {"signal": [{"name": name, **wave(states)} for name, states in lanes], "config": {"hscale": 1}}


def _shown(place: int, value: int) -> str:
    return f"'{chr(value)}'" if place == 0 else f"{value:02x}"


def _pair(x: int, y: int) -> str:
    return f"{x},{y}"


def _bundle(prefix: str, *fields: Lane) -> list[Lane]:
    """valid, ready, and fields that mean something while valid is high."""
    return [wire(f"{prefix}valid"), wire(f"{prefix}ready"), *fields]


def _tokens() -> Diagram:
    """A birth, two moves and a passed event in cot_array with one slot, while the owned events stall once."""
    sim = load("cot_array", {"N": 1, "TICK_W": 8, "X_W": 7, "Y_W": 7, "SEQ_W": 16, "TIME_W": 34})
    reset(sim)
    slot = dict.fromkeys(REGISTERS, 1) | {
        "init_radix": 8, "radix_th": 4, "radix_min": 8, "radix_max": 8, "hist_avg": 0, "max_ticks": 1000,
        "clust_nev": 2, "nev_min": 2, "nev_max": 2, "nev_th": 1000, "detect_ticks": 1000, "mode": Mode.SEEDED,
    }  # fmt: skip
    sim.io.cfg_valid = 1
    for name in [*(name for name in REGISTERS if name != "mode"), "mode"]:
        sim.io.cfg_addr, sim.io.cfg_data = REGISTERS[name].address, int(slot[name])
        sim.clock.tick()
    sim.io.cfg_valid = 0
    for valid in (0, 1, 0):  # idle, then one token without ticks: with the first, the array looks up its deadlines
        sim.io.s_valid = valid
        for _ in range(1 if valid else 60):
            sim.clock.tick()
    # ticks, event, x, y
    words = [(0, 1, 40, 40), (3, 1, 42, 40), (9, 0, 0, 0), (1, 1, 90, 10), (2, 1, 42, 42), (1, 1, 44, 42), (4, 1, 44, 44)]
    offer = Offer(sim, "s_", ("tick", "event", "x", "y"), words, {0, 4})
    tokens = _bundle(
        "s_",
        Lane("s_tick", ("s_tick",), str, "s_valid"),
        Lane("s_event", ("s_event",), when="s_valid"),
        Lane("s_x, s_y", ("s_x", "s_y"), _pair, "s_valid"),
    )
    records = _bundle(
        "m_cm_",
        Lane("m_cm_kind", ("m_cm_kind",), lambda kind: Kind(kind).name.lower(), "m_cm_valid"),
        Lane("m_cm_x, _y / 16", ("m_cm_x", "m_cm_y"), lambda x, y: f"{x / 16:g},{y / 16:g}", "m_cm_valid"),
        Lane("m_cm_seq", ("m_cm_seq",), str, "m_cm_valid"),
    )
    owned = _bundle(
        "m_own_",
        Lane("m_own_x, _y", ("m_own_x", "m_own_y"), _pair, "m_own_valid"),
        Lane("m_own_seq", ("m_own_seq",), str, "m_own_valid"),
    )
    passed = _bundle(
        "m_pass_",
        Lane("m_pass_x, _y", ("m_pass_x", "m_pass_y"), _pair, "m_pass_valid"),
        Lane("m_pass_seq", ("m_pass_seq",), str, "m_pass_valid"),
    )
    trace = Trace(sim, [("tokens", tokens), ("records", records), ("owned", owned), ("passed", passed)])
    play(trace, 40, [offer], {"m_cm_ready": (), "m_own_ready": (28, 29), "m_pass_ready": ()})
    return trace.diagram()


def _records() -> Diagram:
    """Two records through axis_records_out at 64 bits a beat; each is accepted with its last beat."""
    sim = load("axis_records_out", {"DATA_W": 64})
    reset(sim)
    ports = ("seq", "time", "id", "other", "x", "y", "support", "radius", "n_ev", "slot", "kind")
    fields = ("seq", "time", "track_id", "other_id", "cm_x", "cm_y", "support", "radius", "n_ev", "slot", "kind")
    values = [(7, 1200, 5, 0, 640, 672, 40, 9, 16, 3, Kind.MOVED), (9, 1300, 6, 0, 88, 96, 8, 9, 16, 1, Kind.BORN)]
    shown = {}
    for letter, value in zip("AB", values, strict=True):
        packed = np.zeros(1, RECORD)
        for name, entry in zip(fields, value, strict=True):
            packed[name] = entry
        for beat, word in enumerate(packed.view("<u8").tolist()):
            shown[word] = f"{letter}{beat}"
    offer = Offer(sim, "s_cm_", ports, values, {0})
    record = _bundle("s_cm_", Lane("s_cm_*", ("s_cm_seq",), lambda seq: "AB"[seq == 9], "s_cm_valid"))
    beats = _bundle(
        "m_axis_t",
        Lane("m_axis_tdata", ("m_axis_tdata",), shown.__getitem__, "m_axis_tvalid"),
        Lane("m_axis_tkeep", ("m_axis_tkeep",), "{:02x}".format, "m_axis_tvalid"),
        Lane("m_axis_tlast", ("m_axis_tlast",), when="m_axis_tvalid"),
    )
    trace = Trace(sim, [("record", record), ("AXI4-Stream", beats)])
    play(trace, 24, [offer], {"m_axis_tready": (11, 12)})
    return trace.diagram()


_RESPONSES = {0: "OKAY", 2: "SLVERR"}


def _registers() -> Trace:
    """axi_lite_regs with one slot, a while after reset."""
    sim = load("axi_lite_regs", {"N": 1, "HAS": 0})
    sim.io.core_rst = 1
    reset(sim)
    sim.io.core_rst = 0
    for _ in range(2 * register_map().banks["slot"].words + 16):  # the shadow of a slot and of the filters is filled
        sim.clock.tick()
    sim.io.s_axil_wstrb = 15

    def when(channel: str, port: str, label: Callable[..., str]) -> Lane:
        return Lane(f"s_axil_{channel}{port}", (f"s_axil_{channel}{port}",), label, f"s_axil_{channel}valid")

    def channel(name: str, *fields: Lane) -> list[Lane]:
        return _bundle(f"s_axil_{name}", *fields)

    address = "{:04x}".format
    write = [
        *channel("aw", when("aw", "addr", address)),
        *channel("w", when("w", "data", "{:x}".format)),
        *channel("b", when("b", "resp", _RESPONSES.__getitem__)),
    ]
    read = [
        *channel("ar", when("ar", "addr", address)),
        *channel(
            "r", when("r", "data", lambda word: word.to_bytes(4, "big").decode()), when("r", "resp", _RESPONSES.__getitem__)
        ),
    ]
    return Trace(sim, [("write", write), ("read", read)])


def _axi_lite() -> Diagram:
    """A write that is clamped (tick_us = 0), and a read of `id`."""
    trace = _registers()
    words = {word.name: word.address for word in register_map().words}
    offers = [
        Offer(trace.sim, "s_axil_aw", ("addr",), [(words["tick_us"],)], {0}),
        Offer(trace.sim, "s_axil_w", ("data",), [(0,)], {0, 1}),
        Offer(trace.sim, "s_axil_ar", ("addr",), [(words["id"],)], set(range(13))),
    ]
    play(trace, 22, offers, {"s_axil_bready": (11,), "s_axil_rready": ()})
    return trace.diagram()


def _commit() -> Diagram:
    """A slot's bank takes effect: its 15 registers are copied once the gate says that nothing is under way."""
    trace = _registers()
    bank = register_map().banks["slot"]
    words = {word.name: word.address for word in register_map().words}
    sim = trace.sim

    def write(accesses: list[tuple[int, int]], pause: int) -> list[Offer]:
        return [
            Offer(sim, "s_axil_aw", ("addr",), [(address,) for address, _ in accesses], set(range(pause))),
            Offer(sim, "s_axil_w", ("data",), [(data,) for _, data in accesses], set(range(pause))),
        ]

    before = [(words["irq_enable"], 16), (bank.base + 4 * REGISTERS["mode"].address, Mode.SEEDED)]
    play(Trace(sim, ()), 40, write(before, 0), {"s_axil_bready": ()})
    lanes = [
        *_bundle("s_axil_aw", Lane("s_axil_awaddr", ("s_axil_awaddr",), "{:04x}".format, "s_axil_awvalid")),
        wire("s_axil_bvalid"),
    ]
    gate = load("token_gate")
    reset(gate)
    gate.io.enable = gate.io.m_ready = 1
    gate.clock.tick()
    closing = [wire("busy"), *(wire(port, of=gate) for port in ("open", "idle", "apply"))]
    copied = [wire("cfg_valid"), Lane("cfg_addr", ("cfg_addr",), str, "cfg_valid")]
    told = Trace(sim, [("bus", lanes), ("gate", closing), ("slot", copied), ("", [wire("irq")])])
    closed = 0

    def join(clock: int) -> None:
        """Wire the two; what is under way in the trackers is out three clocks after the gate has closed."""
        nonlocal closed
        if clock:
            gate.clock.tick()
        closed = 0 if int(gate.io.open) else closed + 1
        gate.io.idle = int(closed > 2)
        gate.io.busy = int(sim.io.busy)
        sim.io.apply = int(gate.io.apply)

    play(told, 36, write([(bank.base + 4 * bank.commit, 1)], 1), {"s_axil_bready": ()}, join)
    return told.diagram()


def _evt21() -> Diagram:
    """EVT 2.1 on 64 bits: a time mark and a vector of three events, then a mark and a vector of one."""
    sim = load("evt21_decoder", {"WIDTH": 1280, "HEIGHT": 720})
    reset(sim)

    def vector(time: int, x: int, y: int, mask: int) -> int:
        return 1 << 60 | (time & 63) << 54 | x << 43 | y << 32 | mask

    def mark(time: int) -> int:
        return 8 << 60 | time >> 6 << 32

    words = [mark(6400), vector(6405, 64, 9, 0b1011), mark(6464), vector(6470, 32, 7, 1 << 31)]
    names = dict(zip(words, ("mark", "vec", "mark'", "vec'"), strict=True))
    sim.io.s_axis_tkeep = 255
    offer = Offer(sim, "s_axis_t", ("data",), [(word,) for word in words], {0})
    taken = _bundle("s_axis_t", Lane("s_axis_tdata", ("s_axis_tdata",), names.__getitem__, "s_axis_tvalid"))
    given = _bundle(
        "m_",
        Lane("m_t", ("m_t",), str, "m_valid"),
        Lane("m_x, m_y", ("m_x", "m_y"), _pair, "m_valid"),
        Lane("m_p", ("m_p",), when="m_valid"),
    )
    trace = Trace(sim, [("EVT 2.1", taken), ("events", given)])
    play(trace, 18, [offer], {"m_ready": (10,)})
    return trace.diagram()


# ---- AER: the chip moves half a clock after an edge ------------------------------------------------------------------


def _aer(word_serial: int, words: list[tuple[int, int]], clocks: int) -> Diagram:
    """Words (row, data) to aer_in from a chip that answers at once; active low."""
    x_w, y_w = 8, 7
    sim = load("aer_in", {"X_W": x_w, "Y_W": y_w, "WIDTH": 240, "HEIGHT": 120})
    io = sim.io
    io.active_low, io.word_serial, io.aer_req = 1, word_serial, 1
    reset(sim)
    waiting = list(words)

    def label(released: int, row: int, data: int) -> str:
        if released:
            return ""
        if word_serial:
            return f"row {data}" if row else f"col {data >> 1}"
        return _pair(data >> 1 & (1 << x_w) - 1, data >> x_w + 1)

    def chip(clock: int) -> None:
        """4-phase: request until the acknowledge comes, then not until it has gone."""
        io.t_us = 100 + clock // 4
        if not int(io.aer_req) and not int(io.aer_ack):
            io.aer_req = 1
        elif int(io.aer_req) and int(io.aer_ack) and waiting and clock > 0:
            io.aer_row, io.aer_data = waiting.pop(0)
            io.aer_req = 0

    rows = [wire("aer_row", outside=True)] if word_serial else []
    sent = [
        Lane("aer_req", ("aer_req",), outside=True),
        *rows,
        Lane("aer_data", ("aer_req", "aer_row", "aer_data"), label, outside=True),
        wire("aer_ack"),
    ]
    given = _bundle("m_", Lane("m_t", ("m_t",), str, "m_valid"), Lane("m_x, m_y", ("m_x", "m_y"), _pair, "m_valid"))
    trace = Trace(sim, [("chip", sent), ("events", given)])
    play(trace, clocks, (), {"m_ready": ()}, chip)
    return trace.diagram()


def _aer_plain() -> Diagram:
    """Two words {y, x, p}."""
    return _aer(0, [(0, 20 << 9 | 30 << 1 | 1), (0, 21 << 9 | 31 << 1)], 20)


def _aer_word_serial() -> Diagram:
    """A row and two columns of it."""
    return _aer(1, [(1, 20), (0, 30 << 1 | 1), (0, 33 << 1)], 28)


def _aer_out() -> Diagram:
    """A passed event and a centre, each with its tag, to a chip that answers at once; active high."""
    sim = load("aer_out", {"X_W": 8, "Y_W": 7, "SLOT_W": 2})
    reset(sim)
    for _ in range(4):
        sim.clock.tick()
    kinds = ("pass", "own", "centre")
    offer = Offer(sim, "s_", ("kind", "slot", "x", "y", "p"), [(0, 0, 30, 20, 1), (2, 1, 31, 21, 0)], {0})
    taken = _bundle(
        "s_", Lane("s_kind", ("s_kind",), kinds.__getitem__, "s_valid"), Lane("s_x, s_y", ("s_x", "s_y"), _pair, "s_valid")
    )

    def word(data: int) -> str:
        return f"{kinds[data >> 18]} {_pair(data >> 1 & 255, data >> 9 & 127)}" if data else ""

    def chip(_clock: int) -> None:
        sim.io.aer_ack = int(sim.io.aer_req)

    sent = [wire("aer_req"), Lane("aer_data", ("aer_data",), word), wire("aer_ack", outside=True)]
    trace = Trace(sim, [("events", taken), ("chip", sent)])
    play(trace, 20, [offer], None, chip)
    return trace.diagram()


DIAGRAMS: Mapping[str, Callable[[], Diagram]] = MappingProxyType(
    {
        "tokens": _tokens,
        "records": _records,
        "axi_lite": _axi_lite,
        "commit": _commit,
        "evt21": _evt21,
        "aer_plain": _aer_plain,
        "aer_word_serial": _aer_word_serial,
        "aer_out": _aer_out,
        "uart_byte": uart_byte,
        "uart_frames": uart_frames,
    }
)
"""By name; the first line of each function's docstring is the title."""
