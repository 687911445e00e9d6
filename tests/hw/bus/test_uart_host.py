# SPDX-License-Identifier: Apache-2.0
"""uart_host.v between a host that asks over a line, registers that answer at any pace, and records that want to go out."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain, repeat

import numpy as np
import pytest

from evcot_cosim.devices.base import reset
from evcot_cosim.fpga.serial_host import BYTE_BITS, Receiver, levels, request
from evcot_cosim.rtl.build import load
from support.testing import PATTERNS, Word, always, sometimes

TOP = "uart_host"
DIVISOR, TIMEOUT = 4, 20
BYTE = BYTE_BITS * DIVISOR
OKAY, SLVERR = 0, 2


def response(address: int) -> int:
    return SLVERR if address & 0x8000 else OKAY


# What the hardware asks for, and everything that waits for a ready.
ASKS = {"m_axil_aw": "addr", "m_axil_w": "data", "m_axil_ar": "addr"}
BUNDLES = (*ASKS, "m_axil_b", "m_axil_r", "s_axis_t")


class Desk:
    """The hardware with registers on its bus, of which those from 0x8000 on refuse every access.

    Attributes:
        words: what has been written, by address.
        receiver: the bytes that the host receives.
        beat: the next of the records' that the hardware has not taken, None at the end.
    """

    def __init__(self, pattern: Iterator[bool], beats: Iterable[Word] = (), beat_pattern: Iterator[bool] | None = None) -> None:
        self.sim = load(TOP, {"DIVISOR": DIVISOR, "TIMEOUT": TIMEOUT, "ADDR_W": 16})
        self.sim.io.rx = 1
        reset(self.sim)
        self.words: dict[int, int] = {}
        self.receiver = Receiver(DIVISOR)
        self._beats = iter(beats)
        self.beat = next(self._beats, None)
        self._pattern, self._beat_pattern = pattern, beat_pattern or always()
        self._asked: dict[str, int] = {}  # what was taken and is not answered yet
        self._waits: dict[str, int] = {}  # what is on offer and was not taken

    def clock(self, level: int = 1) -> None:
        """One clock, with this on the host's line."""
        io = self.sim.io
        io.rx = level
        self._drive()
        self.receiver.sample(int(io.tx))
        asks = {bundle: int(io[bundle + field]) for bundle, field in ASKS.items() if io[f"{bundle}valid"]}
        assert asks | self._waits == asks  # nothing on offer has changed or gone
        moves = {bundle for bundle in BUNDLES if io[f"{bundle}valid"] and io[f"{bundle}ready"]}
        self.sim.clock.tick()
        self._waits = {bundle: value for bundle, value in asks.items() if bundle not in moves}
        self._asked |= {bundle: value for bundle, value in asks.items() if bundle in moves}
        for bundle in moves - ASKS.keys():
            io[f"{bundle}valid"] = 0
        if "m_axil_b" in moves:
            address, value = self._asked.pop("m_axil_aw"), self._asked.pop("m_axil_w")
            self.words |= {} if address & 0x8000 else {address: value}
        if "m_axil_r" in moves:
            del self._asked["m_axil_ar"]
        if "s_axis_t" in moves:
            self.beat = next(self._beats, None)

    def _drive(self) -> None:
        """The inputs for the next clock edge, but the line."""
        io, asked = self.sim.io, self._asked
        for bundle in ASKS:
            io[f"{bundle}ready"] = int(bundle not in asked and next(self._pattern))
        if {"m_axil_aw", "m_axil_w"} <= asked.keys():
            io.m_axil_bvalid = int(io.m_axil_bvalid) or int(next(self._pattern))
            io.m_axil_bresp = response(asked["m_axil_aw"])
        if "m_axil_ar" in asked:
            io.m_axil_rvalid = int(io.m_axil_rvalid) or int(next(self._pattern))
            io.m_axil_rresp, io.m_axil_rdata = response(asked["m_axil_ar"]), self.words.get(asked["m_axil_ar"], 0)
        if self.beat is not None and not io.s_axis_tvalid and next(self._beat_pattern):
            io.s_axis_tvalid = 1
            io.s_axis_tdata, io.s_axis_tkeep, io.s_axis_tlast = self.beat

    def say(self, data: bytes) -> None:
        """The host's bytes, one after another."""
        for level in levels(data, DIVISOR):
            self.clock(level)

    def rest(self, clocks: int) -> None:
        """The host says nothing."""
        for _ in range(clocks):
            self.clock()

    def exchange(self, *said: bytes, rest: int = 20 * BYTE) -> bytes:
        """What the host hears when it says this, each a while after the one before."""
        before = len(self.receiver.received)
        for data in said:
            self.say(data)
            self.rest(rest)
        return bytes(self.receiver.received[before:])


def with_sum(frame: bytes) -> bytes:
    """A frame to the host, its sum behind it."""
    return frame + bytes([sum(frame) & 0xFF])


def answer(kind: str, status: int = OKAY, value: int = 0) -> bytes:
    return with_sum(kind.encode() + bytes([status]) + value.to_bytes(4, "little"))


def record(*beats: Word) -> bytes:
    """The frame of a record of these beats."""
    kept = (data.to_bytes(4, "little")[i] for data, keep, _ in beats for i in range(4) if keep >> i & 1)
    return with_sum(b"c" + bytes(kept))


class TestRequests:
    def test_what_is_written_can_be_read(self) -> None:
        desk = Desk(always())
        assert desk.exchange(request("W", 0x1234, 0xCAFE_F00D)) == answer("w")
        assert desk.words == {0x1234: 0xCAFE_F00D}
        assert desk.exchange(request("R", 0x1234, 99)) == answer("r", OKAY, 0xCAFE_F00D)

    def test_a_refusal_is_told(self) -> None:
        desk = Desk(always())
        assert desk.exchange(request("W", 0x8000, 7), request("R", 0x8000)) == answer("w", SLVERR) + answer("r", SLVERR)

    def test_any_other_first_byte_is_left_out(self) -> None:
        assert Desk(always()).exchange(b"rwc\x00\xff", request("R", 4)) == answer("r")

    def test_silence_ends_a_request_that_is_not_whole(self) -> None:
        desk = Desk(always())
        first, rest = request("R", 4)[:3], request("R", 4)[3:]
        assert desk.exchange(first, rest=(TIMEOUT - BYTE_BITS - 1) * DIVISOR) + desk.exchange(rest) == answer("r")
        assert desk.exchange(first, rest=TIMEOUT * DIVISOR) == b""
        assert desk.exchange(rest, request("W", 4, 5)) == answer("w")


class TestRecords:
    BEATS: tuple[Word, ...] = ((0x0403_0201, 0b1111, 0), (0xFFFF_0605, 0b0011, 1))

    def test_the_bytes_that_keep_lets_stand_go_out(self) -> None:
        assert Desk(always(), self.BEATS * 2).exchange(b"") == record(*self.BEATS) * 2

    def test_an_answer_waits_for_the_record_that_goes_out_and_for_no_other(self) -> None:
        desk = Desk(always(), self.BEATS * 4)
        received = desk.exchange(request("R", 4), rest=40 * BYTE)
        assert received == record(*self.BEATS) + answer("r") + record(*self.BEATS) * 3

    def test_an_answer_goes_first_where_a_record_comes_at_the_same_clock(self) -> None:
        whole = {answer("r") + record(*self.BEATS), record(*self.BEATS) + answer("r")}
        seen = {
            Desk(always(), self.BEATS, chain(repeat(False, 7 * BYTE + later), always())).exchange(request("R", 4))
            for later in range(-4, 9)
        }
        assert seen == whole

    def test_a_record_whose_beats_come_late_is_not_mixed_with_an_answer(self) -> None:
        late = chain([True], repeat(False, 12 * BYTE), always())
        desk = Desk(always(), self.BEATS, late)
        assert desk.exchange(request("R", 4), rest=30 * BYTE) == record(*self.BEATS) + answer("r")


@pytest.mark.parametrize("pace", ["rarely", "bursts"])
def test_random_requests_and_records_at_any_pace(pace: str) -> None:
    """Answers in the order of the requests, records in theirs, each frame whole."""
    rng = np.random.default_rng([79, len(pace)])
    records = [tuple((int(rng.integers(1 << 32)), 0b1111, int(i == 2)) for i in range(3)) for _ in range(12)]
    desk = Desk(PATTERNS[pace](rng), (beat for each in records for beat in each), sometimes(rng, 0.01))
    wanted = []
    for _ in range(8):
        kind, address, value = str(rng.choice(["R", "W"])), int(rng.choice([0, 4, 0x7FFC, 0x8000])), int(rng.integers(1 << 32))
        read = desk.words.get(address, 0) if kind == "R" else 0
        wanted.append(answer(kind.lower(), response(address), read))
        desk.say(request(kind, address, value))
        desk.rest(35 * BYTE)
        assert kind == "R" or address & 0x8000 or desk.words[address] == value
    desk.rest(100 * BYTE)
    assert desk.beat is None
    received, frames = bytes(desk.receiver.received), []
    while received:
        length = 14 if received[:1] == b"c" else 7
        frames.append(received[:length])
        received = received[length:]
    assert [frame for frame in frames if frame[:1] != b"c"] == wanted
    assert [frame for frame in frames if frame[:1] == b"c"] == [record(*each) for each in records]
