# SPDX-License-Identifier: Apache-2.0
"""EVT 3.0: 16-bit words, each of which updates one part of the decoder's state, by the published word table.

Bits 15..12 are the type of a word. Time has 24 bits, which wrap around every 16.8 s: 12 of the last upper time mark, and 12 of
the last lower time mark after it.
https://docs.prophesee.ai/stable/data/encoding_formats/evt3.html
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..._numba_private import njit, step
from .words import Layout, Words, advance, put_vector

__all__ = ["evt3_layout"]

Y = 0  # 10..0: row of the events that follow
_OTHER_Y = 1  # reserved; formerly the row of events other than brightness changes, so the row is unknown after it
X = 2  # 11: polarity, 10..0: one event
BASE_X = 3  # 11: polarity, 10..0: where the next vector starts
VECTOR_12 = 4  # 11..0: one event per set bit, from the base to the right; then the base advances by 12
VECTOR_8 = 5  # 7..0: the same with 8
TIME_LOW = 6  # 11..0: bits 11..0 of the time
TIME_HIGH = 8  # 11..0: bits 23..12 of the time
LOW_BITS = 12
MARK_RANGE = 1 << 12
# Also defined: triggers (10), vendors' data (14) and what continues it (7, 15). 1, 9 and 11 to 13 are reserved.
_RESERVED = 1 << _OTHER_Y | 1 << 9 | 1 << 11 | 1 << 12 | 1 << 13

_VECTOR = 12
# Upper limit of the base however many vectors follow: outside every sensor that these words can address.
_FAR = 1 << 15
_SCAN_WORDS = 1 << 18


class _State(NamedTuple):
    """State of the decoder; `high`, `row` and `base` are -1 until a word sets them."""

    t0_us: int
    high: int = -1
    low: int = 0
    row: int = -1
    base: int = -1
    polarity: int = 0
    untimed: int = 0
    strange: int = 0


_LOST = {"they precede any time mark or address": "untimed", "words of a type that EVT 3 reserves": "strange"}


@njit(cache=True, nogil=True)
def _fill(words, state, t_us, x, y, p):  # type: ignore[no-untyped-def]
    t0_us, high, low, row, base, polarity, untimed, strange = state
    time_us = t0_us + (high << LOW_BITS | low)
    n = np.int64(0)
    used = 0
    while used < len(words) and n + _VECTOR <= len(t_us):
        word = np.int64(words[used])
        used += 1
        kind = word >> 12
        if kind == X:
            t_us[n] = time_us
            x[n] = word & 2047
            y[n] = row
            p[n] = word >> 11 & 1
            is_known = np.int64((high >= 0) & (row >= 0))
            n += is_known
            untimed += 1 - is_known
        elif kind == Y:
            row = word & 2047
        elif kind in (VECTOR_12, VECTOR_8):
            start = n
            length = 12 if kind == VECTOR_12 else 8
            n = put_vector(n, word & ((1 << length) - 1), time_us, base, row, polarity, t_us, x, y, p)
            if (high < 0) | (row < 0) | (base < 0):
                untimed += n - start
                n = start
            base = _moved(base, length)
        elif kind == BASE_X:
            base, polarity = word & 2047, word >> 11 & 1
        elif kind == TIME_LOW:
            low = word & 4095
            time_us = t0_us + (high << LOW_BITS | low)
        elif kind == TIME_HIGH:
            high, low = _raised(high, low, word)
            time_us = t0_us + (high << LOW_BITS | low)
        else:
            strange += _RESERVED >> kind & 1
            row = -1 if kind == _OTHER_Y else row
    return used, n, _State(t0_us, high, low, row, base, polarity, untimed, strange)


@step
def _moved(base, length):  # type: ignore[no-untyped-def]
    return min(base + length, _FAR) if base >= 0 else base


@step
def _raised(high, low, word):  # type: ignore[no-untyped-def]
    """Both parts of the time after an upper mark: a new upper mark resets the lower part to zero."""
    mark = advance(high, word & (MARK_RANGE - 1), MARK_RANGE)
    return mark, low if mark == high else 0


@njit(cache=True, nogil=True)
def _follow(words, state, least):  # type: ignore[no-untyped-def]
    """Follow the state, without events, up to the first upper mark >= `least`: (words used, state).

    Recording only the last position of each word type takes less than a third of the time of decoding.
    """
    t0_us, high, low, row, base, polarity, untimed, strange = state
    last = np.full(16, -1)
    raised_at = -1
    used = len(words)
    for i in range(len(words)):
        kind = words[i] >> 12
        if kind == TIME_HIGH:
            mark, _ = _raised(high, low, np.int64(words[i]))
            if mark >= least:
                used = i
                break
            raised_at = raised_at if mark == high else i
            high = mark
        last[kind] = i
    if last[TIME_LOW] > raised_at:
        low = np.int64(words[last[TIME_LOW]]) & 4095
    elif raised_at >= 0:
        low = 0
    row_at = max(last[Y], last[_OTHER_Y])
    if row_at >= 0:
        row = np.int64(words[row_at]) & 2047 if row_at == last[Y] else -1
    if last[BASE_X] >= 0:
        word = np.int64(words[last[BASE_X]])
        base, polarity = word & 2047, word >> 11 & 1
    for i in range(last[BASE_X] + 1, max(last[VECTOR_12], last[VECTOR_8]) + 1):
        kind = words[i] >> 12
        base = _moved(base, 12 * (kind == VECTOR_12) + 8 * (kind == VECTOR_8))
    return used, _State(t0_us, high, low, row, base, polarity, untimed, strange)


def evt3_layout(t0_us: int) -> Layout:
    """EVT 3.0, times from `t0_us`."""
    start = _State(t0_us)

    def seek(words: Words, from_us: int) -> tuple[int, _State]:
        # The number of wrap-arounds up to there can only be counted from the words.
        least, state = (from_us - t0_us) >> LOW_BITS, start
        for at, piece in words.pieces(0, len(words), _SCAN_WORDS):
            used, state = _follow(piece, state, least)
            if used < len(piece):
                return at + used, state
        return len(words), state

    return Layout(np.dtype(np.uint16), _VECTOR, start, _fill, seek, _LOST)
