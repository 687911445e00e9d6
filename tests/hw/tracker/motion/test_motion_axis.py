# SPDX-License-Identifier: Apache-2.0
"""motion_axis.v: what events do to both sides of an axis of several slots, an event a clock."""

from __future__ import annotations

import numpy as np

from evcot_cosim.rtl.build import load
from support.slow_motion import PX, Axis
from support.testing import lint

SIDE_W, SLOTS = 25, 4


def signed(value: int, bits: int) -> int:
    return value - (value >> (bits - 1) << bits)


def test_random_events() -> None:
    sim, rng = load("motion_axis", {"AT_W": 7, "SIDE_W": SIDE_W, "SLOT_W": 2}), np.random.default_rng(1)
    io = sim.io
    beyond = set()
    for _ in range(250):
        axes = []
        for slot in range(SLOTS):
            lo, hi = (int(side) for side in rng.integers(-40 * PX, 170 * PX, 2))
            axis = Axis(lo, hi)
            axis.hidden = [bool(rng.integers(2)), bool(rng.integers(2))] if rng.random() < 0.5 else [False, False]
            axes.append(axis)
            io.slot_3, io.store, io.s_lo, io.s_hi = slot, 1, axis.lo % (1 << SIDE_W), axis.hi % (1 << SIDE_W)
            io.s_marks, io.s_hidden = 0, axis.hidden[0] + 2 * axis.hidden[1]
            sim.clock.tick()
            io.store = 0
            sim.clock.tick()
        out, back = (int(way) for way in rng.integers(0, 60_000, 2))
        io.out, io.back = out, back
        slots = [int(slot) for slot in rng.integers(0, int(rng.integers(1, SLOTS + 1)), 12)]
        places = [int(place) for place in rng.integers(0, 128, 12)]
        for t in range(14):
            io.slot = slots[min(t, 11)]
            io.place, io.slot_2 = places[min(max(t - 1, 0), 11)], slots[min(max(t - 1, 0), 11)]
            io.forward = int(2 <= t <= 12 and slots[t - 1] == slots[t - 2])
            io.recent = int(3 <= t <= 12 and slots[t - 1] == slots[t - 3])
            io.update, io.slot_3 = int(t >= 2), slots[max(t - 2, 0)]
            sim.clock.tick()
        io.update = io.forward = io.recent = 0
        sim.clock.tick()
        for slot, place in zip(slots, places, strict=True):
            axes[slot].measure(place * PX, out, back)
        for slot, axis in enumerate(axes):
            io.slot_2 = slot
            sim.clock.tick()
            assert (signed(int(io.lo), SIDE_W), signed(int(io.hi), SIDE_W)) == (axis.lo, axis.hi)
            assert int(io.marks) == axis.beyond[0] + 2 * axis.beyond[1]
            beyond.add(int(io.marks))
    assert beyond == {0, 1, 2, 3}


def test_lint() -> None:
    assert lint("motion_axis") == (0, "")
