# SPDX-License-Identifier: Apache-2.0
"""motion_mask.v: which slots' boxes and windows hold a column, while others are updated, against sets of columns."""

from __future__ import annotations

import numpy as np
import pytest

from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load

PX_W, AT_W = 10, 5
COLUMNS = 1 << AT_W
Held = tuple[set[int], set[int]]  # columns of a box, of a window


class Mask:
    """The module, and the columns of each plane of each slot."""

    def __init__(self, n: int, slot_w: int, seed: int) -> None:
        self.n, self.slot_w, self.rng = n, slot_w, np.random.default_rng(seed)
        widths = {"N": n, "SLOT_W": slot_w, "AT_W": AT_W, "PX_W": PX_W}
        self.sim = load("motion_mask", widths, extra_flags=PORTS_ONLY_FLAGS)
        self.io = self.sim.io
        self.reset()

    def reset(self) -> None:
        self.has: dict[tuple[int, int], Held] = {(slot, plane): (set(), set()) for slot in range(self.n) for plane in (0, 1)}
        self.in_effect = [0] * self.n
        self.reads: list[int | None] = [None, None]
        self.io.start = 0
        self.written: int | None = None  # column that is written in the coming clock
        self.io.chosen = (1 << self.n) - 1
        self.io.rst = 1
        self.sim.clock.tick()
        self.io.rst = 0
        clocks = 0
        while not int(self.io.ready):
            self.sim.clock.tick()
            clocks += 1
        assert clocks == (1 << max(AT_W + 1, self.slot_w + 3)) + 3
        assert not int(self.io.busy)

    def clock(self, place: int | None = None) -> None:
        """One clock, in which a column is looked up or none; checks what was looked up two clocks before."""
        io = self.io
        if place == self.written:
            place = None
        io.place = int(self.rng.integers(COLUMNS)) if place is None else place
        self.written = int(io.next_word) if int(io.writes_next) else None
        self.sim.clock.tick()
        self.reads = [place, self.reads[0]]
        column = self.reads[1]
        if column is not None:
            io.plane = sum(1 << slot for slot in range(self.n) if self.in_effect[slot])
            self.sim.eval()
            for kind, name in enumerate(("in_box", "in_window")):
                held = [column in self.has[slot, self.in_effect[slot]][kind] for slot in range(self.n)]
                assert int(io[name]) == sum(1 << slot for slot in range(self.n) if held[slot]), (name, column)

    def random_read(self) -> int | None:
        return int(self.rng.integers(COLUMNS)) if self.rng.random() < 0.8 else None

    def update(self, slot: int, box: tuple[int, int], window: tuple[int, int]) -> int:
        """Updates the plane of a slot that is not in effect; how many clocks it was busy."""
        io, target = self.io, 1 - self.in_effect[slot]
        io.slot, io.target = slot, target
        self.clock(self.random_read())
        io.start, io.chosen = 1, 1 << slot
        io.box_lo, io.box_hi = (bound % (1 << PX_W) for bound in box)
        busy = 0
        while True:
            self.clock(self.random_read())
            if io.start:
                io.start, io.slot, io.target = 0, 0, 0  # taken
            if busy == 1:
                io.window_lo, io.window_hi = (bound % (1 << PX_W) for bound in window)
            if not int(io.busy):
                break
            busy += 1
            assert busy < 500
        self.clock(self.random_read())  # in which the last word is written
        on = set(range(COLUMNS))
        held = [on & set(range(low, high + 1)) for low, high in (box, window)]
        self.has[slot, target] = held[0], held[1]
        return busy


@pytest.mark.parametrize(("n", "slot_w"), [(1, 1), (3, 2), (17, 5)])
def test_random_updates_while_columns_are_read(n: int, slot_w: int) -> None:
    mask = Mask(n, slot_w, n)
    rng, held = mask.rng, 0
    for round_ in range(400):
        slot = int(rng.integers(n))
        low = int(rng.integers(-20, COLUMNS + 20)) if rng.random() < 0.9 else int(rng.choice([-300, 300]))
        box = low, low + int(rng.integers(0, 30))
        ring = int(rng.integers(0, 9))
        mask.update(slot, box, (box[0] - ring, box[1] + ring))
        if rng.random() < 0.5:
            for _clock in range(int(rng.integers(0, 8))):
                mask.clock(mask.random_read())
            if rng.random() < 0.8:
                mask.in_effect[slot] = 1 - mask.in_effect[slot]
            for _clock in range(8):
                mask.clock(mask.random_read())
        held += sum(len(columns) for columns in mask.has[slot, mask.in_effect[slot]])
        if round_ == 200:
            mask.reset()
    assert held > 1_000


def test_clocks_of_an_update_are_those_of_the_words_that_change() -> None:
    mask = Mask(3, 2, 1)
    mask.rng = np.random.default_rng(1)
    mask.random_read = lambda: None  # type: ignore[method-assign]
    assert mask.update(1, (4, 9), (2, 12)) == 10 + 6 + 11
    assert mask.update(1, (4, 9), (2, 12)) == 8
    assert mask.update(1, (5, 9), (2, 14)) == 9 + 1 + 2
    assert mask.update(1, (20, 22), (18, 24)) == 10 + 5 + 3 + 13 + 7
