# SPDX-License-Identifier: Apache-2.0
"""The average of a slot's events, and the lives of slots."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import floor
from typing import NamedTuple

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load

SLOTS = 3


class Due(NamedTuple):
    """What is to be seen on a port at a clock."""

    clock: int
    port: str
    value: int


def moved(value: int, target: int, k: int, frac: int) -> int:
    """value + (target - value) / 2^k: to nearest, halves up, where there are fractional bits; else down."""
    return floor(value + Fraction(target - value, 1 << k) + Fraction(1 if frac else 0, 2))


@pytest.mark.parametrize(("a_w", "frac", "k_max"), [(5, 4, 4), (5, 0, 3), (3, 1, 8), (1, 0, 1), (9, 8, 7)])
def test_random_events_of_several_slots(a_w: int, frac: int, k_max: int) -> None:
    sim = load("array_average", {"A_W": a_w, "FRAC": frac, "COPY": 1})
    io, rng = sim.io, np.random.default_rng([9, a_w, frac])
    io.k = io.again = io.moves = io.place = io.forward = io.passes = 0
    reset(sim)
    highest = ((1 << a_w) - 1) << frac
    average = [0] * SLOTS  # what it is to be
    centre = [0] * SLOTS
    memory = [0] * SLOTS  # what has been written of it
    in_u = in_v = None  # slot of the event in these stages
    ks = rng.integers(0, k_max + 1, SLOTS).tolist()
    due: list[Due] = []
    forwarded = bubble = 0
    slot, placed = 0, (-1, 0)  # when the average of which slot is set to its centre
    behind = int(rng.integers(1 << a_w))  # address of the next event, a clock ahead
    for clock in range(3_000):
        address, behind = behind, int(rng.integers(1 << a_w))
        io.event_at, io.next_at = address, behind
        for expected in [one for one in due if one.clock == clock]:
            assert io[expected.port] == expected.value, (clock, expected)
        due = [one for one in due if one.clock > clock]
        if bubble:  # the centre is next: nothing comes, and U is told what to do
            io.again, io.moves, io.forward, io.place = 1, bubble == 2, 0, 0
            io.k = int(rng.integers(9))
            bubble, entering = 0, None
        else:
            slot = int(rng.integers(SLOTS)) if rng.random() < 0.4 else slot
            if clock <= placed[0] and slot == placed[1]:
                slot = (slot + 1) % SLOTS
            at, position = address, int(rng.integers(highest + 1))
            special, place = bool(rng.random() < 0.2), clock > placed[0] and bool(rng.random() < 0.05)
            io.again = io.moves = 0
            io.k, io.av, io.cm = ks[slot], memory[slot], centre[slot]
            io.forward, io.passes = slot == in_u and not place, slot == in_v
            io.place, io.position = place, position
            forwarded += slot == in_u
            old = centre[slot]
            average[slot] = position if place else moved(average[slot], at << frac, ks[slot], frac)
            pixel = floor(Fraction(old, 1 << frac) + Fraction(1 if frac else 0, 2))
            due += [
                Due(clock + 1, "u_cm", position if place else old),
                Due(clock + 1, "u_offset", 0 if place else (at - pixel) % (2 << a_w)),
            ]
            if not place:
                due.append(Due(clock + 2, "v_av", average[slot]))
            if place or special:
                centre[slot] = position if place else moved(old, average[slot], ks[slot], frac)
                due.append(Due(clock + 3, "v_av", centre[slot]))
                bubble = 1 if place else 2
                placed = (clock + 3, slot) if place else placed
            entering = slot
        if in_v is not None:
            memory[in_v] = int(io.v_av)
        if clock == placed[0]:
            memory[placed[1]] = int(io.v_av)
        sim.clock.tick()
        in_u, in_v = entering, in_u
    assert forwarded > 800


TC_W, TIME_W, LIFE_W, SLOT_W = 6, 16, 8, 3
PARAMETERS = {"TC_W": TC_W, "TIME_W": TIME_W, "LIFE_W": LIFE_W, "CLOCK_W": TIME_W, "SLOT_W": SLOT_W}
HALF = 1 << LIFE_W - 1  # times are less than this apart


@dataclass(frozen=True)
class Slot:
    """A deadline where there is one, and what an event grants where mode is not off."""

    deadline: int | None
    on: bool
    max_ticks: int
    detect_ticks: int


def walk(sim: PyVerilator, slots: list[Slot], begins: str = "", grants: str = "max_ticks") -> None:
    """All slots in ascending order, and the clocks until the walk is complete."""
    io = sim.io
    io.walks, pauses = 1, np.random.default_rng(len(slots))
    if begins:
        io[begins] = 1
        sim.clock.tick()
        io[begins] = 0
    for number, slot in enumerate(slots):
        io.slot, io.timed, io.on = number, slot.deadline is not None, slot.on
        io.deadline = (slot.deadline or 0) % (1 << LIFE_W)
        io.grant = getattr(slot, grants)
        io.step = 1
        sim.clock.tick()
        io.step, io.slot, io.timed, io.on, io.deadline = 0, 0, 1, 1, 0  # nobody looks
        for _ in range(int(pauses.integers(0, 2))):
            sim.clock.tick()
    for _ in range(4):
        sim.clock.tick()
    io.walks = 0


def survey(sim: PyVerilator, slots: list[Slot]) -> None:
    """Both walks over what events grant."""
    sim.io.surveys = 1
    walk(sim, slots, "survey", "max_ticks")
    walk(sim, slots, grants="detect_ticks")
    sim.io.surveys = 0


def test_random_slots() -> None:
    sim = load("array_lives", PARAMETERS)
    io, rng, ends, far = sim.io, np.random.default_rng(12), 0, 0
    for _ in range(150):
        now = int(rng.integers(1 << 10, 1 << TIME_W - 1))
        io.now = now
        early, some, enabled = int(rng.integers(0, 20)), float(rng.choice([0.2, 0.8])), float(rng.choice([0, 0.3, 1]))
        slots = [
            Slot(
                now + int(rng.integers(-early, 1 << TC_W)) if rng.random() < some else None,
                bool(rng.random() < enabled),
                int(rng.integers(1, 1 << TC_W)),
                int(rng.integers(1, 1 << TC_W)),
            )
            for _ in range(6)
        ]
        survey(sim, slots)
        walk(sim, slots, "start")
        deadlines = [(slot.deadline, number) for number, slot in enumerate(slots) if slot.deadline is not None]
        if deadlines and min(deadlines)[0] <= now:
            assert (io.ended, io.ended_time, io.ended_slot) == (1, *min(deadlines))
            ends += 1
            continue
        assert io.ended == 0
        io.finish = 1
        sim.clock.tick()
        io.finish = 0
        grants = [now + ticks for slot in slots if slot.on for ticks in (slot.max_ticks, slot.detect_ticks)]
        bound = min([deadline for deadline, _ in deadlines] + grants, default=now + HALF - 1)
        far += bound == now + HALF - 1
        for time in {now, bound - 1, bound, min(bound + 1, now + HALF - 1)}:
            io.m_time = time % (1 << LIFE_W)
            assert io.m_due == (time >= bound), (now, bound, time)
    assert ends > 20
    assert far > 3


def test_the_survey_stays_for_the_walks_after_it() -> None:
    sim = load("array_lives", PARAMETERS)
    sim.io.now = 1_000
    survey(sim, [Slot(None, True, 40, 9)])
    for deadline, bound in ((1_020, 1_009), (1_004, 1_004), (None, 1_009)):
        walk(sim, [Slot(deadline, True, 1, 1)], "start")
        sim.io.finish = 1
        sim.clock.tick()
        sim.io.finish = 0
        due = []
        for time in range(1_000, 1_030):
            sim.io.m_time = time % (1 << LIFE_W)
            due.append(int(sim.io.m_due))
        assert due == [int(time >= bound) for time in range(1_000, 1_030)]


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_of_two_at_the_same_tick_the_lower_slot_ends_first(order: tuple[int, int]) -> None:
    sim = load("array_lives", PARAMETERS)
    sim.io.now = 500
    slots = [Slot(None, False, 1, 1)] * 4 + [Slot(490 + order[0], True, 1, 1), Slot(490 + order[1], True, 1, 1)]
    survey(sim, slots)
    walk(sim, slots, "start")
    assert (sim.io.ended, sim.io.ended_slot, sim.io.ended_time) == (1, 4 + order[0], 490)
    tie = [Slot(490, True, 1, 1)] * 3
    walk(sim, tie, "start")
    assert (sim.io.ended, sim.io.ended_slot, sim.io.ended_time) == (1, 0, 490)
