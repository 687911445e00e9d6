# SPDX-License-Identifier: Apache-2.0
"""DAT: 64-bit words, one event each: a 32-bit time that wraps around every 71.6 minutes, then x, y and polarity.

https://docs.prophesee.ai/stable/data/file_formats/dat.html
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from .time_marks import advance, place_of_mark
from .words import Layout, WordArray, Words

__all__ = ["dat_layout"]

_MARK_RANGE = 1 << 32
# version -> bits of x and of y
_ADDRESS_BITS = {1: (9, 8), 2: (14, 14)}


class _State(NamedTuple):
    """last: unwrapped time of the previous event, -1 before the first."""

    t0_us: int
    x_bits: int
    y_bits: int
    last: int = -1


@njit(cache=True, nogil=True)
def _fill(words, state, t_us, x, y, p):  # type: ignore[no-untyped-def]
    t0_us, x_bits, y_bits, last = state
    n = min(len(words), len(t_us))
    for i in range(n):
        address = np.int64(words[i] >> np.uint64(32))
        last = advance(last, np.int64(words[i] & np.uint64(_MARK_RANGE - 1)), _MARK_RANGE)
        t_us[i] = t0_us + last
        x[i] = address & ((1 << x_bits) - 1)
        y[i] = address >> x_bits & ((1 << y_bits) - 1)
        p[i] = address >> (x_bits + y_bits) & 15 != 0
    return n, n, _State(t0_us, x_bits, y_bits, last)


@njit(cache=True, nogil=True)
def _first_mark(words, least):  # type: ignore[no-untyped-def]
    for i in range(len(words)):
        mark = np.int64(words[i] & np.uint64(_MARK_RANGE - 1))
        if mark >= least:
            return i, mark
    return len(words), 0


def dat_layout(t0_us: int, version: int) -> Layout:
    """DAT of version 1 or 2, times from `t0_us`."""
    start = _State(t0_us, *_ADDRESS_BITS[version])

    def first_mark(piece: WordArray, least: int) -> tuple[int, int]:
        index, mark = _first_mark(piece, least)
        return index, mark

    def seek(words: Words, from_us: int) -> tuple[int, _State]:
        return place_of_mark(words, first_mark, from_us - t0_us), start

    return Layout(np.dtype(np.uint64), 1, start, _fill, seek, {})
