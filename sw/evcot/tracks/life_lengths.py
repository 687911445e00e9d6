# SPDX-License-Identifier: Apache-2.0
"""How long lives last: their median and the longest, of any number of lives, read run by run."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .column import Column, in_runs
from .log import Kind

__all__ = ["life_lengths"]

_DIGIT = 16  # bits that one pass finds


def life_lengths(lives: Column) -> dict[str, Any]:
    """`tracks`, `lost`, `median_s`, `longest_s` of lives, of dtype `timeline.LIFE` or `track_pairs.ROW`; None without any."""
    count, lost, longest_us = len(lives), 0, 0
    for _, run in in_runs(lives):
        lost += int(np.count_nonzero(run["ended"] == Kind.LOST))
        longest_us = max(longest_us, int(_lengths_us(run).max()))
    middle_us = [_in_order(lives, place, longest_us) for place in {(count - 1) // 2, count // 2}] if count else []
    return {
        "tracks": count,
        "lost": lost,
        "median_s": float(np.mean(np.array(middle_us) / 1e6)) if count else None,
        "longest_s": longest_us / 1e6 if count else None,
    }


def _lengths_us(lives: NDArray[np.void]) -> NDArray[np.int64]:
    return np.asarray(lives["end_us"] - lives["birth_us"], np.int64)


def _in_order(lives: Column, place: int, longest_us: int) -> int:
    """The length at a place, if lengths were in order: digit by digit, the highest first."""
    found = 0
    for digit in reversed(range(-(-longest_us.bit_length() // _DIGIT))):
        shift = digit * _DIGIT
        counts = np.zeros(1 << _DIGIT, np.int64)
        for _, run in in_runs(lives):
            lengths_us = _lengths_us(run)
            same = lengths_us[lengths_us >> (shift + _DIGIT) == found >> (shift + _DIGIT)]
            counts += np.bincount(same >> shift & (1 << _DIGIT) - 1, minlength=1 << _DIGIT)
        so_far = np.cumsum(counts)
        value = int(np.searchsorted(so_far, place, "right"))
        place -= int(so_far[value - 1]) if value else 0
        found |= value << shift
    return found
