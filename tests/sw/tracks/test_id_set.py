# SPDX-License-Identifier: Apache-2.0
"""Ids of any size are found again, and no others."""

from __future__ import annotations

import numpy as np

from evcot.tracks.id_set import IdSet


def test_ids_that_were_added_are_there_and_no_others() -> None:
    ids, wanted = IdSet(), set[int]()
    assert 0 not in ids
    for part in ([], [3, 3, 0], [8, 1_000], [-1, 1 << 27, (1 << 62) + 1], [(1 << 27) - 1, 7]):
        ids.add(np.array(part, np.int64))
        wanted |= set(part)
        for each in {-2, 1, 2, 9, 999, 1_001, (1 << 27) + 1, (1 << 27) - 2, 1 << 62, *wanted}:
            assert (each in ids) == (each in wanted), each


def test_a_million_ids_take_a_bit_each() -> None:
    ids = IdSet()
    for begin in range(0, 1_000_000, 50_000):
        ids.add(np.arange(begin, begin + 50_000))
    assert ids.nbytes <= 2 * 1_000_000 // 8 + 8
    assert 999_999 in ids
    assert 1_000_000 not in ids
