# SPDX-License-Identifier: Apache-2.0
"""motion_work.v: corrections, candidates, motion steps and ends of lives of several slots, against the slow model.

The pipeline of events is not there: what events would do to sides and supports is drawn at random.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evcot.hardware.motion.contract import MotionRegisters
from evcot.tracks.log import Kind
from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load
from support.motion_word import registers_word
from support.moving import QUICK
from support.slow_motion import PX, Axis, Record, Slot, SlowArray, gap
from support.testing import lint

N, SLOT_W, X_W, Y_W, SIDE_W, PX_W, SUP_W, ID_W, SEQ_W, TIME_W = 5, 3, 7, 6, 25, 13, 9, 3, 16, 36
WIDTHS = {
    "N": N, "SLOT_W": SLOT_W, "X_W": X_W, "Y_W": Y_W, "SIDE_W": SIDE_W, "PX_W": PX_W, "SUP_W": SUP_W, "ID_W": ID_W,
    "SEQ_W": SEQ_W, "TIME_W": TIME_W,
}  # fmt: skip
MOST = (1 << SUP_W) - 1
LONGEST = 3_000  # clocks of a job or a step
Sides = list[int]
BUSY = {
    "birth_support": 1, "birth_px": 0, "birth_ticks": 0, "birth_travel": 8, "ring_px": 1, "ring_max": 2, "join_px": 40,
    "join_steps": 2, "join_life": 15, "join_speed": 0, "life_ticks": 150, "coast_ticks": 200, "detect_ticks": 120,
    "gap_corrections": 3, "life_log2": 1,
}  # fmt: skip
CASES = {
    "support": {},
    "older stays": {"keep_older": 1, "gap_corrections": 1, "side_shrink": 0},
    "at rest": {"speed_max": 0},
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


class Memory:
    """What the pipeline of events has of a slot."""

    def __init__(self) -> None:
        self.sides: Sides = [0] * 4
        self.marks = self.hidden = self.support = 0
        self.box: Sides = [1, 0, 1, 0]
        self.window: Sides = [1, 0, 1, 0]

    def take(self, slot: Slot) -> None:
        """What events have made of a slot."""
        self.sides = [side for axis in slot.axes for side in (axis.lo, axis.hi)]
        marks = [mark for axis in slot.axes for mark in axis.beyond]
        self.marks = sum(1 << i for i in range(4) if marks[i])
        self.support = slot.support

    def agrees(self, slot: Slot) -> None:
        assert self.sides == [side for axis in slot.axes for side in (axis.lo, axis.hi)]
        for name, values in (("marks", "beyond"), ("hidden", "hidden")):
            bits = [bit for axis in slot.axes for bit in getattr(axis, values)]
            assert getattr(self, name) == sum(1 << i for i in range(4) if bits[i]), name
        assert self.support == slot.support


class Work:
    """The module, and the slow model beside it."""

    def __init__(self, registers: MotionRegisters, seed: int, *, stalls: bool) -> None:
        self.sim, self.rng = load("motion_work", WIDTHS, extra_flags=PORTS_ONLY_FLAGS), np.random.default_rng(seed)
        self.io, self.stalls, self.r = self.sim.io, stalls, registers
        self.slow = SlowArray(registers, N, MOST, (1 << ID_W) - 1)
        self.memory = [Memory() for _ in range(N)]
        self.records: list[Record] = []
        self.under_way: list[tuple[int, str, int]] = []  # clock in which an operation is done
        self.was_under_way = self.under_way
        self.answers: list[Sides] = [[0] * 4] * 2
        self.clocks = self.look_in = self.found = 0
        self.bins: list[list[int]] = []
        self.merges = self.ready = False
        self.io.regs = registers_word(registers)
        self.io.rst = 1
        self.sim.clock.tick()
        self.io.rst = 0

    def clock(self) -> None:
        io = self.io
        ready = not self.stalls or not self.ready or bool(self.rng.random() < 0.7)
        io.op_ready, io.record_free = int(ready), int(not self.stalls or self.rng.random() < 0.5)
        done = [(what, slot) for due, what, slot in self.under_way if due == self.clocks]
        io.read_done, io.store_done = int("read" in [what for what, _ in done]), int("store" in [what for what, _ in done])
        if any(what == "read" for _, what, _ in self.was_under_way):  # another slot's, but for the clock in which they are read
            io.r_sides, io.r_marks, io.r_support = int.from_bytes(self.rng.bytes(12)), 5, int(self.rng.integers(MOST))
        for what, slot in done:
            self.operation(what, slot)
        asked = self.answers.pop(0)
        places = (asked[0], asked[1]), (asked[2], asked[3])
        for port in ("in_box", "in_window"):
            held = [getattr(memory, port.removeprefix("in_")) for memory in self.memory]
            share = [all(gap((h[2 * i], h[2 * i + 1]), places[i]) <= 0 for i in (0, 1)) for h in held]
            setattr(io, port, sum(1 << i for i in range(N) if share[i]))
        boxes = [(memory.box[:2], memory.box[2:]) for memory in self.memory]
        line = [any(gap((a[0], a[1]), b) <= 0 for a, b in zip(box, places, strict=True)) for box in boxes]
        io.in_line = sum(1 << i for i in range(N) if line[i])
        self.answers.append(unpacked(int(io.ask_for), PX_W) if int(io.ask) else [0] * 4)
        io.look_done = int(self.look_in == 1)
        self.look_in = max(self.look_in - 1, 0)
        if int(io.look):
            self.find_gap()
        if int(io.say):
            self.records.append(self.record())
        self.merges = int(io.kind) == Kind.MERGED
        if int(io.op_valid) and ready:
            slot = int(io.at)
            for what, after in (("read", 6), ("store", 6), ("full", 6), ("put", 2)):
                if int(io[f"op_{what}"]):
                    self.under_way.append((self.clocks + after, what, slot))
        self.was_under_way = self.under_way
        self.under_way = [entry for entry in self.under_way if entry[0] > self.clocks]
        self.ready = ready
        self.sim.clock.tick()
        self.clocks += 1

    def operation(self, what: str, slot: int) -> None:
        """What it reads or writes of a slot."""
        io, memory = self.io, self.memory[slot]
        if what == "read":
            io.r_sides, io.r_marks, io.r_support = packed(memory.sides, SIDE_W), memory.marks, memory.support
        elif what == "store":
            memory.sides, memory.marks, memory.hidden = unpacked(int(io.o_sides), SIDE_W), int(io.o_marks), int(io.o_hidden)
        elif what == "full":
            memory.support = int(io.o_support)
        else:
            memory.box, memory.window = unpacked(int(io.o_box), PX_W), unpacked(int(io.o_window), PX_W)

    def find_gap(self) -> None:
        """Answers a look as motion_gaps.v does, from the bins of the slow model."""
        io, slot, far = self.io, self.bins[int(self.io.look_y)], 1 << 40
        axis = Axis(0, far, bins=slot, bin_px=1 << int(io.look_log2))
        axis.cut(self.r.gap_share, int(io.narrowest))
        io.gap_found, io.low_stays = int((axis.lo, axis.hi) != (0, far)), int(axis.hi != far)
        io.gap_begins, io.gap_ends = axis.hi // axis.bin_px // PX % 16, axis.lo // axis.bin_px // PX % 16
        self.found += int(io.gap_found)
        self.look_in = 61

    def record(self) -> Record:
        io = self.io
        middle = [signed(int(io[f"sum_{axis}"]), SIDE_W + 1) >> 1 for axis in "xy"]
        sides, speeds = [int(io.side_x), int(io.side_y)], [signed(int(io.v_x), 16), signed(int(io.v_y), 16)]
        other = int(io.stays_id) if self.merges else 0
        support, slot = int(io.o_support), int(io.at)
        return (
            int(io.op_seq),
            int(io.op_time),
            int(io.kind),
            int(io.id),
            other,
            *middle,
            *sides,
            *speeds,
            support,
            int(io.n_ev),
            slot,
        )

    # ---- what is done, on both sides

    def living(self) -> list[Slot]:
        return [slot for slot in self.slow.slots if slot is not None]

    def disturb(self) -> None:
        """What events may have done to slots since."""
        rng = self.rng
        for slot in self.living():
            for axis in slot.axes:
                drift = rng.choice([1, 1, -1]) * PX // 3
                ways = [int(way) for way in rng.normal(drift, 0.5 * PX, 2)] if rng.random() < 0.8 else [0, 0]
                axis.lo, axis.hi = axis.lo + ways[0], axis.hi + ways[1]
                axis.off = [off + way for off, way in zip(axis.off, ways, strict=True)]
                axis.beyond = [mark or bool(rng.random() < 0.4) for mark in axis.beyond]
            slot.support = min(slot.support + int(rng.integers(12)), MOST)
            self.memory[slot.number].take(slot)

    def job(self, slot: Slot, now: int, place: tuple[int, int], *, seeds: bool) -> None:
        io, slow = self.io, self.slow
        slow.owners.append(slot.number)
        self.bins = [list(axis.bins) for axis in slot.axes]
        io.job_valid, io.job_seed, io.job_slot, io.job_support = 1, int(seeds), slot.number, slot.support
        (io.job_x, io.job_y), io.job_time, io.job_seq = place, now, len(slow.owners) - 1
        begun = self.clocks
        while not int(io.job_done):
            self.clock()
            assert self.clocks - begun < LONGEST
        self.clock()
        io.job_valid = 0
        if not seeds:
            slot.correct(now)
            if slot.visible:
                slow._record(slot, Kind.MOVED, now, len(slow.owners) - 1)
        self.clock()
        # It is put in force.
        io.puts, io.put_slot = 1, slot.number
        self.under_way.append((self.clocks + 1, "put", slot.number))
        self.clock()
        self.clock()
        io.begins, io.begins_slot = int(seeds), slot.number
        self.clock()
        io.begins = 0
        slot.put_in_force()
        assert int(io.o_n_ev) == slot.n_ev
        io.puts = 0
        self.memory[slot.number].hidden = 0 if seeds else self.memory[slot.number].hidden
        self.memory[slot.number].support = slot.support

    def step(self, number: int, now: int) -> None:
        io = self.io
        self.clock()  # nothing was under way in it
        io.do_step, io.work_slot, io.now, io.seq = 1, number, now, len(self.slow.owners)
        self.until_it_rests()
        slot = self.slow.slots[number]
        if slot is not None:
            self.slow._step(slot, now)

    def end(self, slot: Slot, now: int) -> None:
        io = self.io
        self.clock()
        io.do_end, io.work_slot, io.now, io.seq = 1, slot.number, now, len(self.slow.owners)
        self.until_it_rests()
        if slot.visible:
            self.slow._record(slot, Kind.LOST, now)
        self.slow.slots[slot.number] = None

    def until_it_rests(self) -> None:
        self.clock()
        self.io.do_step = self.io.do_end = 0
        begun = self.clocks
        while not int(self.io.rests) or self.clocks < begun + 2:
            self.clock()
            assert self.clocks - begun < LONGEST
        self.clock()  # a life that ends alone ends in the first clock of rest

    def agrees(self) -> None:
        io = self.io
        assert self.records == self.slow.records
        assert int(io.rests)
        assert int(io.visible) == sum(1 << slot.number for slot in self.living() if slot.visible)
        assert int(io.candidate) == sum(1 << slot.number for slot in self.living() if not slot.visible)
        for slot in self.living():
            memory = self.memory[slot.number]
            memory.agrees(slot)
            assert memory.box == [bound for axis in slot.axes for bound in axis.box]
            assert memory.window == [bound for axis in slot.axes for bound in axis.window]


@pytest.mark.parametrize("name", CASES)
def test_random_work(name: str) -> None:
    """Few births are refused and much is one object, so that slots end, merge and grow often."""
    registers = replace(QUICK, **{**BUSY, **CASES[name]})
    work = Work(registers, 10, stalls=name != "support")
    rng, now = work.rng, 0
    for _ in range(300):
        now += int(rng.integers(1, 20))
        while work.slow.step_tick <= now:
            work.disturb()
            work.step(work.slow.step_slot, work.slow.step_tick)
            work.slow.step_tick, work.slow.step_slot = next(work.slow.steps)
            work.agrees()
        work.disturb()
        living = work.living()
        free = [i for i in range(N) if work.slow.slots[i] is None]
        if free and (len(living) < 2 or rng.random() < 0.2):
            place = int(rng.integers(20, 100)), int(rng.integers(10, 50))
            slot = Slot(free[0], registers, *place, now)
            work.slow.slots[free[0]] = slot
            work.job(slot, now, place, seeds=True)
        elif rng.random() < 0.04:
            work.end(living[int(rng.integers(len(living)))], now)
        else:
            youngest = min(living, key=lambda slot: slot.corrections)
            slot = youngest if rng.random() < 0.6 else living[int(rng.integers(len(living)))]
            for axis in slot.axes:
                axis.bins = [int(number) for number in rng.integers(0, 4, 16) * (rng.random(16) < 0.5)]
            work.job(slot, now, (0, 0), seeds=False)
        work.agrees()
    kinds = [record[2] for record in work.records]
    assert set(kinds) == set(Kind)
    assert (work.found > 0) == (registers.speed_max > 0)  # of what rests no bins are looked at


def test_lint() -> None:
    assert lint("motion_work") == (0, "")
