# SPDX-License-Identifier: Apache-2.0
"""stamp_memory.v: ages of all neighbours against a list of all events; what it and the filters on it refuse."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from evcot_cosim.rtl.build import load
from support.tokens import Token, TokenMemory

WIDTH, HEIGHT = 9, 6
SQUARES = 3 * 2


class Wanted(NamedTuple):
    """What belongs to a token."""

    data: int
    inside: bool
    asked: bool
    ages: dict[int, int | None]  # bank -> age of each neighbour; None: it never had an event


class Memory(TokenMemory[Wanted]):
    """Beside the hardware, when each pixel last had an event."""

    def __init__(self, stamp_w: int, segment_w: int) -> None:
        self.stamp_w, self.keep = stamp_w, (1 << stamp_w) - (2 << segment_w)
        self.now = self.compared = 0
        self.last: dict[tuple[int, int], int] = {}
        shape = {"X_W": 4, "Y_W": 3, "WIDTH": WIDTH, "HEIGHT": HEIGHT, "STEP_W": 6, "DATA_W": 16}
        super().__init__(load("stamp_memory", {**shape, "STAMP_W": stamp_w, "SEGMENT_W": segment_w}), closed=True)

    def compare(self, wanted: Wanted) -> None:
        io = self.sim.io
        ages, near, mask = int(io.m_age), int(io.m_near), (1 << self.stamp_w) - 1
        assert (int(io.m_data), bool(io.m_inside)) == (wanted.data, wanted.inside)
        assert {bank for bank in range(16) if near >> bank & 1} == set(wanted.ages)
        for bank, age in wanted.ages.items() if wanted.asked else ():
            result = ages >> bank * self.stamp_w & mask
            assert result == age if age is not None and age < self.keep else result >= self.keep
        self.compared += 1

    def awaited(self, token: Token) -> Wanted:
        step, access, x, y, data = token
        self.now += step
        inside = x < WIDTH and y < HEIGHT
        beside = [(x + dx, y + dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1) if (dx or dy) and inside]
        beside = [(i, j) for i, j in beside if 0 <= i < WIDTH and 0 <= j < HEIGHT]
        then = {4 * (j % 4) + i % 4: self.last.get((i, j)) for i, j in beside}
        if access and inside:
            self.last[x, y] = self.now
        return Wanted(data, inside, access, {bank: None if stamp is None else self.now - stamp for bank, stamp in then.items()})


@pytest.mark.parametrize(("stamp_w", "segment_w"), [(4, 2), (9, 6)])
def test_ages_are_those_of_a_record_without_end(stamp_w: int, segment_w: int) -> None:
    memory = Memory(stamp_w, segment_w)
    assert memory.cleared_after == SQUARES + 5
    for run, (busy, rate, freely) in enumerate([(1.0, 0.3, 1.0), (0.6, 2, 0.7), (0.2, 1, 1.0), (0.9, 20, 0.6)]):

        def draw(rng: np.random.Generator, rate: float = rate) -> Token:
            step = min(63, int(rng.poisson(rate)))
            x, y, data = (int(rng.integers(end)) for end in (WIDTH + 1, HEIGHT + 1, 1 << 16))
            return step, bool(rng.random() < 0.9), x, y, data

        memory.run(np.random.default_rng([7, run]), 350, busy, freely, draw)
    print(f"{memory.compared} lookups")
    assert memory.compared > 200


def test_visits_are_repeated_until_no_event_is_in_their_way() -> None:
    """A token that enters the next segment waits for the walk, however often events undid its visits before."""
    memory = Memory(stamp_w=4, segment_w=2)
    for step in (3, 1):  # segment 1: nothing has been visited
        assert memory.offer((step, False, 0, 0, 0))
        memory.clock()
    for i in range(50):  # at the same tick, none of them waits
        assert memory.offer((0, True, i % 9, i % 6, i))
        memory.clock()
    waited = 0
    assert memory.offer((4, False, 0, 0, 99))
    memory.clock()
    while not memory.offer((0, False, 0, 0, 100)):
        memory.clock()
        waited += 1
    assert SQUARES <= waited <= SQUARES + 6
