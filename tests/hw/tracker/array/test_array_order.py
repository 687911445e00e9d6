# SPDX-License-Identifier: Apache-2.0
"""array_order.v: which of two slots was born first, beside a list of slots in Python."""

from __future__ import annotations

import numpy as np
import pytest

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import lint


@pytest.mark.parametrize("n", [1, 2, 3, 8, 64])
def test_random_births_and_questions(n: int) -> None:
    """After thousands of births the answer is still that of a list; slots keep being named that nobody asked for."""
    sim = load("array_order", {"N": n, "SLOT_W": max(1, (n - 1).bit_length())})
    rng, io, row = np.random.default_rng(n), sim.io, list(range(n))
    reset(sim)

    def clock(slot: int, asked: int = 0, born: int = 0) -> None:
        io.slot, io.asked, io.born = slot, asked, born
        sim.clock.tick()

    answers = [0, 0]
    for _ in range(4_000):
        slot, other = (int(number) for number in rng.integers(0, n, 2))
        if rng.random() < 0.5:
            clock(slot, asked=1)
            clock(int(rng.integers(n)), born=1)
            clock(int(rng.integers(n)))
            row.remove(slot)
            row.append(slot)
        elif slot != other:
            clock(slot, asked=1)
            clock(other, asked=1)
            io.asked = 0
            assert io.second_first == (row.index(other) < row.index(slot))
            answers[io.second_first] += 1
        else:
            clock(slot, asked=int(rng.integers(2)))  # named, but not born
    assert n == 1 or min(answers) > 300


def test_reset_begins_with_the_slots_in_order() -> None:
    sim = load("array_order", {"N": 3, "SLOT_W": 2})
    io = sim.io
    reset(sim)
    for asked, born in ((1, 0), (0, 1), (0, 0)):  # slot 0 goes to the end
        io.slot, io.asked, io.born = 0, asked, born
        sim.clock.tick()
    for begins_anew, first in ((False, 1), (True, 0)):
        if begins_anew:
            reset(sim)
        for slot in (1 - first, first):
            io.slot, io.asked = slot, 1
            sim.clock.tick()
        assert io.second_first == 1


@pytest.mark.parametrize(("n", "slot_w"), [(1, 1), (3, 2), (64, 6)])
def test_lints_clean(n: int, slot_w: int) -> None:
    assert lint("array_order", N=n, SLOT_W=slot_w) == (0, "")
