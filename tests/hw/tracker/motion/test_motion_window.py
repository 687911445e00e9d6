# SPDX-License-Identifier: Apache-2.0
"""motion_window.v: box and window from sides and velocity."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from evcot.hardware.motion.contract import MotionRegisters
from evcot_cosim.rtl.build import load
from support.slow_motion import PX, Slot

SIDE_W, PX_W = 25, 13
RINGS = ("elongation", "ring_across", "ring_along", "ring_any", "ring_px", "ring_max")


def packed(bounds: list[int]) -> int:
    word = 0
    for bound in bounds:
        word = word << PX_W | bound % (1 << PX_W)
    return word


def test_random_boxes() -> None:
    sim, rng = load("motion_window", {"SIDE_W": SIDE_W}), np.random.default_rng(1)
    io = sim.io
    io.rst = 1
    sim.clock.tick()
    io.rst = 0
    for _ in range(1_500):
        ring_px, ring_max = sorted(int(px) for px in rng.integers(0, 256, 2) >> rng.integers(0, 6))
        registers = replace(
            MotionRegisters(), ring_px=ring_px, ring_max=ring_max, elongation=int(rng.integers(1, 16)),
            **{name: int(rng.integers(0, 9)) for name in ("ring_across", "ring_along", "ring_any")},
        )  # fmt: skip
        slot = Slot(0, registers, 0, 0, 0)
        slot.corrections = int(rng.integers(0, 8))
        slot.visible = bool(rng.integers(2))
        for axis in slot.axes:
            axis.lo = int(rng.integers(-200 * PX, 600 * PX))
            axis.hi = axis.lo + int(rng.integers(-3 * PX, 300 * PX >> int(rng.integers(0, 6))))
            axis.v = int(rng.integers(-32_767, 32_768)) >> int(rng.integers(0, 15))
        if rng.random() < 0.2:
            slot.axes[1].v = int(rng.choice([-2, 0, 2])) * (slot.axes[0].v // 4)
        slot.set_window()
        io.widest = int(rng.random() < 0.2)
        if int(io.widest):
            for axis in slot.axes:
                axis.set_box(registers.ring_max)
        for name in RINGS:
            setattr(io, name, getattr(registers, name))
        for axis, suffix in zip(slot.axes, "xy", strict=True):
            setattr(io, f"lo_{suffix}", axis.lo % (1 << SIDE_W))
            setattr(io, f"hi_{suffix}", axis.hi % (1 << SIDE_W))
            setattr(io, f"length_{suffix}", axis.px)
            setattr(io, f"speed_{suffix}", abs(axis.v))
        io.known = int(slot.visible or slot.corrections >= 4)
        for _clock in range(4):
            sim.clock.tick()
        io.start = 1
        for clock in range(6):
            assert (int(io.done), int(io.soon)) == (0, clock == 4)
            if clock == 4:
                assert int(io.box) == packed([bound for axis in slot.axes for bound in axis.box])
            sim.clock.tick()
            io.start = 0
        assert int(io.done)
        assert int(io.box) == packed([bound for axis in slot.axes for bound in axis.box])
        assert int(io.window) == packed([bound for axis in slot.axes for bound in axis.window])
        sim.clock.tick()
