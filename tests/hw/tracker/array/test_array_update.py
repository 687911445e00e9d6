# SPDX-License-Identifier: Apache-2.0
"""array_update.v against the golden model's own functions: the effect of an event or operation on its slot, by stage."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot.hardware import _cot_kernel as kernel
from evcot.hardware.contract import REGISTERS, Mode, Shape
from evcot.tracks.log import Kind
from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load

N, LIFE_W = 3, 8
SHAPE = Shape(n_slots=N, x_w=7, y_w=6, frac=4, radix_w=5, nev_w=4, tc_w=6, sup_w=4, id_w=8)
EDGE_BITS_X, EDGE_BITS_Y = 9, 8  # of a bound: see cot_window.v
WIDTHS = ("X_W", "Y_W", "FRAC", "RADIX_W", "NEV_W", "TC_W", "SUP_W", "ID_W")
PARAMETERS = {name: getattr(SHAPE, name.lower()) for name in WIDTHS} | {
    "N": N,
    "LIFE_W": LIFE_W,
    "SLOT_W": 2,
    "AT_X": EDGE_BITS_X,
    "AT_Y": EDGE_BITS_Y,
}
REL = 1 << SHAPE.radix_w + 2  # recentred addresses are modulo this
NOTHING = dict.fromkeys(["c_takes", "c_commits", "c_seeds", "c_active", "c_report", "c_clear", "c_join", "c_looks"], 0)
OTHER, ENDED = 77, 55  # what a record says of a merge, of a loss
APART = 6  # clocks from a special event or an operation in C to the next item there

Kinds = Literal["event", "report", "clear", "join", "look"]


@dataclass(frozen=True)
class Item:
    """What enters C: an event that its slot takes, or an operation.

    Attributes:
        x, y: an event's pixel; where a merge puts the centre, in fractions of a pixel.
        ticks: since the event before.
        g, support: what a merge makes of them.
        lost: a report is of a loss, not of a merge.
        max_ticks: a look is at that timer's grant, not at that of detect_ticks.
    """

    kind: Kinds
    slot: int
    x: int = 0
    y: int = 0
    ticks: int = 0
    g: int = 0
    support: int = 0
    lost: bool = False
    max_ticks: bool = False


class Model:
    """The slots as the golden model keeps them, and what it expects of each item."""

    def __init__(self, registers: np.ndarray) -> None:
        self.registers = registers
        self.limits = np.zeros(kernel.LIMIT_COUNT, np.int64)
        self.limits[[kernel.FRAC, kernel.X_MAX, kernel.Y_MAX, kernel.TC_MAX, kernel.SUPPORT_MAX, kernel.ID_MASK]] = (
            SHAPE.frac, *((1 << w) - 1 for w in (SHAPE.x_w, SHAPE.y_w, SHAPE.tc_w, SHAPE.sup_w, SHAPE.id_w)),
        )  # fmt: skip
        self.state = np.zeros((kernel.FIELD_COUNT, N), np.int64)
        self.glob = np.zeros(kernel.GLOBAL_COUNT, np.int64)
        kernel.initialise(self.state, registers, self.limits, self.glob)
        self.now, self.seq = 0, -1

    def field(self, name: int, slot: int) -> int:
        return int(self.state[name, slot])

    def of(self, register: str, slot: int) -> int:
        return int(self.registers[list(REGISTERS).index(register), slot])

    def active(self, slot: int) -> bool:
        return bool(self.field(kernel.ACTIVE, slot))

    def seeds(self, slot: int) -> bool:
        """The next event of the slot starts a life where it lies."""
        fresh = self.field(kernel.DEADLINE, slot) == kernel.NEVER
        return fresh and not self.active(slot) and self.of("mode", slot) == Mode.SEEDED

    def pixel(self, slot: int) -> tuple[int, int]:
        x, y = (int(kernel._pixel(self.field(name, slot), SHAPE.frac)) for name in (kernel.CM_X, kernel.CM_Y))
        return x, y

    def record(self, slot: int, kind: Kind, other: int = 0) -> dict[str, int]:
        names = {"id": kernel.ID, "x": kernel.CM_X, "y": kernel.CM_Y, "n_ev": kernel.N_EV, "support": kernel.SUPPORT}
        radius = self.field(kernel.G, slot) + self.of("radix_th", slot)
        result = {"kind": int(kind), "slot": slot, "other": other, "radius": radius, "seq": self.seq, "time": self.now}
        return result | {name: self.field(row, slot) for name, row in names.items()}

    def event(self, item: Item) -> tuple[bool, tuple[int, int], dict[str, int] | None]:
        """Whether it changes a window; its place in the window before; the record."""
        slot = item.slot
        self.now += item.ticks
        self.seq += 1
        first = self.field(kernel.DEADLINE, slot) == kernel.NEVER
        if self.seeds(slot):
            kernel._place(self.state, self.registers, self.limits, slot, item.x, item.y)
        radius, (px, py) = self.field(kernel.G, slot) + self.of("radix_th", slot), self.pixel(slot)
        place = (item.x - px + radius) % REL, (item.y - py + radius) % REL
        if not kernel._take(self.state, self.registers, self.limits, slot, item.x, item.y, self.now):
            return first, place, None
        kind = kernel._proc(self.state, self.registers, self.limits, self.glob, slot, self.now)
        return True, place, self.record(slot, Kind(kind))

    def operation(self, item: Item) -> dict[str, int] | None:
        """The record of a REPORT or a JOIN; a CLEAR has none."""
        slot = item.slot
        if item.kind == "report":
            if item.lost:
                return self.record(slot, Kind.LOST) | {"time": ENDED}
            return self.record(slot, Kind.MERGED, OTHER)
        if item.kind == "clear":
            kernel._retire(self.state, self.registers, self.limits, slot)
            return None
        self.state[[kernel.CM_X, kernel.AV_X], slot] = item.x
        self.state[[kernel.CM_Y, kernel.AV_Y], slot] = item.y
        self.state[kernel.G, slot] = min(item.g, self.of("radix_max", slot))
        self.state[kernel.SUPPORT, slot] = item.support
        self.state[kernel.DEADLINE, slot] = self.now + self.of("max_ticks", slot)
        kernel._set_window(self.state, self.registers, self.limits, slot)
        return self.record(slot, Kind.MOVED)


class Lockstep:
    """The module and the model; each item goes through both, and what comes out of every stage is compared.

    Attributes:
        n_records: records of each kind.
        changes: in which directions N_ev and g have gone.
    """

    def __init__(self, far: int, registers: np.ndarray) -> None:
        self.sim: PyVerilator = load("array_update", {**PARAMETERS, "FAR": far})
        self.model = Model(registers)
        self.n_records = dict.fromkeys([kind.name for kind in Kind], 0)
        self.changes: set[str] = set()
        self._rng = np.random.default_rng(far)
        self._now = 0  # clocks so far
        self._c = NOTHING  # what is in C
        self._due: dict[int, list[tuple[str, dict[str, int]]]] = {}  # clock -> stage, what is expected there
        self._committed: dict[int, tuple[int, int]] = {}  # clock from which on a token is the last one -> time, number
        io = self.sim.io
        reset(self.sim)
        io.m_cm_ready, io.other, io.ended = 1, OTHER, ENDED
        io.cfg_valid = 1
        for slot in range(N):
            for name in [*(name for name in REGISTERS if name != "mode"), "mode"]:
                io.cfg_slot, io.cfg_addr, io.cfg_data = slot, REGISTERS[name].address, self.model.of(name, slot)
                self.sim.clock.tick()
        io.cfg_valid = 0
        self.play([Item("clear", slot) for slot in range(N)])

    def play(self, items: Iterable[Item], idle: float = 0.0) -> None:
        """Let items enter C as close behind each other as they may, with this share of idle clocks in between."""
        for item in items:
            while self._rng.random() < idle:
                self.clock()
            if item.kind != "event":
                self.wait(2)
            self.clock(*self._entering(item))
            if item.kind == "look":
                self.wait(2)
            elif any(stage == "W" for stage, _ in self._due.get(self._now + 3, [])) or item.kind == "report":
                self._throw_out(item.kind == "event")
        self.wait(8)
        assert not self._due

    def wait(self, clocks: int) -> None:
        for _ in range(clocks):
            self.clock()

    def _throw_out(self, behind_event: bool) -> None:
        """Behind what changes a window comes an event that is not committed; then nothing until that is through."""
        if behind_event:
            slot, x, y = (int(self._rng.integers(high)) for high in (N, 128, 64))
            self.clock(slot, x, y, NOTHING | {"c_takes": 1, "c_active": int(self._rng.integers(2))})
        self.wait(APART - 1 - behind_event)

    def clock(self, slot: int = 0, x: int = 0, y: int = 0, entering: Mapping[str, int] = NOTHING) -> None:
        """One clock, at whose end something goes from D to C."""
        io = self.sim.io
        if self._now in self._committed:
            io.now, io.seq = self._committed.pop(self._now)
        for port, value in self._c.items():
            io[port] = value
        io.d_slot, io.d_x, io.d_y = slot, x, y
        self._check(self._due.pop(self._now, []))
        self.sim.clock.tick()
        self._now += 1
        self._c = {**entering, "c_slots": slot * 0b010101, "c_slots_not": (3 - slot) * 0b0101, "c_x": x, "c_y": y}

    def _expect(self, after: int, stage: str, values: dict[str, int]) -> None:
        """So many clocks after the one in C, which is the next."""
        self._due.setdefault(self._now + 1 + after, []).append((stage, values))

    def _entering(self, item: Item) -> tuple[int, int, int, dict[str, int]]:
        """Slot, pixel and flags of what goes into C, and in the model all that comes of it."""
        model, slot = self.model, item.slot
        flags = NOTHING | {"c_active": int(model.active(slot))}
        if item.kind == "look":
            timed = model.field(kernel.DEADLINE, slot) != kernel.NEVER
            seen = {"v_slot": slot, "v_timed": int(timed), "v_on": int(model.of("mode", slot) != Mode.OFF)}
            seen["v_grant"] = model.of("max_ticks" if model.active(slot) or item.max_ticks else "detect_ticks", slot)
            timer = {"v_deadline": model.field(kernel.DEADLINE, slot) % (1 << LIFE_W)} if timed else {}
            self._expect(2, "V", seen | timer)
            return slot, 0, 0, flags | {"c_looks": 1, "looks_max": int(item.max_ticks)}
        if item.kind == "event":
            flags |= {"c_takes": 1, "c_commits": 1, "c_seeds": int(model.seeds(slot))}
            n_ev, g = model.field(kernel.N_EV, slot), model.field(kernel.G, slot)
            changes, (rel_x, rel_y), record = model.event(item)
            self._expect(2, "V", {"v_rel_x": rel_x, "v_rel_y": rel_y})
            self._committed[self._now + 3] = model.now, model.seq
            if record is not None and record["kind"] == Kind.MOVED:
                moves = {"n_ev": model.field(kernel.N_EV, slot) - n_ev, "g": model.field(kernel.G, slot) - g}
                self.changes |= {f"{name} {(move > 0) - (move < 0):+}" for name, move in moves.items()}
        else:
            flags |= {f"c_{item.kind}": 1, "lost": int(item.lost)}
            if item.kind == "join":
                flags |= {"join_x": item.x, "join_y": item.y, "join_g": item.g, "join_support": item.support}
            changes, record = item.kind == "clear", model.operation(item)
        if changes or item.kind == "join":
            self._expect(3, "W", self._window(item, changes))
        if record is not None:
            self._expect(5, "record", record)
        return slot, item.x & 127, item.y & 63, flags

    def _window(self, item: Item, changes: bool) -> dict[str, int]:
        model, slot = self.model, item.slot
        clear, mode = item.kind == "clear", model.of("mode", slot)
        result = {"w_busy": 1, "w_changes": int(changes), "w_slot": slot, "w_active": int(model.active(slot))}
        result["w_free"] = int(clear and mode == Mode.SEEDED)
        result["w_window"] = int(not clear or mode == Mode.FIXED)
        bounds = {"lo_x": kernel.LO_X, "hi_x": kernel.HI_X, "lo_y": kernel.LO_Y, "hi_y": kernel.HI_Y}
        return result | ({name: model.field(row, slot) for name, row in bounds.items()} if result["w_window"] else {})

    def _bound(self, name: str) -> int:
        """As the model has it: cut off at the edges of the sensor."""
        bits, most = (EDGE_BITS_X, 127) if name.endswith("x") else (EDGE_BITS_Y, 63)
        zero = 1 << bits - 1
        at = int(self.sim.io[f"w_{name}"]) if name[0] == "h" else 2 * zero - 1 - int(self.sim.io[f"w_{name}_not"])
        return min(max(at - zero, 0), most)

    def _check(self, due: list[tuple[str, dict[str, int]]]) -> None:
        io = self.sim.io
        assert int(io.m_cm_valid) == any(stage == "record" for stage, _ in due)
        for stage, values in due:
            if stage == "record":
                assert {name: int(io[f"m_cm_{name}"]) for name in values} == values
                self.n_records[Kind(values["kind"]).name] += 1
            else:
                ports = {name: self._bound(name) if name[:2] in ("lo", "hi") else int(io[name]) for name in values}
                assert ports == values, f"{stage} at clock {self._now}"


def registers(rng: np.random.Generator | None = None, **values: int) -> np.ndarray:
    """Of all slots: random ones, or a seeded slot of calm ones; then what is given."""
    given = {
        "mode": int(Mode.SEEDED), "init_cm_x": 20, "init_cm_y": 30, "init_radix": 4, "radix_th": 2, "radix_step": 1,
        "radix_min": 2, "radix_max": 9, "hist_avg": 1, "max_ticks": 50, "clust_nev": 4, "nev_min": 2, "nev_max": 9,
        "nev_th": 3, "detect_ticks": 20,
    }  # fmt: skip
    table = np.empty((len(REGISTERS), N), np.int64)
    for slot in range(N):
        if rng is not None:
            low, start, high = (int(v) for v in np.sort(rng.integers(0, 20, 3)))
            few, usual, many = (int(v) for v in np.sort(rng.integers(1, 16, 3)))
            given |= {
                "mode": int(rng.choice([Mode.FIXED, Mode.SEEDED])), "init_cm_x": int(rng.integers(128)),
                "init_cm_y": int(rng.integers(64)), "init_radix": start, "radix_min": low, "radix_max": high,
                "radix_th": int(rng.integers(0, 12)), "radix_step": int(rng.integers(0, 6)),
                "hist_avg": int(rng.integers(0, 4)), "max_ticks": int(rng.integers(64)),
                "detect_ticks": int(rng.integers(64)), "clust_nev": usual, "nev_min": few, "nev_max": many,
                "nev_th": int(rng.integers(0, 8)),
            }  # fmt: skip
        table[:, slot] = [(given | values)[name] for name in REGISTERS]
    return table


def traffic(lockstep: Lockstep, rng: np.random.Generator, count: int) -> Iterator[Item]:
    """Runs of events near a slot's centre, slots mixed or not, and now and then an operation."""
    model, slot = lockstep.model, 0
    for _ in range(count):
        if rng.random() < 0.4:
            slot = int(rng.integers(N))
        chance = rng.random()
        if chance < 0.02:
            yield Item("clear", slot)
        elif chance < 0.04:
            yield Item("look", slot, max_ticks=bool(rng.integers(2)))
        elif chance < 0.08 and model.active(slot):
            yield Item("report", slot, lost=bool(rng.integers(2)))
        elif chance < 0.1 and model.active(slot):
            x, y, g, support = (int(rng.integers(high)) for high in (2033, 1009, 32, 16))
            yield Item("join", slot, x, y, g=g, support=support)
        else:
            px, py = model.pixel(slot)
            spread = int(rng.choice([2, 8]))
            x, y = (int(np.clip(p + rng.integers(-spread, spread + 1), 0, top)) for p, top in ((px, 127), (py, 63)))
            yield Item("event", slot, x, y, ticks=int(rng.choice([0, 1, 3, 40])))


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("far", [0, 1])
def test_every_stage_says_what_the_model_computes(far: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    lockstep = Lockstep(far, registers(rng))
    lockstep.play(traffic(lockstep, rng, 1500), idle=0.2)
    assert min(lockstep.n_records.values()) > 3, lockstep.n_records


def test_the_traffic_moves_n_ev_and_g_both_ways() -> None:
    rng, changes = np.random.default_rng(9), set[str]()
    for _ in range(3):
        lockstep = Lockstep(0, registers(rng, nev_min=1, nev_max=9, nev_th=1, clust_nev=4, radix_step=2))
        lockstep.play(traffic(lockstep, rng, 1000))
        changes |= lockstep.changes
    assert changes == {f"{name} {change}" for name in ("n_ev", "g") for change in ("-1", "+0", "+1")}


class TestStories:
    def test_a_life_begins_with_its_first_event_and_is_born_with_the_last_of_its_window(self) -> None:
        lockstep = Lockstep(0, registers())
        lockstep.play([Item("event", 1, 40 + k, 30, ticks=1) for k in range(3)])
        assert lockstep.n_records["BORN"] == 0
        lockstep.play([Item("event", 1, 43, 30, ticks=1)])
        assert lockstep.n_records == {"BORN": 1, "MOVED": 0, "MERGED": 0, "LOST": 0}

    def test_a_life_of_one_event_starts_with_a_window_of_no_time(self) -> None:
        lockstep = Lockstep(0, registers(clust_nev=1, nev_min=1))
        lockstep.play([Item("event", 0, 40, 30), Item("clear", 0)])
        lockstep.play([Item("event", 0, 40, 30, ticks=60), Item("event", 0, 40, 30, ticks=10)])
        assert lockstep.model.field(kernel.N_EV, 0) == 2

    def test_tracks_are_numbered_as_they_are_born(self) -> None:
        lockstep = Lockstep(0, registers(clust_nev=1, nev_min=1))
        lockstep.play([Item("event", slot, 40, 30) for slot in (2, 0, 1)])
        assert [lockstep.model.field(kernel.ID, slot) for slot in range(N)] == [1, 2, 0]

    def test_a_record_waits_until_it_is_taken(self) -> None:
        lockstep = Lockstep(0, registers(clust_nev=1, nev_min=1))
        io = lockstep.sim.io
        lockstep.clock(0, 40, 30, NOTHING | {"c_takes": 1, "c_commits": 1, "c_seeds": 1})
        io.m_cm_ready = 0
        lockstep.wait(5)
        for _ in range(4):
            assert (io.m_cm_valid, io.m_cm_kind, io.m_cm_x) == (1, int(Kind.BORN), 40 << 4)
            lockstep.sim.clock.tick()
        io.m_cm_ready = 1
        lockstep.sim.clock.tick()
        assert io.m_cm_valid == 0

    def test_reset_forgets_the_record_and_numbers_tracks_from_0(self) -> None:
        lockstep = Lockstep(0, registers(clust_nev=1, nev_min=1))
        lockstep.play([Item("event", 0, 40, 30)])
        assert lockstep.model.field(kernel.BIRTH_COUNT, 0) == 1
        lockstep = Lockstep(0, registers(clust_nev=1, nev_min=1))  # the same hardware, reset
        assert lockstep.sim.io.m_cm_valid == 0
        lockstep.play([Item("event", 1, 40, 30)])
        assert lockstep.model.field(kernel.ID, 1) == 0
