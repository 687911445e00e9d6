# SPDX-License-Identifier: Apache-2.0
"""motion_pair.v: whether two slots move together and can be one object."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from evcot.hardware.motion.contract import MotionRegisters
from evcot_cosim.rtl.build import load
from support.slow_motion import Slot

PX_W, SUP_W = 13, 9


def packed(bounds: list[int]) -> int:
    word = 0
    for bound in bounds:
        word = word << PX_W | bound % (1 << PX_W)
    return word


def random_slot(rng: np.random.Generator, number: int, registers: MotionRegisters, speed: int) -> Slot:
    slot = Slot(number, registers, 0, 0, 0)
    slot.support = int(rng.integers(1 << SUP_W)) if rng.random() < 0.8 else 7
    for axis in slot.axes:
        low = int(rng.integers(-20, 40))
        axis.box, axis.ring = (low, low + int(rng.integers(0, 25))), int(rng.integers(0, 12))
        axis.v = int(rng.integers(-speed, speed + 1))
    return slot


def test_random_pairs() -> None:
    sim, rng = load("motion_pair", {"PX_W": PX_W, "SUP_W": SUP_W}), np.random.default_rng(1)
    io = sim.io
    io.rst = 1
    sim.clock.tick()
    io.rst = 0
    seen: dict[str, set[int]] = {}
    for _ in range(2_500):
        registers = replace(
            MotionRegisters(), join_speed=int(rng.integers(0, 4)), join_reach=int(rng.integers(0, 9)),
            join_px=int(rng.integers(0, 256)) >> int(rng.integers(4, 9)),
        )  # fmt: skip
        speed = int(rng.choice([50, 300, 32_767]))
        one, other = random_slot(rng, 0, registers, speed), random_slot(rng, 1, registers, speed)
        if rng.random() < 0.6:
            for mine, its in zip(one.axes, other.axes, strict=True):
                its.v = max(-32_767, min(32_767, mine.v + int(rng.integers(-70, 71))))
        for name in ("join_speed", "join_reach", "join_px"):
            setattr(io, name, getattr(registers, name))
        for prefix, slot in (("one", one), ("other", other)):
            setattr(io, f"{prefix}_box", packed([bound for axis in slot.axes for bound in axis.box]))
            setattr(io, f"{prefix}_v_x", slot.axes[0].v % (1 << 16))
            setattr(io, f"{prefix}_v_y", slot.axes[1].v % (1 << 16))
            setattr(io, f"{prefix}_support", slot.support)
        io.start = 1
        sim.clock.tick()
        io.start, clocks = 0, 1
        while not int(io.done):
            sim.clock.tick()
            clocks += 1
        assert clocks == 22
        expected = {
            "alike": one.moves_with(other) and one.is_one_with(other),
            "weaker": one.support < other.support,
        }
        found = {name: int(getattr(io, name)) for name in expected}
        assert found == expected
        for name, value in found.items():
            seen.setdefault(name, set()).add(value)
    assert {name: len(values) for name, values in seen.items()} == {"alike": 2, "weaker": 2}
