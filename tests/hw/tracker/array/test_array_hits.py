# SPDX-License-Identifier: Apache-2.0
"""array_hits.v: a slot is hit where the probe lies on no side of its window and it counts."""

from __future__ import annotations

from itertools import product

import numpy as np

from support.testing import evaluate, lint

PORTS = ("not_left", "not_right", "not_above", "not_below", "counts")


def test_every_combination_in_every_bit() -> None:
    every = np.array(list(product((0, 1), repeat=5)))
    words = {name: int((every[:, i] << np.arange(32)).sum()) for i, name in enumerate(PORTS)}  # bit i: combination i
    result = evaluate("array_hits", {"N": 32}, {name: np.array([word]) for name, word in words.items()}, ["hits"])["hits"]
    assert result.tolist() == [1 << every.tolist().index([1, 1, 1, 1, 1])]


def test_lints_clean() -> None:
    assert lint("array_hits", N=1) == (0, "")
    assert lint("array_hits", N=64) == (0, "")
