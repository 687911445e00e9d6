# SPDX-License-Identifier: Apache-2.0
"""motion_engine.v with its program, against the slow model: slots seeded, corrected and moved, whatever their sides are."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from evcot.hardware.contract import Shape
from evcot.hardware.motion.contract import MotionRegisters
from evcot.hardware.motion.program.assembler import REGISTERS, Hot, Out, Value
from evcot.hardware.motion.program.program import program
from evcot.tracks.log import Kind
from evcot_cosim.lockstep.random_runs import random_motion
from evcot_cosim.rtl.build import load
from support.slow_motion import PX, Axis, Record, Slot, SlowArray, gap
from support.testing import lint

N, SLOT_W, W, Y_W, SUP_W = 5, 3, 48, 39, 9
ENTRIES = program()[1]
NAMES = {number: name for name, number in REGISTERS.items()}


def signed(value: int, bits: int) -> int:
    value %= 1 << bits
    return value - (value >> (bits - 1) << bits)


@dataclass
class Words:
    """What events change of a slot, on both axes."""

    lo: list[int] = field(default_factory=lambda: [0, 0])
    hi: list[int] = field(default_factory=lambda: [0, 0])
    off_lo: list[int] = field(default_factory=lambda: [0, 0])
    off_hi: list[int] = field(default_factory=lambda: [0, 0])
    beyond: list[int] = field(default_factory=lambda: [0, 0])
    hidden: list[int] = field(default_factory=lambda: [0, 0])
    scale: list[int] = field(default_factory=lambda: [0, 0])
    support: int = 0
    n_ev: int = 0
    bounds: list[list[int]] = field(default_factory=lambda: [[0, 0] for _ in range(4)])  # box and window, low and high


class Bench:
    """The engine, and around it what cot_motion.v has there."""

    def __init__(self, registers: MotionRegisters) -> None:
        self.sim = load("motion_engine", {"N": N, "SLOT_W": SLOT_W, "W": W, "Y_LANE_W": Y_W, "TIME_W": 48})
        self.io, self.registers = self.sim.io, registers
        self.io.rst, self.io.go, self.io.record_free, self.io.dividing, self.io.looking = 1, 0, 1, 0, 0
        self.tick()
        self.tick()
        self.io.rst = 0
        self.words = [Words() for _ in range(N)]
        self.bins: list[list[list[int]]] = [[[0] * 16, [0] * 16] for _ in range(N)]
        self.records: list[dict[Out, tuple[int, int]]] = []
        self.now, self.event, self.births, self.kind = 0, (0, 0), 0, 0
        self.asked = [[0, 0], [0, 0]]
        self.divisor, self.gap_bin = 1, 0

    def tick(self) -> None:
        self.sim.clock.tick()

    def value(self, index: int) -> tuple[int, int]:
        divisor, reach = self.divisor, 512 * PX
        exponent = divisor.bit_length() - 1
        specials = {
            Value.NOW: self.now, Value.OTHER: int(self.io.other), Value.BIRTHS: self.births, Value.LEADING: exponent,
            Value.INVERSE: round(1024 / (8.5 + (divisor * 8 >> exponent) - 8)), Value.GAP_BIN: self.gap_bin,
            Value.HALF: PX // 2, Value.TWO: 2 * PX, Value.REACH_LO: -reach, Value.REACH_HI: 2 * reach,
            Value.TICKS_MAX: 2**24 - 1,
            Value.TOGETHER_MAX: 65_535, Value.SUPPORT_MAX: 2**SUP_W - 1,
        }  # fmt: skip
        if index == Value.EVENT:
            return self.event[0] * PX, self.event[1] * PX
        if index in NAMES:
            return (int(getattr(self.registers, NAMES[index])),) * 2
        return (specials.get(Value(index), 0) if index in set(Value) else 0,) * 2  # else what lies behind a jump

    def hot(self, slot: int, index: int) -> list[int]:
        words = self.words[slot]
        return {
            Hot.LO: words.lo, Hot.HI: words.hi, Hot.OFF_LO: words.off_lo, Hot.OFF_HI: words.off_hi,
            Hot.SUPPORT: [words.support] * 2, Hot.N_EV: [words.n_ev] * 2,
            Hot.BEYOND: [3 - marks for marks in words.beyond], Hot.BINS: words.scale,
        }.get(Hot(index), [0, 0])  # fmt: skip

    def write(self, lane: int, slot: int, target: Hot, data: int) -> None:
        words = self.words[slot]
        if target is Hot.BINS:
            words.scale[lane] = max(0, data.bit_length() - 3)
            self.bins[slot][lane] = [0] * 16
        elif target is Hot.SUPPORT:
            words.support = data
        elif target is Hot.N_EV:
            words.n_ev = data
        elif target is not Hot.WLO:
            name = {
                Hot.LO: "lo", Hot.HI: "hi", Hot.OFF_LO: "off_lo", Hot.OFF_HI: "off_hi", Hot.BEYOND: "beyond",
                Hot.HIDDEN: "hidden",
            }[target]  # fmt: skip
            getattr(words, name)[lane] = data

    def look(self, lane: int, slot: int, narrowest: int) -> None:
        axis = Axis(0, 1 << 40, bins=self.bins[slot][lane], bin_px=1 << self.words[slot].scale[lane])
        axis.cut(self.registers.gap_share, narrowest)
        cut = axis.hi if axis.hi != 1 << 40 else axis.lo
        self.io.gap_found, self.io.low_stays = int(cut != 0 or axis.hi != 1 << 40), int(axis.hi != 1 << 40)
        self.gap_bin = cut // (axis.bin_px * PX)

    def out(self, target: Out, slot: int, x: int, y: int) -> None:
        if target <= Out.PLACE_WHI:
            self.words[slot].bounds[target] = [x, y]
        elif target in (Out.ASK_LO, Out.ASK_HI):
            self.asked[target - Out.ASK_LO] = [x, y]
            self.hits()
        elif target is Out.BORN:
            self.births += 1
        elif target is Out.DIVISOR:
            self.divisor = x
        elif target in (Out.LOOK_X, Out.LOOK_Y):
            self.look(target - Out.LOOK_X, slot, y if target is Out.LOOK_Y else x)
        elif target is Out.KIND:
            self.kind = x
        elif target is Out.HEAD:
            self.records.append({Out.KIND: (self.kind, 0), Out.HEAD: (slot, self.now)})
        elif Out.MIDDLE <= target <= Out.SUPPORT:
            self.records[-1][target] = (x, y)

    def hits(self) -> None:
        for name, low, axis in (("box_x", 0, 0), ("box_y", 0, 1), ("window_x", 2, 0), ("window_y", 2, 1)):
            asked = (self.asked[0][axis], self.asked[1][axis])
            bounds = [(words.bounds[low][axis], words.bounds[low + 1][axis]) for words in self.words]
            setattr(self.io, name, sum(1 << i for i in range(N) if gap(asked, bounds[i]) <= 0))

    def run(self, entry: str, slot: int, now: int) -> int:
        """Returns how many clocks it took."""
        io = self.io
        self.now = now
        io.entry, io.go_slot, io.go = ENTRIES[entry], slot, 1
        self.tick()
        io.go = 0
        values: list[tuple[int, int]] = [(0, 0), (0, 0)]
        clocks = before = 0
        while int(io.busy) or int(io.out):
            values.append(self.value(int(io.value_index)) if int(io.value_wanted) else (0, 0))
            words = self.hot(before, int(io.hot_index)) if int(io.hot_wanted) else [0, 0]
            before = int(io.hot_slot)
            x, y = signed(int(io.out_x), W), signed(int(io.out_y), Y_W)
            target, at = int(io.target), int(io.out_slot)
            outs, writes = int(io.out), (int(io.hot_write_x), int(io.hot_write_y))
            self.tick()
            clocks += 1
            io.hot_x, io.hot_y = words[0] % (1 << W), words[1] % (1 << W)
            values.pop(0)
            io.value_x, io.value_y = values[0][0] % (1 << W), values[0][1] % (1 << W)
            if outs:
                self.out(Out(target), at, x, y)
            for lane in (0, 1):
                if writes[lane]:
                    self.write(lane, at, Hot(target), (x, y)[lane])
            assert clocks < 20_000
        return clocks


def compare(bench: Bench, array: SlowArray) -> None:
    visible = sum(1 << slot.number for slot in array.slots if slot is not None and slot.visible)
    candidate = sum(1 << slot.number for slot in array.slots if slot is not None and not slot.visible)
    assert (int(bench.io.visible), int(bench.io.candidate)) == (visible, candidate)
    for slot in array.slots:
        if slot is None:
            continue
        words = bench.words[slot.number]
        found = (words.lo, words.hi, words.off_lo, words.off_hi, words.support, words.n_ev + 1)
        axes = slot.axes
        expected = ([a.lo for a in axes], [a.hi for a in axes], [a.off[0] for a in axes], [a.off[1] for a in axes])
        assert found == (*expected, slot.support, slot.n_ev)
        assert words.beyond == [a.beyond[0] + 2 * a.beyond[1] for a in axes]
        assert words.hidden == [a.hidden[0] + 2 * a.hidden[1] for a in axes]
        assert words.scale == [a.bin_px.bit_length() - 1 for a in axes]
        sides = [*zip(*(a.box for a in axes), strict=True), *zip(*(a.window for a in axes), strict=True)]
        assert words.bounds == [list(pair) for pair in sides]


def record(parts: dict[Out, tuple[int, int]], seq: int) -> Record:
    kind, (slot, time) = parts[Out.KIND][0], parts[Out.HEAD]
    other = parts[Out.OTHER_ID][0] if kind == Kind.MERGED else 0
    return (
        seq, time, kind, parts[Out.ID][0], other, *parts[Out.MIDDLE], *parts[Out.SIDES], *parts[Out.MOVES],
        parts[Out.SUPPORT][0], parts[Out.N_EV][0], slot,
    )  # fmt: skip


def disturb(rng: np.random.Generator, bench: Bench, slot: Slot) -> None:
    """Sides, offsets, marks, support and bins as events could have left them."""
    words = bench.words[slot.number]
    slot.support = min(2**SUP_W - 1, slot.support + int(rng.integers(0, 40)))
    words.support = slot.support
    drift = [int(way) for way in rng.integers(-3 * PX, 3 * PX + 1, 2)]
    for lane, axis in enumerate(slot.axes):
        for side in (0, 1):
            way = (drift[lane] if rng.random() < 0.8 else 0) + int(rng.integers(-PX, PX + 1)) >> int(rng.integers(0, 8))
            axis.off[side] += way
            if side:
                axis.hi += way
            else:
                axis.lo += way
            axis.beyond[side] = bool(rng.integers(2))
        if rng.random() < 0.02:
            axis.off = [int(off) for off in rng.integers(-(1 << 28), 1 << 28, 2)]
        words.lo[lane], words.hi[lane] = axis.lo, axis.hi
        words.off_lo[lane], words.off_hi[lane] = axis.off
        words.beyond[lane] = axis.beyond[0] + 2 * axis.beyond[1]
        if slot.r.gap_corrections:
            for number in rng.choice(16, int(rng.integers(0, 6))):
                axis.bins[number] += int(rng.integers(1, 30))
        bench.bins[slot.number][lane] = list(axis.bins)


@pytest.mark.parametrize("seed", range(6))
def test_slots_are_seeded_corrected_and_moved(seed: int) -> None:
    rng = np.random.default_rng(seed)
    registers = random_motion(rng, Shape(n_slots=N, tc_w=12)).motion
    bench, array = Bench(registers), SlowArray(registers, N, 2**SUP_W - 1, 2**32 - 1)
    now, kinds = 0, set()
    for _ in range(140):
        now += int(rng.integers(0, 60)) if rng.random() < 0.97 else 3 * registers.coast_ticks
        before = len(array.records)
        chosen = int(rng.integers(N))
        slot = array.slots[chosen]
        if rng.random() < 0.25:
            for one in list(array.slots):
                if one is not None and array.slots[one.number] is one:
                    array._step(one, now)
            bench.run("step", 0, now)
        elif slot is None:
            place = int(rng.integers(20, 60)), int(rng.integers(20, 60))
            array.slots[chosen], bench.event = Slot(chosen, registers, *place, now), place
            bench.run("seed", chosen, now)
        else:
            disturb(rng, bench, slot)
            slot.correct(now)
            if slot.visible:
                array._record(slot, Kind.MOVED, now)
            bench.run("correct", chosen, now)
        compare(bench, array)
        expected = array.records[before:]
        assert [record(parts, len(array.owners)) for parts in bench.records] == expected
        kinds |= {row[2] for row in expected}
        bench.records.clear()
    for chosen in range(N):  # a restart ends what lives
        bench.run("restart", chosen, now)
    assert (int(bench.io.visible), int(bench.io.candidate)) == (0, 0)
    assert [parts[Out.KIND][0] for parts in bench.records] == [Kind.LOST] * sum(
        slot is not None and slot.visible for slot in array.slots
    )


def test_lint() -> None:
    assert lint("motion_engine") == (0, "")
    assert lint("motion_engine", N=1, SLOT_W=1, W=60, Y_LANE_W=46) == (0, "")
    assert lint("motion_lane") == (0, "")
    assert lint("motion_program") == (0, "")
