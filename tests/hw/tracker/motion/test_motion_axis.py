# SPDX-License-Identifier: Apache-2.0
"""motion_axis.v: what an event does to both sides of an axis."""

from __future__ import annotations

import numpy as np

from evcot_cosim.rtl.build import load
from support.slow_motion import PX, Axis
from support.testing import lint

SIDE_W, OFF_W = 25, 30


def signed(value: int, bits: int) -> int:
    return value - (value >> (bits - 1) << bits)


def test_random_events() -> None:
    sim, rng = load("motion_axis", {"AT_W": 7, "SIDE_W": SIDE_W, "OFF_W": OFF_W}), np.random.default_rng(1)
    io = sim.io
    beyond = set()
    for _ in range(3_000):
        lo, hi = (int(side) for side in rng.integers(-40 * PX, 170 * PX, 2))
        place = int(rng.integers(128))
        if rng.random() < 0.3:  # exactly at a side, and the unit beside it
            lo = hi = place * PX + int(rng.integers(-1, 2))
        axis = Axis(lo, hi, off=[int(off) for off in rng.integers(-(1 << 28), 1 << 28, 2)])
        axis.hidden = [bool(rng.integers(2)), bool(rng.integers(2))]
        out, back = (int(way) for way in rng.integers(0, 131_071, 2))
        io.place, io.out, io.back = place, out, back
        io.lo, io.hi = lo % (1 << SIDE_W), hi % (1 << SIDE_W)
        io.off_lo, io.off_hi = (off % (1 << OFF_W) for off in axis.off)
        io.hidden = axis.hidden[0] + 2 * axis.hidden[1]
        io.compare = 1
        sim.clock.tick()
        io.compare = 0
        io.place = int(rng.integers(128))  # it is remembered
        sim.clock.tick()
        axis.measure(place * PX, out, back)
        assert (signed(int(io.lo_next), SIDE_W), signed(int(io.hi_next), SIDE_W)) == (axis.lo, axis.hi)
        assert [signed(int(io.off_lo_next), OFF_W), signed(int(io.off_hi_next), OFF_W)] == axis.off
        assert int(io.beyond) == axis.beyond[0] + 2 * axis.beyond[1]
        beyond.add(int(io.beyond))
    assert beyond == {0, 1, 2, 3}


def test_lint() -> None:
    assert lint("motion_axis") == (0, "")
