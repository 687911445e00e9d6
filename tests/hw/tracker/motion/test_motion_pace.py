# SPDX-License-Identifier: Apache-2.0
"""motion_pace.v: the stated velocity of every slot, against the independent model."""

from __future__ import annotations

import numpy as np
import pytest

from evcot_cosim.rtl.build import load
from support.slow_motion import Axis

SIDE_W = 25
CLOCKS = {"follow": 14, "begins": 7, "settle": 2}  # until memory has it, which is read in four more


def _followed(axes: list[Axis]) -> int:
    """Rule V1; returns the number of steps of a mean."""
    speed, shorter = max(abs(axis.stated) for axis in axes), min(axis.side for axis in axes)
    steps = next((steps for steps in (16, 8, 4) if speed * steps <= shorter), 2)
    for axis in axes:
        axis.follow(steps)
    return steps


@pytest.mark.parametrize("slot_w", [1, 3, 6])
def test_random_slots(slot_w: int) -> None:
    sim, rng = load("motion_pace", {"SLOT_W": slot_w, "SIDE_W": SIDE_W}), np.random.default_rng(1)
    io, slots, lengths = sim.io, {}, set()
    for _ in range(3_000):
        slot = int(rng.integers(1 << slot_w))
        command = str(rng.choice(["follow", "begins", "settle"], p=[0.9, 0.05, 0.05])) if slot in slots else "begins"
        axes = slots.setdefault(slot, [Axis(0, 0), Axis(0, 0)])
        for axis in axes:
            axis.lo += int(rng.integers(-60_000, 60_000)) >> int(rng.integers(10))
            axis.hi = axis.lo + (int(rng.integers(1 << 20)) >> int(rng.integers(8))) - 2_000
            if rng.random() < 0.05:
                axis.lo, axis.hi, axis.v = -(1 << 20), 1 << 22, int(rng.choice([-32_767, 32_767]))
        (x, y), io.at = axes, slot
        io.sum_x, io.sum_y = ((axis.lo + axis.hi) % (1 << SIDE_W + 1) for axis in axes)
        io.side_x, io.side_y = x.side, y.side
        io.v = y.v % (1 << 16) << 16 | x.v % (1 << 16)
        for _ in range(3):
            sim.clock.tick()
        setattr(io, command, 1)
        sim.clock.tick()
        setattr(io, command, 0)
        for _ in range(CLOCKS[command] + 3):
            sim.clock.tick()
        if command == "follow":
            lengths.add(_followed(axes))
        for axis in axes:
            if command == "begins":
                axis.begin_pace()
            axis.was = axis.lo + axis.hi
        assert [int(io.v_x), int(io.v_y)] == [axis.stated // 2 % (1 << 16) for axis in axes]
    assert lengths == {2, 4, 8, 16}
