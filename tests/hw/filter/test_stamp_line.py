# SPDX-License-Identifier: Apache-2.0
"""stamp_line.v: of an event, the last ones of its own column and of those beside it, against a record of all."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from evcot_cosim.rtl.build import load
from support.testing import lint

TOP = "stamp_line"
PLACES, OTHER_W, PLACE_W, ROW_W, STAMP_W, SEGMENT_W = 10, 4, 4, 2, 7, 4
ROWS = 3
STAGES = 7
KEEP = (1 << STAMP_W) - (2 << SEGMENT_W)
EACH = (1 << SEGMENT_W) // ROWS - 1  # steps from one visit to the next: each row is visited within a segment


class Slot(NamedTuple):
    """What goes through the stages."""

    access: bool = False
    visit: bool = False
    row: int = 0
    time: int = 0
    place: int = 0
    other: int = 0


EMPTY = Slot()


class Line:
    """The hardware, with stages as stamp_slots.v has them, beside a record of the last event of each column."""

    def __init__(self) -> None:
        self.sim = load(
            TOP,
            {"PLACES": PLACES, "PLACE_W": PLACE_W, "OTHER_W": OTHER_W, "ROWS": ROWS, "ROW_W": ROW_W, "STAMP_W": STAMP_W,
             "SEGMENT_W": SEGMENT_W},
        )  # fmt: skip
        self.stages = [EMPTY] * STAGES
        self.last: dict[int, tuple[int, int]] = {}  # column -> time, other coordinate
        self.time = self.visits = self.compared = self.old = 0
        self.sim.io.clearing = 1
        for _ in range(ROWS + STAGES):
            self.visit()
        self.sim.io.clearing = 0

    def visit(self) -> None:
        self.visits += 1
        self.clock(Slot(visit=True, row=self.visits % ROWS, time=self.time))

    def pass_time(self, steps: int) -> None:
        """So many steps, with the visits that fall into them."""
        for _ in range(steps):
            self.time += 1
            if self.time % EACH == 0:
                self.visit()

    def event(self, place: int, other: int) -> None:
        self.clock(Slot(True, False, place // 4, self.time, place, other))

    def clock(self, entering: Slot = EMPTY, advance: bool = True) -> None:
        io = self.sim.io
        if advance:
            self.stages = [entering, *self.stages[:-1]]
        io.advance = int(advance)
        io.access = sum(slot.access << s for s, slot in enumerate(self.stages))
        io.visits = sum(slot.visit << s for s, slot in enumerate(self.stages))
        for port, width, values in (
            ("row", ROW_W, [slot.row for slot in self.stages]),
            ("now", STAMP_W, [slot.time % (1 << STAMP_W) for slot in self.stages]),
            ("place", PLACE_W, [slot.place for slot in self.stages]),
            ("other", OTHER_W, [slot.other for slot in self.stages]),
        ):
            io[port] = sum(value << s * width for s, value in enumerate(values))
        if advance and self.stages[-1].access:
            self.compare(self.stages[-1])
        self.sim.clock.tick()

    def compare(self, slot: Slot) -> None:
        """The slot in stage 6, before the clock at which it is stored."""
        io = self.sim.io
        self.sim.eval()
        columns = [column for column in range(slot.place - 1, slot.place + 2) if 0 <= column < PLACES]
        assert int(io.own) == 1 << slot.place % 4
        assert int(io.reached) == sum(1 << column % 4 for column in columns)
        for column in columns:
            age = int(io.age) >> column % 4 * STAMP_W & (1 << STAMP_W) - 1
            apart = int(io.apart) >> column % 4 * (OTHER_W + 1) & (2 << OTHER_W) - 1
            then = self.last.get(column)
            if then is None or slot.time - then[0] >= KEEP:
                assert age >= KEEP
                self.old += 1
            else:
                assert age == slot.time - then[0]
                assert apart == (then[1] - slot.other) % (2 << OTHER_W)
                self.compared += 1
        self.last[slot.place] = slot.time, slot.other


def test_lints_clean() -> None:
    assert lint(TOP) == (0, "")
    assert lint(TOP, PLACES=1, PLACE_W=1, OTHER_W=1, ROWS=1, ROW_W=1, STAMP_W=4, SEGMENT_W=2) == (0, "")


@pytest.mark.parametrize(("steps", "places", "freely"), [(1, 3, 1.0), (4, PLACES, 1.0), (4, PLACES, 0.6), (40, PLACES, 1.0)])
def test_ages_and_distances_are_those_of_the_last_events(steps: int, places: int, freely: float) -> None:
    line, rng = Line(), np.random.default_rng([23, steps, places])
    for _ in range(700):
        line.pass_time(int(rng.integers(steps + 1)))
        while rng.random() >= freely:
            line.clock(advance=False)
        line.event(int(rng.integers(places)), int(rng.integers(1 << OTHER_W)))
    for _ in range(STAGES):
        line.clock()
    assert line.compared > 150
    assert line.old > 5


def test_an_event_is_found_by_the_very_next_ones_beside_it() -> None:
    """Distances 1 to 7 in slots: five are corrected on the way, the others read from memory."""
    for between in range(8):
        line = Line()
        line.event(4, 9)
        for _ in range(between):
            line.clock()
        line.pass_time(1)
        line.event(5, 3)
        for _ in range(STAGES):
            line.clock()
        assert line.compared == 1
