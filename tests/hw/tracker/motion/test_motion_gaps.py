# SPDX-License-Identifier: Apache-2.0
"""motion_gaps.v: events in the bins of several slots, and the gaps found there."""

from __future__ import annotations

import numpy as np
from pyverilator import PyVerilator

from evcot_cosim.rtl.build import load
from support.slow_motion import PX, Axis

BINS = list[int]


def count(sim: PyVerilator, slot: int, bins: tuple[int | None, int | None]) -> None:
    io = sim.io
    io.slot, io.count = slot, 1
    for suffix, number in zip("xy", bins, strict=True):
        setattr(io, f"in_{suffix}", int(number is not None))
        setattr(io, f"bin_{suffix}", number or 0)
    sim.clock.tick()
    io.count = 0


def clear(sim: PyVerilator) -> None:
    io = sim.io
    io.clear = 1
    for slot in range(4):
        for number in range(16):
            io.slot, io.cleared = slot, number
            sim.clock.tick()
    io.clear = 0


def test_random_looks() -> None:
    sim, rng = load("motion_gaps", {"PX_W": 13, "SLOT_W": 2}), np.random.default_rng(1)
    io = sim.io
    io.rst = 1
    sim.clock.tick()
    io.rst = 0
    outcomes = set()
    for _ in range(60):
        bins: list[list[BINS]] = [[[0] * 16, [0] * 16] for _ in range(4)]
        clear(sim)
        places = [[rng.choice(16, int(rng.integers(1, 8))) for _ in range(2)] for _ in range(4)]
        for _event in range(int(rng.integers(0, 150))):
            slot = int(rng.integers(4))
            pair = [int(rng.choice(places[slot][on_y])) if rng.random() < 0.9 else None for on_y in (0, 1)]
            count(sim, slot, (pair[0], pair[1]))
            for on_y in (0, 1):
                number = pair[on_y]
                if number is not None:
                    bins[slot][on_y][number] += 1
        for _clock in range(4):
            sim.clock.tick()
        for slot in range(4):
            for on_y in (0, 1):
                share, log2 = int(rng.integers(1, 8)), int(rng.integers(0, 6))
                narrowest = int(rng.integers(1, 10 << log2))
                low = int(rng.integers(-100 * PX, 100 * PX))
                axis = Axis(low, low + (8 * PX << log2), bins=bins[slot][on_y], bin_px=1 << log2)
                before = axis.lo, axis.hi
                axis.cut(share, narrowest)
                io.look_slot, io.on_y, io.bin_log2, io.narrowest, io.gap_share = slot, on_y, log2, narrowest, share
                io.look, clocks = 1, 0
                while not int(io.done):
                    sim.clock.tick()
                    io.look = 0
                    clocks += 1
                assert clocks == 47
                lo, hi = before
                if int(io.found) and int(io.low_stays):
                    hi = lo + (int(io.begins) * PX << log2)
                elif int(io.found):
                    lo += int(io.ends) * PX << log2
                    hi = max(hi, lo)
                assert (lo, hi) == (axis.lo, axis.hi)
                outcomes.add((int(io.found), int(io.low_stays) if int(io.found) else 0))
                sim.clock.tick()
    assert outcomes == {(0, 0), (1, 0), (1, 1)}
