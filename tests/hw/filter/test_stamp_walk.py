# SPDX-License-Identifier: Apache-2.0
"""stamp_walk.v: every row is visited before its stamps wrap, and tokens pass in order with their ticks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
import pytest

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import always, sometimes

TOP = "stamp_walk"
W, SEGMENT_W, STEP_W, ROWS = 5, 2, 7, 5
SEGMENT = 1 << SEGMENT_W
KEEP = (1 << W) - 2 * SEGMENT
DEPTH = 4  # clocks from the slot that a visit enters to its end, as in stamp_memory.v

PATIENCE = 2_000  # clocks, many more than anything takes

Token = tuple[int, bool]  # steps, access


@dataclass
class Walk:
    """The hardware with the pipeline that it walks through; what always holds is checked at every clock.

    Attributes:
        advances: when the pipeline moves.
        misses: how likely it is that a visit at the end of the pipeline was in vain.
        tokens: what is on its way in, the next one first.
        time: steps that have passed since reset, as far as they count; it never wraps.
        passed: the time at which each token entered the pipeline.
        visited: row -> the time of its last visit that was not in vain.
        visits: rows in the order in which they were visited, in vain or not.
    """

    advances: Iterator[bool] = field(default_factory=always)
    misses: float = 0.0
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))
    tokens: list[Token] = field(default_factory=list)
    time: int = 0
    passed: list[int] = field(default_factory=list)
    visited: dict[int, int] = field(default_factory=dict)
    visits: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.sim = load(TOP, {"W": W, "SEGMENT_W": SEGMENT_W, "STEP_W": STEP_W, "ROWS": ROWS, "ROW_W": 3})
        self._held: list[bool] = []  # whether the token that the hardware holds has an event
        self._under_way: list[tuple[int, int] | None] = [None] * DEPTH  # row and time of visits
        self.sim.io.advance = 1
        reset(self.sim)

    def clock(self) -> None:
        """One clock of the hardware, and of the pipeline if that moves."""
        io, ending = self.sim.io, self._under_way[-1]
        io.advance = int(next(self.advances))
        io.visited, io.visited_row = int(ending is not None), ending[0] if ending else 0
        io.missed = int(ending is not None and self.rng.random() < self.misses)
        io.s_valid = int(bool(self.tokens))
        io.s_step, io.s_access = self.tokens[0] if self.tokens else (int(self.rng.integers(1 << STEP_W)), 1)
        assert bool(io.waits) == bool(self._held)
        assert not (io.clearing and (io.s_ready or io.enters))
        takes = bool(io.s_valid and io.s_ready)
        if io.advance:
            self._move(ending)
        self.sim.clock.tick()
        if takes:
            self._held.append(bool(self.tokens.pop(0)[1]))

    def _move(self, ending: tuple[int, int] | None) -> None:
        io = self.sim.io
        self.time += (int(io.now) - self.time) % (1 << W)
        if io.enters:
            self.passed.append(self.time)
            assert bool(io.access) == self._held.pop()
        assert not (io.access and io.visits)
        if ending and not io.missed:
            self.visited[ending[0]] = ending[1]
        assert all(self.time - then <= 2 * SEGMENT - 1 for then in self.visited.values())
        entering = (int(io.row), self.time) if io.visits else None
        self.visits += [entering[0]] if entering else []
        self._under_way = [None] * DEPTH if io.missed else [entering, *self._under_way[:-1]]

    def clear(self) -> int:
        """Waits for the first walk's end; returns how many clocks that took."""
        clocks = 0
        while self.sim.io.clearing:
            assert clocks < PATIENCE
            self.clock()
            clocks += 1
        return clocks

    def clocks_of(self, *tokens: Token) -> int:
        """Sends tokens one after another; returns in how many clocks the last one has entered."""
        self.tokens += tokens
        wanted, clocks = len(self.passed) + len(tokens), 0
        while len(self.passed) < wanted:
            assert clocks < PATIENCE
            self.clock()
            clocks += 1
        return clocks


class TestStories:
    def test_after_reset_every_row_is_visited_once_and_no_token_taken(self) -> None:
        walk = Walk(tokens=[(0, True)])
        assert walk.clear() == ROWS + DEPTH
        assert walk.visits == list(range(ROWS))
        assert walk.visited.keys() == set(range(ROWS))
        assert walk.tokens == [(0, True)]

    def test_a_token_enters_a_clock_after_it_came_and_the_next_one_right_behind_it(self) -> None:
        walk = Walk()
        walk.clear()
        assert walk.clocks_of(*[(0, True)] * 10) == 1 + 10
        assert walk.clocks_of((SEGMENT - 1, False)) == 2
        assert walk.passed == [0] * 10 + [SEGMENT - 1]

    def test_a_token_enters_the_next_segment_when_every_row_was_visited_in_this_one(self) -> None:
        walk = Walk()
        walk.clear()
        assert walk.clocks_of((SEGMENT - 1, True), (1, True)) == 3  # in the first one they were, before anything else
        clocks = walk.clocks_of((SEGMENT, True))
        assert ROWS + DEPTH <= clocks <= ROWS + DEPTH + 2
        assert walk.visited == dict.fromkeys(range(ROWS), SEGMENT)

    def test_a_jump_goes_through_all_segments_one_after_another(self) -> None:
        walk = Walk()
        walk.clear()
        walk.clocks_of((3 * SEGMENT + 1, True))
        assert walk.passed == [3 * SEGMENT + 1]
        assert walk.visits[: 3 * ROWS] == [*range(ROWS)] * 3

    def test_events_go_before_visits(self) -> None:
        walk = Walk()
        walk.clear()
        walk.clocks_of((SEGMENT, True))
        before = len(walk.visits)
        walk.clocks_of(*[(0, True)] * 50)
        assert len(walk.visits) <= before + 1
        walk.clocks_of(*[(0, False)] * 50)  # need no slot
        assert walk.visits[before:] == list(range(ROWS))

    def test_of_a_tokens_steps_count_as_many_as_stamps_can_tell(self) -> None:
        walk = Walk()
        walk.clear()
        walk.clocks_of((KEEP, True), (KEEP + 1, True), ((1 << STEP_W) - 1, True))
        assert walk.passed == [KEEP, 2 * KEEP, 3 * KEEP]


@pytest.mark.parametrize("seed", range(4))
def test_random_tokens_while_visits_are_in_vain_and_the_pipeline_stands_still(seed: int) -> None:
    """No row is left alone for two segments; each token has its own time."""
    rng = np.random.default_rng([81, seed])
    walk = Walk(sometimes(rng, 0.7), misses=(0, 0.05, 0.3, 0.1)[seed], rng=rng)
    walk.clear()
    steps = rng.choice([0, 0, 1, 3, SEGMENT, 11, KEEP - 1, KEEP, 100], 150)
    for step, access in zip(steps.tolist(), (rng.random(150) < 0.6).tolist(), strict=True):
        walk.clocks_of((step, access))
        for _ in range(rng.geometric(0.5)):
            walk.clock()
    assert walk.passed == np.cumsum(np.minimum(steps, KEEP)).tolist()
    assert walk.visited.keys() == set(range(ROWS))
