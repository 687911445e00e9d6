# SPDX-License-Identifier: Apache-2.0
"""motion_meeting.v with motion_match.v's answers: what a slot meets, what hides its sides, whom it touches or returns as."""

from __future__ import annotations

import numpy as np

from evcot.hardware.motion.contract import MotionRegisters
from evcot_cosim.rtl.build import load
from support.slow_motion import Slot, gap
from support.testing import lint

N, PX_W = 5, 13


def packed(bounds: list[int]) -> int:
    word = 0
    for bound in bounds:
        word = word << PX_W | bound % (1 << PX_W)
    return word


def unpacked(word: int) -> list[int]:
    return [((word >> PX_W * (3 - i)) + (1 << PX_W - 1)) % (1 << PX_W) - (1 << PX_W - 1) for i in range(4)]


def random_slot(rng: np.random.Generator, number: int) -> Slot:
    slot = Slot(number, MotionRegisters(), 0, 0, 0)
    for axis in slot.axes:
        low = int(rng.integers(-20, 40))
        axis.box, axis.ring = (low, low + int(rng.integers(0, 25))), int(rng.integers(0, 12))
    return slot


def test_random_meetings() -> None:
    sim, rng = load("motion_meeting", {"N": N, "PX_W": PX_W, "SLOT_W": 3}), np.random.default_rng(1)
    io = sim.io
    io.rst = 1
    sim.clock.tick()
    io.rst = 0
    seen = set()
    for _ in range(400):
        slots = [random_slot(rng, i) for i in range(N)]
        one, visible = slots[int(rng.integers(N))], rng.random(N) < 0.6
        left = ~visible & (rng.random(N) < 0.5)
        left[one.number] = False
        others = [slot for slot in slots if slot is not one]
        io.slot, io.visible = one.number, sum(1 << i for i in range(N) if visible[i])
        io.candidate = sum(1 << i for i in range(N) if not visible[i] and not left[i])
        io.left = sum(1 << i for i in range(N) if left[i])
        io.box = packed([bound for axis in one.axes for bound in axis.box])
        io.window = packed([bound for axis in one.axes for bound in axis.window])
        io.start = io.begins = 1
        asked: list[list[int]] = [[0] * 4] * 3
        while not int(io.done):
            sim.clock.tick()
            io.start = 0
            asked = [unpacked(int(io.ask_for)), *asked[:2]]
            x0, x1, y0, y1 = asked[2]
            place = ((x0, x1), (y0, y1))
            for name, kind in (("in_box", "box"), ("in_window", "window")):
                held = [all(gap(getattr(a, kind), p) <= 0 for a, p in zip(s.axes, place, strict=True)) for s in slots]
                setattr(io, name, sum(1 << i for i in range(N) if held[i]))
            line = [any(gap(a.box, p) <= 0 for a, p in zip(s.axes, place, strict=True)) for s in slots]
            io.in_line = sum(1 << i for i in range(N) if line[i])
        one.hide([slot for slot in others if visible[slot.number]])
        sides = [side for axis in one.axes for side in axis.hidden]
        middle = tuple((axis.box[0] + axis.box[1]) // 2 for axis in one.axes)
        touched = [
            slot.number
            for slot in others
            if not (visible | left)[slot.number]
            and all(gap(a.box, b.box) <= 0 for a, b in zip(slot.axes, one.axes, strict=True))
        ]
        near = [any(gap(a.box, b.box) <= 0 for a, b in zip(slot.axes, one.axes, strict=True)) for slot in slots]
        assert int(io.nearby) == sum(1 << i for i in range(N) if near[i])
        assert int(io.meets) == one.meets
        assert int(io.hidden) == sum(1 << i for i in range(4) if sides[i])
        assert int(io.held) == any(visible[slot.number] and slot.holds((middle[0], middle[1])) for slot in others)
        assert int(io.touches) == bool(touched)
        assert not touched or int(io.touched) == touched[0]
        gone = [slot.number for slot in others if left[slot.number] and one.reaches(slot)]
        assert int(io.returns) == bool(gone)
        assert not gone or int(io.returned) == gone[0]
        seen.add((int(io.meets), int(io.hidden), int(io.held), int(io.touches), int(io.returns)))
        sim.clock.tick()
    assert len(seen) > 40


def test_lint() -> None:
    assert lint("motion_meeting") == (0, "")
