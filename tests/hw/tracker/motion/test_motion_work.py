# SPDX-License-Identifier: Apache-2.0
"""motion_work.v: the jobs of random scenes, one after the other, against records and effects of the slow model.

The pipeline of events is not there: what it has of a slot at the cause of a job is that of the slow model.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from evcot.hardware.motion.contract import MotionRegisters
from evcot.tracks.log import Kind
from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load
from support.moving import QUICK, registers_word
from support.slow_motion import PX, Axis, Record, Slot, SlowArray

N, SLOT_W, X_W, Y_W, SIDE_W, PX_W, REL_W, SUP_W, ID_W, TIME_W = 5, 3, 7, 6, 25, 13, 6, 9, 3, 36
WIDTHS = {
    "N": N, "SLOT_W": SLOT_W, "X_W": X_W, "Y_W": Y_W, "SIDE_W": SIDE_W, "PX_W": PX_W, "REL_W": REL_W, "SUP_W": SUP_W,
    "ID_W": ID_W, "TIME_W": TIME_W,
}  # fmt: skip
MOST = (1 << SUP_W) - 1
LONGEST = 3_000  # clocks of a job
LOOK = 47  # clocks of motion_gaps.v
KINDS = ("correction", "seed", "step", "end")
BUSY = {
    "birth_support": 1, "birth_px": 0, "birth_ticks": 0, "birth_travel": 8, "ring_px": 1, "ring_max": 2, "join_px": 6,
    "join_steps": 2, "join_life": 15, "join_speed": 0, "gap_corrections": 3, "step_log2": 7, "side_step": 3_000,
    "detect_ticks": 1_500, "life_ticks": 1_500, "coast_ticks": 4_000, "nev_high": 12,
}  # fmt: skip
CASES = {
    "support": BUSY,
    "older stays": {**BUSY, "keep_older": 1, "gap_corrections": 1, "side_shrink": 0},
    "tracks return": {**BUSY, "return_ticks": 3_000, "coast_ticks": 1_500},
    "at rest": {**BUSY, "speed_max": 0},
    "bursts": BUSY,
}


def signed(value: int, bits: int) -> int:
    return value - (value >> (bits - 1) << bits)


def packed(values: list[int], bits: int) -> int:
    word = 0
    for value in values:
        word = word << bits | value % (1 << bits)
    return word


def unpacked(word: int, bits: int) -> list[int]:
    return [signed(word >> bits * (3 - i) & (1 << bits) - 1, bits) for i in range(4)]


class Jobs(SlowArray):
    """The slow model; its jobs also say what is in bins, and whether a candidate is not in effect yet."""

    def _cause(self, kind: str, slot: Slot, now: int) -> dict[str, Any]:
        more = {"bins": [list(axis.bins) for axis in slot.axes], "fresh": slot is self.seeded}
        return super()._cause(kind, slot, now) | more

    def _effect(self, slot: Slot, void: bool, ended: list[int]) -> dict[str, Any]:
        return super()._effect(slot, void, ended) | {"looked": slot.looked}

    def end(self, number: int, now: int) -> None:
        """The life of a slot ends from outside."""
        self._take_effect(1 << 62, now)
        slot = self.slots[number]
        if slot is not None:
            self.jobs.append((self._cause("end", slot, now), {"void": False, "state": 0, "ended": []}))
        self.restart(number, now)


class Work:
    """The module, and its jobs one after the other."""

    def __init__(self, registers: MotionRegisters, *, stalls: bool) -> None:
        self.sim, self.rng = load("motion_work", WIDTHS, extra_flags=PORTS_ONLY_FLAGS), np.random.default_rng(1)
        self.io, self.stalls, self.r = self.sim.io, stalls, registers
        self.records: list[Record] = []
        self.cause: dict[str, Any] = {}
        self.look_in = self.found = self.paused = 0
        self.merges = False
        self.finished = self.masked = 0
        self.ended: list[int] = []
        self.cleared: list[tuple[int, int]] = []
        self.io.regs = registers_word(registers)
        self.io.rst = 1
        self.sim.clock.tick()
        self.io.rst = 0

    def clock(self) -> None:
        io = self.io
        io.record_free = int(not self.stalls or self.rng.random() < 0.5)
        io.look_done, io.mask_busy = int(self.look_in == 1), int(self.stalls and bool(self.rng.random() < 0.5))
        self.look_in = max(self.look_in - 1, 0)
        if int(io.look):
            self.find_gap()
        if int(io.say):
            self.records.append(self.record())
        self.merges = int(io.kind) == Kind.MERGED
        self.finished += int(io.finish)
        self.masked += int(io.mask)
        if int(io.ends):
            self.ended.append(int(io.at))
        if int(io.op_clear):
            self.cleared.append((int(io.at), int(io.op_bin)))
        self.sim.clock.tick()

    def find_gap(self) -> None:
        """Answers a look as motion_gaps.v does, from the bins of the slow model."""
        io, far = self.io, 1 << 40
        axis = Axis(0, far, bins=self.cause["bins"][int(io.look_y)], bin_px=1 << int(io.look_log2))
        axis.cut(self.r.gap_share, int(io.narrowest))
        io.gap_found, io.low_stays = int((axis.lo, axis.hi) != (0, far)), int(axis.hi != far)
        io.gap_begins, io.gap_ends = axis.hi // axis.bin_px // PX % 16, axis.lo // axis.bin_px // PX % 16
        self.found += int(io.gap_found)
        self.look_in = LOOK

    def record(self) -> Record:
        io, cause = self.io, self.cause
        middle = [signed(int(io[f"sum_{axis}"]), SIDE_W + 1) >> 1 for axis in "xy"]
        sides, speeds = [int(io.side_x), int(io.side_y)], [signed(int(io.v_x), 16), signed(int(io.v_y), 16)]
        other = int(io.stays_id) if self.merges else 0
        begin = cause["seq"], cause["time"], int(io.kind), int(io.id), other
        return (*begin, *middle, *sides, *speeds, int(io.support), int(io.n_ev), int(io.at))

    def run(self, *, real: bool, flag: bool) -> None:
        """What is on the ports already, until it is done."""
        io = self.io
        io.job_real, io.job_flag = int(real), int(flag)
        self.clock()
        self.finished, self.masked, self.ended, self.cleared = 0, 0, [], []
        io.job_valid, clocks = 1, 0
        while not int(io.job_done):
            self.clock()
            clocks += 1
            assert clocks < LONGEST
        self.clock()
        io.job_valid = 0
        for _clock in range(3):
            self.clock()

    def job(self, cause: dict[str, Any]) -> None:
        io = self.io
        self.cause = cause
        kind, sides = KINDS.index(cause["kind"]), list(cause["sides"])
        if cause["fresh"]:
            sides = [0] * 4  # they are there with the effect
        if cause["kind"] == "seed":  # the address
            low_x, high_x, low_y, high_y = cause["sides"]
            sides, io.job_x, io.job_y = [0] * 4, (low_x + high_x) // 2 // PX, (low_y + high_y) // 2 // PX
        empty, self.paused = (
            (cause["time"] - cause["counted"] - self.paused) >> self.r.step_log2,
            cause["time"] - cause["counted"],
        )
        with_step = bool(empty) and (cause["kind"], cause["slot"]) == ("step", 0)
        io.job_kind = KINDS.index("step")
        for _ in range(empty - with_step):
            self.run(real=False, flag=True)
            assert not self.finished
        io.job_kind, io.job_slot, io.job_waits, io.job_owned = kind, cause["slot"], int(cause["waits"]), cause["owned"]
        io.job_sides, io.job_time, io.e_slot = packed(sides, SIDE_W), cause["time"], cause["slot"]
        io.job_marks = sum(1 << i for i in range(4) if cause["marks"][i])
        self.run(real=True, flag=with_step or cause["in_burst"] or cause["kind"] == "seed")

    def agrees(self, effect: dict[str, Any]) -> None:
        """What takes effect of the last job."""
        io, cause = self.io, self.cause
        assert self.finished == (not effect["void"])
        assert sorted(self.ended) == effect["ended"]
        clears = cause["kind"] == "seed" or (cause["kind"] == "correction" and self.r.gap_corrections and not effect["looked"])
        expected = [(cause["slot"], number) for number in range(16)] if clears and not effect["void"] else []
        assert self.cleared == expected
        if effect["void"]:
            return
        assert int(io.e_state) == effect["state"]
        if cause["kind"] == "end" or not effect["state"]:
            return
        begin = cause["sides"] if cause["fresh"] else [0] * 4
        assert unpacked(int(io.e_moves), SIDE_W) == [move + side for move, side in zip(effect["moves"], begin, strict=True)]
        assert int(io.e_marks) == 15 * effect["mark_all"]
        assert int(io.e_hidden) == sum(1 << i for i in range(4) if effect["hidden"][i])
        if effect["state"] != 3:  # what has left holds no event
            assert (unpacked(int(io.box), PX_W), unpacked(int(io.window), PX_W)) == (effect["box"], effect["window"])
            assert self.masked >= 1
            low_x, high_x, low_y, high_y = effect["box"]
            assert int(io.e_middle) == packed([low_y + high_y, low_x + high_x], REL_W)
        assert int(io.e_n_ev) == effect["n_ev"]
        assert int(io.bin_log2) == effect["bin_log2"][1] << 5 | effect["bin_log2"][0]


def groups(rng: np.random.Generator, n: int) -> list[tuple[int, int, int]]:
    """Events of three dots side by side, which move together and begin elsewhere every 300 events; with pauses."""
    part, i = np.divmod(np.arange(n), 300)
    begin, way = rng.integers((20, 15), (80, 50), (n // 300 + 1, 2))[part], rng.integers(-20, 20, (n // 300 + 1, 2))[part]
    place = begin + way * i[:, None] / 300 + rng.normal(0, 1.5, (n, 2))
    place[:, 0] += 14 * rng.integers(3, size=n)
    x, y = np.clip(np.rint(place).astype(int), 0, (127, 63)).T
    ticks = np.cumsum(rng.integers(0, 20, n) + np.where(rng.random(n) < 0.003, 3_000, 0))
    return [(int(tick), int(at_x), int(at_y)) for tick, at_x, at_y in zip(ticks, x, y, strict=True)]


@pytest.mark.parametrize("name", CASES)
def test_jobs_of_random_scenes(name: str) -> None:
    """Few births are refused and much is one object, so that slots end, merge and grow often."""
    registers = replace(QUICK, **CASES[name])
    slow, work = Jobs(registers, N, MOST, (1 << ID_W) - 1), Work(registers, stalls=name != "support")
    rng, done, now = np.random.default_rng(2), 0, 0
    void = ended = 0
    for time, x, y in groups(rng, 2_400):
        tick = time // 1_500 * 1_500 if name == "bursts" else time
        if rng.random() < 0.003:
            slow.end(int(rng.integers(N)), now)
        now = tick
        slow.event(now, x, y)
        for cause, effect in slow.jobs[done:]:
            work.job(cause)
            work.agrees(effect)
            void, ended = void + effect["void"], ended + len(effect["ended"])
        done = len(slow.jobs)
        assert work.records == slow.records
    assert {record[2] for record in work.records} == set(Kind)
    assert (work.found > 0) == (registers.speed_max > 0)  # of what rests no bins are looked at
    assert work.paused
    assert min(void, ended) > 10
