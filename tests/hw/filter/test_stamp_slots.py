# SPDX-License-Identifier: Apache-2.0
"""stamp_slots.v: tokens and visits go through seven stages in order, each stage with what belongs to its slot."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import always, lint, sometimes

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


@pytest.mark.parametrize("parameters", [{}, {"ROWS": 1, "ROW_W": 1, "STEP_W": 1}, {"STAMP_W": 32, "STEP_W": 32, "DATA_W": 64}])
def test_lints_clean(parameters: dict[str, int]) -> None:
    assert lint(TOP, **parameters) == (0, "")


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
