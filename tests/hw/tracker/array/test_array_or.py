# SPDX-License-Identifier: Apache-2.0
"""array_or.v: five words, or."""

from __future__ import annotations

import numpy as np
import pytest

from support.testing import evaluate, lint

WORDS = ["a", "b", "c", "d", "e"]


@pytest.mark.parametrize("width", [1, 7])
def test_random_words(width: int) -> None:
    ports = dict(zip(WORDS, np.random.default_rng(width).integers(0, 1 << width, (5, 200)), strict=True))
    result = evaluate("array_or", {"W": width}, ports, ["y"])["y"]
    assert result.tolist() == np.bitwise_or.reduce(list(ports.values())).tolist()


@pytest.mark.parametrize("word", WORDS)
def test_every_word_counts(word: str) -> None:
    ports = {name: np.array([0b1011 if name == word else 0]) for name in WORDS}
    assert evaluate("array_or", {"W": 4}, ports, ["y"])["y"].tolist() == [0b1011]


def test_lints_clean() -> None:
    assert lint("array_or", W=1) == (0, "")
    assert lint("array_or") == (0, "")
