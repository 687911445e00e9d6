# SPDX-License-Identifier: Apache-2.0
"""cell_memory.v: the last event of each cell around an event, and whether that is stored, against a record of all cells."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from evcot_cosim.rtl.build import load
from support.tokens import Token, TokenMemory

TOP = "cell_memory"
WIDTH, HEIGHT, X_W, Y_W, STEP_W, DATA_W = 26, 11, 5, 4, 7, 12
SIDES = [(1, 9), (2, 7), (4, 5)]  # of a cell in pixels, bits of a stamp


class Wanted(NamedTuple):
    """What belongs to a token."""

    data: int
    inside: bool
    stays: bool
    ages: dict[int, int] | None  # bank -> age, of what supports it; None if nothing was asked


class Memory(TokenMemory[Wanted]):
    """Beside the hardware, time and place of each cell's last stored event."""

    def __init__(self, side: int, silence: int, ages: bool = False) -> None:
        self.side, self.silence, self.window, self.stamp_w = side, silence, 0, dict(SIDES)[side] if ages else 0
        self.now = 0
        self.last: dict[tuple[int, int], tuple[int, int, int]] = {}  # cell -> time, x, y
        self.kinds = dict.fromkeys(("stored", "silent", "supported", "too old", "other pixel"), 0)
        shape = {"X_W": X_W, "Y_W": Y_W, "WIDTH": WIDTH, "HEIGHT": HEIGHT, "STEP_W": STEP_W, "DATA_W": DATA_W}
        super().__init__(load(TOP, {**shape, "CELL_PX": side, "AGES": int(ages)}), closed=False, silence=silence)

    def compare(self, wanted: Wanted) -> None:
        io = self.sim.io
        assert (int(io.m_data), bool(io.m_inside), bool(io.m_stays)) == wanted[:3]
        if wanted.ages is None:
            return
        supporting, mask = [bank for bank in range(16) if int(io.m_supports) >> bank & 1], (1 << self.stamp_w) - 1
        assert supporting == sorted(wanted.ages)
        if self.stamp_w:
            assert {bank: int(io.m_age) >> bank * self.stamp_w & mask for bank in supporting} == wanted.ages

    def choose(self, window: int) -> None:
        """Set the age at which a cell's last event still supports; nothing is inside."""
        self.window = self.sim.io.window = window

    def awaited(self, token: Token) -> Wanted:
        step, access, x, y, data = token
        self.now += step
        inside, cell = x < WIDTH and y < HEIGHT, (x // self.side, y // self.side)
        if not (access and inside):
            return Wanted(data, inside, False, None)
        ages = {}
        for column in range(cell[0] - 1, cell[0] + 2):
            for row in range(cell[1] - 1, cell[1] + 2):
                then, *place = self.last.get((column, row), (None, x, y))
                if then is not None and ((column, row) != cell or place != [x, y]):
                    if self.now - then > self.window:
                        self.kinds["too old"] += 1
                        continue
                    ages[4 * (row % 4) + column % 4] = self.now - then
                    self.kinds["other pixel" if (column, row) == cell else "supported"] += 1
        then, *place = self.last.get(cell, (None, x, y))
        stays = not (then is not None and place == [x, y] and self.now - then < self.silence)
        self.kinds["stored" if stays else "silent"] += 1
        if stays:
            self.last[cell] = self.now, x, y
        return Wanted(data, inside, stays, ages)


@pytest.mark.parametrize(("side", "stamp_w"), SIDES)
@pytest.mark.parametrize("ages", [False, True], ids=["", "with ages"])
def test_what_is_read_and_stored_is_that_of_a_record_without_end(side: int, stamp_w: int, ages: bool) -> None:
    memory, keep = Memory(side, 3 << stamp_w - 4, ages), 3 << stamp_w - 2
    squares = -(-WIDTH // (4 * side)) * -(-HEIGHT // (4 * side))
    assert memory.cleared_after + 1 == squares + 8  # with the last clock of the reset
    for run, (busy, rate, freely, spread) in enumerate(
        [(1.0, 0.2, 1.0, 2), (0.6, 1, 0.7, 5), (0.4, 1, 1.0, 27), (0.9, 9, 0.6, 5)]
    ):

        def draw(rng: np.random.Generator, rate: float = rate, spread: int = spread) -> Token:
            step = min((1 << STEP_W) - 1, int(rng.poisson(rate)))
            at = int(rng.integers(WIDTH + 1)) // spread * spread, int(rng.integers(HEIGHT + 1)) // spread * spread
            x, y = (min(place + int(rng.integers(2)), end) for place, end in zip(at, (WIDTH, HEIGHT), strict=True))
            return step, bool(rng.random() < 0.9), x, y, int(rng.integers(1 << DATA_W))

        memory.choose(window=(keep // 3, keep // 2)[run % 2] if ages else (0, 3, keep // 2, keep - 1)[run])
        memory.run(np.random.default_rng([31, side, run]), 700, busy, freely, draw)
    print(memory.kinds)
    assert all(count > 60 for name, count in memory.kinds.items() if name != "other pixel")
    assert memory.kinds["other pixel"] == 0 if side == 1 else memory.kinds["other pixel"] > 60


@pytest.mark.parametrize("side", [side for side, _ in SIDES])
def test_silence_is_measured_from_the_last_event_that_was_stored(side: int) -> None:
    """At distances of 1 to 9 clocks: up to five clocks apart, they are corrected on the way."""
    silence = 6
    for between in range(9):
        memory = Memory(side, silence)
        for step, stays in ((0, True), (silence - 1, False), (1, True), (silence, True)):
            while not memory.offer((step, True, 6, 5, 1)):  # where time goes on by segments
                memory.clock()
            assert memory.waiting[-1].stays == stays
            memory.clock()
            memory.sim.io.s_valid = 0
            for _ in range(between):
                memory.clock()
        memory.rest()
