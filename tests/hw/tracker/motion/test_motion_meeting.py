# SPDX-License-Identifier: Apache-2.0
"""motion_meeting.v: what a slot meets, what hides its sides, which slots it touches, returns as, or may be one object with."""

from __future__ import annotations

import numpy as np

from evcot.hardware.motion.contract import MotionRegisters
from evcot_cosim.rtl.build import load
from support.slow_motion import Slot, gap

N, PX_W = 8, 13
STATES = ("visible", "candidate", "left")


def packed(bounds: list[int]) -> int:
    word = 0
    for bound in bounds:
        word = word << PX_W | bound % (1 << PX_W)
    return word


def random_slot(rng: np.random.Generator, number: int, registers: MotionRegisters) -> Slot:
    slot = Slot(number, registers, 0, 0, 0)
    far = 40 if rng.random() < 0.9 else 4_000
    for axis in slot.axes:
        low = int(rng.integers(-20 if far == 40 else -4_000, far))
        axis.box, axis.ring = (low, low + int(rng.integers(0, 25))), int(rng.integers(0, 12))
    return slot


def bounds(slot: Slot, kind: str) -> int:
    return packed([bound for axis in slot.axes for bound in getattr(axis, kind)])


def may_be_one(one: Slot, other: Slot) -> bool:
    """Rule M2 without what depends on velocities and support: a shared row or column, and on the other axis a gap in reach.

    Of join_reach it only counts whether it is 0.
    """
    gaps = [gap(a.box, b.box) for a, b in zip(one.axes, other.axes, strict=True)]
    sides = [max(a.box[1] - a.box[0], b.box[1] - b.box[0]) for a, b in zip(one.axes, other.axes, strict=True)]
    return any(gaps[i] <= 0 and gaps[1 - i] <= (sides[i] >> min(one.r.join_reach, 1)) + one.r.join_px for i in (0, 1))


def is_one_some_way(one: Slot, other: Slot) -> bool:
    """Whether rule M2 holds for some direction of the pair."""
    found = False
    for along in (0, 1):
        for slot in (one, other):
            slot.axes[along].v, slot.axes[1 - along].v = 9, 0
        found = found or one.is_one_with(other)
    return found


class Meeting:
    """The module, and the memory that it reads."""

    def __init__(self) -> None:
        self.sim, self.rng = load("motion_meeting", {"N": N, "PX_W": PX_W, "SLOT_W": 3}), np.random.default_rng(1)
        self.io = self.sim.io
        self.io.rst = 1
        self.sim.clock.tick()
        self.io.rst = 0

    def ask(self, slots: list[Slot], *, begins: bool) -> int:
        """Clocks until it is done; what memory has of a slot is there two clocks after it was asked for."""
        io = self.io
        io.start, io.begins = 1, int(begins)
        asked: list[int | None] = [None] * 3
        clocks = 0
        while not int(io.done):
            self.sim.clock.tick()
            io.start, clocks = 0, clocks + 1
            asked = [int(io.asked) if int(io.asks) else None, *asked[:2]]
            for kind in ("box", "window"):
                noise = int.from_bytes(self.rng.bytes(7)) % (1 << 4 * PX_W)
                setattr(io, f"other_{kind}", noise if asked[2] is None else bounds(slots[asked[2]], kind))
            assert clocks < 100
        return clocks


def test_random_meetings() -> None:
    meeting = Meeting()
    io, rng = meeting.io, meeting.rng
    seen, again, one_object, far = set(), 0, 0, 0
    for _ in range(400):
        registers = MotionRegisters(
            join_reach=int(rng.integers(4)), join_px=int(rng.choice([0, 2, 9, 255], p=[0.3, 0.3, 0.3, 0.1]))
        )
        slots = [random_slot(rng, i, registers) for i in range(N)]
        one = slots[int(rng.integers(N))]
        states = rng.choice(["visible", "candidate", "left", "free"], N, p=[0.45, 0.3, 0.15, 0.1])
        states[one.number] = rng.choice(["visible", "candidate"])
        others = {state: [slot for slot in slots if slot is not one and states[slot.number] == state] for state in STATES}
        io.slot, io.join_reach, io.join_px = one.number, registers.join_reach, registers.join_px
        for state in STATES:
            setattr(io, state, sum(1 << i for i in range(N) if states[i] == state))
        io.box, io.window = bounds(one, "box"), bounds(one, "window")
        doubled = [sum(axis.box) % (2 << PX_W) for axis in one.axes]
        io.middle = doubled[1] << PX_W + 1 | doubled[0]
        clocks = meeting.ask(slots, begins=True)
        asked = [slot for state in STATES for slot in others[state]]
        assert clocks == 10 + len(asked)
        one.hide(others["visible"])
        sides = [side for axis in one.axes for side in axis.hidden]
        middle = tuple((axis.box[0] + axis.box[1]) // 2 for axis in one.axes)
        near = [slot for slot in asked if may_be_one(one, slot)]
        assert int(io.nearby) == sum(1 << slot.number for slot in near)
        for slot in asked:
            assert not is_one_some_way(one, slot) or slot in near
            one_object += is_one_some_way(one, slot)
            far += slot not in near
        assert int(io.meets) == one.meets
        assert int(io.hidden) == sum(1 << i for i in range(4) if sides[i])
        assert int(io.held) == any(slot.holds((middle[0], middle[1])) for slot in others["visible"])
        gone = [slot.number for slot in others["left"] if one.reaches(slot)]
        assert int(io.returns) == bool(gone)
        assert not gone or int(io.returned) == gone[0]
        seen.add((int(io.meets), int(io.hidden), int(io.held), int(io.touches), int(io.returns)))
        touched = [
            slot.number
            for slot in others["candidate"]
            if all(gap(a.box, b.box) <= 0 for a, b in zip(slot.axes, one.axes, strict=True))
        ]
        for number in touched:  # asked again, it names the next one
            assert (int(io.touches), int(io.touched)) == (1, number)
            meeting.sim.clock.tick()
            assert meeting.ask(slots, begins=False) == clocks
        assert not int(io.touches)
        again += len(touched) > 1
        meeting.sim.clock.tick()
    assert len(seen) > 40
    assert min(again, one_object, far) > 5
