# SPDX-License-Identifier: Apache-2.0
"""Truncated time marks: unwrapping, and locating a time in a file."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .words import Words

__all__ = ["FirstMark", "advance", "place_of_mark"]

# A kernel (words, least) -> (index, mark) of the first time mark >= `least`; the index is len(words) if there is none.
FirstMark = Callable[[NDArray[Any], int], tuple[int, int]]

_PLACES = 256
_ROUNDS = 2  # the range that is then left of a file of 4 GiB is read in a millisecond
_PIECE_WORDS = 512


@njit(cache=True, nogil=True, inline="always")
def advance(high, mark, mark_range):  # type: ignore[no-untyped-def]
    """Unwrap a mark that follows the unwrapped mark `high` (< 0: none yet): a drop by more than half is a wrap-around."""
    if high < 0:
        return mark
    turns = high // mark_range
    if high - turns * mark_range - mark > mark_range // 2:
        turns += 1
    return turns * mark_range + mark


def place_of_mark(words: Words, first_mark: FirstMark, least: int) -> int:
    """Index of the first mark >= `least`, found without reading all words; 0 if marks decrease or none is that high.

    Decreasing marks have wrapped around: then only a sequential read can count the wrap-arounds. Marks are sampled at 256
    places, so a decrease that is made up for before the next sample goes unnoticed.
    """
    begin, end = 0, len(words)
    for _ in range(_ROUNDS):
        if end - begin <= _PLACES * _PIECE_WORDS:
            break
        edges = np.linspace(begin, end, _PLACES + 1).astype(np.int64).tolist()
        found = [each for low, high in pairwise(edges) if (each := _first(words, low, high, first_mark, 0)) is not None]
        places, marks = [place for place, _ in found], [mark for _, mark in found]
        if any(later < earlier for earlier, later in pairwise(marks)):
            return 0
        reached = int(np.searchsorted(marks, least))
        begin = places[reached - 1] if reached else begin
        end = places[reached] + 1 if reached < len(places) else end
    last = _first(words, begin, end, first_mark, least)
    return 0 if last is None else last[0]


def _first(words: Words, begin: int, end: int, first_mark: FirstMark, least: int) -> tuple[int, int] | None:
    for at, piece in words.pieces(begin, end, _PIECE_WORDS):
        index, mark = first_mark(piece, least)
        if index < len(piece):
            return at + index, mark
    return None
