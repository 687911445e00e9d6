# SPDX-License-Identifier: Apache-2.0
"""array_average.v: averages of several slots, an event per clock, and their centres, as if each event came alone."""

from __future__ import annotations

from fractions import Fraction
from math import floor
from typing import NamedTuple

import numpy as np
import pytest

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import lint

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


@pytest.mark.parametrize(("a_w", "frac"), [(1, 0), (9, 4), (16, 8)])
def test_lints_clean(a_w: int, frac: int) -> None:
    assert lint("array_average", A_W=a_w, FRAC=frac) == (0, "")


@pytest.mark.parametrize(
    ("parameter", "value", "rule"), [("A_W", 17, "A_W_must_be_1_to_16"), ("FRAC", 9, "FRAC_must_be_0_to_8")]
)
def test_refuses_parameters_out_of_range(parameter: str, value: int, rule: str) -> None:
    code, log = lint("array_average", **{parameter: value})
    assert code != 0
    assert rule in log
