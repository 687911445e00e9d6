# SPDX-License-Identifier: Apache-2.0
"""stamp_bank.v: a slot reads what a memory without delay would hold, though it is written five stages later."""

from __future__ import annotations

import numpy as np
import pytest

from evcot_cosim.rtl.build import load
from support.testing import lint

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


@pytest.mark.parametrize("rows", [1, 2048, 2049, 57_600])
def test_lints_clean(rows: int) -> None:
    assert lint("stamp_bank", ROWS=rows, ROW_W=max(1, (rows - 1).bit_length())) == (0, "")
