# SPDX-License-Identifier: Apache-2.0
"""The modules that hold stamps: units, banks, slots and lines."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pytest

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import PATTERNS, Sink, Source, always, lint, run_streams, sometimes


@pytest.mark.parametrize("tick_w", [1, 8, 20])
@pytest.mark.parametrize("pattern", PATTERNS)
def test_units_add_up_to_the_ticks_shifted_as_far_as_they_fit(tick_w: int, pattern: str) -> None:
    rng = np.random.default_rng([92, tick_w])
    sim = load("stamp_units", {"TICK_W": tick_w, "UNITS_W": 9, "DATA_W": 8})
    reset(sim)
    total = 0
    for shift in (0, 3, 15, 1):
        sim.io.shift = shift
        ticks = rng.integers(0, 1 << tick_w, 200)
        words = [(int(tick), int(data)) for tick, data in zip(ticks, rng.integers(0, 256, 200), strict=True)]
        source = Source(sim, "s", ("tick", "data"), words, PATTERNS[pattern](rng))
        sink = Sink(sim, "m", ("units", "data"), PATTERNS[pattern](rng))
        run_streams(sim, [source], [sink])
        passed = total + np.concatenate([[0], np.cumsum(ticks)])
        assert [word[0] for word in sink.words] == np.minimum(np.diff(passed >> shift), 511).tolist()
        assert [word[1] for word in sink.words] == [data for _, data in words]
        total = int(passed[-1])
        assert sim.io.idle == 1


@pytest.mark.parametrize(("in_w", "out_w"), [(21, 9), (16, 5), (33, 9), (10, 9), (6, 5)])
def test_a_shifted_value_is_all_ones_where_it_has_too_many_bits(in_w: int, out_w: int) -> None:
    sim = load("shift_saturate", {"IN_W": in_w, "OUT_W": out_w})
    assert lint("shift_saturate", IN_W=in_w, OUT_W=out_w) == (0, "")
    rng = np.random.default_rng([93, in_w, out_w])
    for length in rng.integers(0, in_w + 1, 500):
        sim.io.value, sim.io.shift = value, shift = int(rng.integers(1 << length)), int(rng.integers(16))
        sim.eval()
        assert sim.io.y == min(value >> shift, (1 << out_w) - 1)


DEPTH = 5  # stages from `read` to `age`
WORD_W = 9


@pytest.mark.parametrize(("rows", "some"), [(1, [0]), (3, [0, 1, 2]), (5000, [0, 1, 2047, 2048, 4095, 4096, 4999])])
@pytest.mark.parametrize("stalls", [0.0, 0.3], ids=["flowing", "stalling"])
@pytest.mark.parametrize("word_w", [WORD_W, 25])
def test_every_slot_sees_all_writes_ahead_of_it(rows: int, some: list[int], stalls: float, word_w: int) -> None:
    sim = load("stamp_bank", {"ROWS": rows, "ROW_W": max(1, (rows - 1).bit_length()), "WORD_W": word_w})
    io, rng, n = sim.io, np.random.default_rng([91, rows]), 1500
    row = rng.choice(some, n).tolist()
    writes = (np.arange(n) < 20) | (rng.random(n) < 0.6)
    row[: len(some)] = some  # each is written before it is looked at
    word = rng.integers(0, 1 << word_w, n).tolist()
    expected: list[int | None] = []
    memory: dict[int, int] = {}
    for i in range(n):
        expected.append(memory.get(row[i]))
        if writes[i]:
            memory[row[i]] = word[i]

    checked = 0
    for t in range(n):
        io.read_row = row[t]
        old = t - DEPTH
        io.writes, io.write_row, io.write_word = (int(writes[old]), row[old], word[old]) if old >= 0 else (0, 0, 0)
        io.last_word = word[old - 1] if old >= 1 else 0
        io.second_word = word[old - 2] if old >= 2 else 0
        io.meets = sum((old >= 0 and row[t - (4 - bit)] == row[old]) << bit for bit in range(5))
        while rng.random() < stalls:
            io.advance = 0
            sim.clock.tick()
        io.advance = 1
        sim.eval()
        if old >= 0 and expected[t - 4] is not None:
            assert int(io.was) == expected[t - 4], t
            checked += 1
        sim.clock.tick()
    assert checked > 0.9 * n


TOP = "stamp_slots"
STAMP_W, SEGMENT_W, STEP_W, ROWS, ROW_W, DATA_W = 8, 5, 6, 6, 3, 10
STAGES = 7
WIDTHS = {"row": ROW_W, "now": STAMP_W, "data": DATA_W}

Token = tuple[int, bool, int, int]  # steps, access, row, data


class Slots:
    """The hardware, clock by clock; what always holds is checked at every clock.

    Attributes:
        passed: (access, row, stamp, data) of the tokens that have reached stage 6.
        visited: (stamp, row) of the visits that have.
    """

    def __init__(self, advances: Iterator[bool]) -> None:
        self.sim = load(
            TOP, {"STAMP_W": STAMP_W, "SEGMENT_W": SEGMENT_W, "STEP_W": STEP_W, "ROWS": ROWS, "ROW_W": ROW_W, "DATA_W": DATA_W}
        )
        self.advances = advances
        self.passed: list[tuple[bool, int, int, int]] = []
        self.visited: list[tuple[int, int]] = []
        self.sim.io.advance = 1
        reset(self.sim)

    def stages(self) -> list[tuple[bool, bool, int, int, int]]:
        """Access, visit, row, stamp and data of each stage."""
        io = self.sim.io
        fields = [[int(io[name]) >> s * width & (1 << width) - 1 for s in range(STAGES)] for name, width in WIDTHS.items()]
        marks = [[bool(int(io[name]) >> s & 1) for s in range(STAGES)] for name in ("access", "visits")]
        return list(zip(*marks, *fields, strict=True))

    def clock(self, token: Token | None = None) -> bool:
        """One clock, in which a token may be on offer; whether it was taken."""
        io, moves = self.sim.io, next(self.advances)
        io.advance = int(moves)
        io.s_valid = int(token is not None)
        if token is not None:
            io.s_step, io.s_access, io.s_row, io.s_data = token[0], int(token[1]), token[2], token[3]
        taken = token is not None and bool(io.s_ready)
        before = self.stages()
        access, visit, row, now, data = before[-1]
        if moves and io.m_valid:
            self.passed.append((access, row if access else -1, now, data))
        if moves and visit:
            self.visited.append((now, row))
        assert not (access and visit)
        self.sim.clock.tick()
        assert self.stages()[1:] == (before[:-1] if moves else before[1:])
        return taken


def run(tokens: list[Token], advances: Iterator[bool]) -> Slots:
    slots = Slots(advances)
    for token in tokens:
        while not slots.clock(token):
            pass
    while not slots.sim.io.idle:
        slots.clock()
    return slots


def random_tokens(count: int, most: int) -> list[Token]:
    rng = np.random.default_rng(11)
    return [
        (int(rng.integers(most)), bool(rng.random() < 0.7), int(rng.integers(ROWS)), int(rng.integers(1 << DATA_W)))
        for _ in range(count)
    ]


def test_after_reset_every_row_is_cleared_once_before_a_token_is_taken() -> None:
    slots, clocks = Slots(always()), 0
    while not slots.sim.io.idle:
        assert slots.sim.io.clearing or slots.stages()[-1][1]
        assert not slots.clock((0, False, 0, 0))
        clocks += 1
    assert [row for _, row in slots.visited] == list(range(ROWS))
    assert clocks + 1 == ROWS + 8  # with the last clock of the reset


def test_a_token_is_in_stage_6_eight_clocks_after_it_was_taken() -> None:
    slots = run([], always())
    assert slots.clock((0, True, 4, 77))
    for _ in range(7):
        assert not slots.sim.io.m_valid
        slots.clock()
    assert slots.sim.io.m_valid
    assert slots.stages()[-1] == (True, False, 4, 0, 77)


@pytest.mark.parametrize(("most", "freely"), [(2, 1.0), (2, 0.6), (60, 0.7)])
def test_tokens_come_out_in_order_with_the_time_that_has_passed(most: int, freely: float) -> None:
    tokens = random_tokens(300, most)
    slots = run(tokens, always() if freely == 1.0 else sometimes(np.random.default_rng(5), freely))
    times = np.cumsum([step for step, *_ in tokens])
    assert slots.passed == [
        (access, row if access else -1, int(time) % (1 << STAMP_W), data)
        for time, (_, access, row, data) in zip(times, tokens, strict=True)
    ]


def test_rows_are_visited_in_turn_and_often_enough() -> None:
    """The time from one visit of a row to the next, in the order of stage 6, is less than two segments."""
    slots = run(random_tokens(600, 4), sometimes(np.random.default_rng(6), 0.8))
    rows = [row for _, row in slots.visited]
    assert rows == [i % ROWS for i in range(len(rows))]
    stamps = np.array([stamp for stamp, _ in slots.visited])[: len(rows) // ROWS * ROWS].reshape(-1, ROWS)
    apart = np.diff(stamps, axis=0) % (1 << STAMP_W)
    assert len(apart) > 20
    assert apart.max() < 2 << SEGMENT_W


STAMP_LINE_TOP = "stamp_line"
PLACES, OTHER_W, PLACE_W, STAMP_LINE_ROW_W, STAMP_LINE_STAMP_W, STAMP_LINE_SEGMENT_W = 10, 4, 4, 2, 7, 4
STAMP_LINE_ROWS = 3
KEEP = (1 << STAMP_LINE_STAMP_W) - (2 << STAMP_LINE_SEGMENT_W)
EACH = (
    1 << STAMP_LINE_SEGMENT_W
) // STAMP_LINE_ROWS - 1  # steps from one visit to the next: each row is visited within a segment


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
            STAMP_LINE_TOP,
            {"PLACES": PLACES, "PLACE_W": PLACE_W, "OTHER_W": OTHER_W, "ROWS": STAMP_LINE_ROWS, "ROW_W": STAMP_LINE_ROW_W,
             "STAMP_W": STAMP_LINE_STAMP_W, "SEGMENT_W": STAMP_LINE_SEGMENT_W},
        )  # fmt: skip
        self.stages = [EMPTY] * STAGES
        self.last: dict[int, tuple[int, int]] = {}  # column -> time, other coordinate
        self.time = self.visits = self.compared = self.old = 0
        self.sim.io.clearing = 1
        for _ in range(STAMP_LINE_ROWS + STAGES):
            self.visit()
        self.sim.io.clearing = 0

    def visit(self) -> None:
        self.visits += 1
        self.clock(Slot(visit=True, row=self.visits % STAMP_LINE_ROWS, time=self.time))

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
            ("row", STAMP_LINE_ROW_W, [slot.row for slot in self.stages]),
            ("now", STAMP_LINE_STAMP_W, [slot.time % (1 << STAMP_LINE_STAMP_W) for slot in self.stages]),
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
            age = int(io.age) >> column % 4 * STAMP_LINE_STAMP_W & (1 << STAMP_LINE_STAMP_W) - 1
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
