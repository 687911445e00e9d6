# SPDX-License-Identifier: Apache-2.0
"""EVT 2.0 (32-bit words, one event each) and EVT 2.1 (64-bit words, up to 32 events each), by the published word tables.

The top four bits are the type of a word. In EVT 2.1 the upper 32 bits are laid out like a word of EVT 2.0, and the lower 32
bits have a set bit for each event, from x on to the right. Time has 34 bits: 28 of the last time mark and 6 of the event.
https://docs.prophesee.ai/stable/data/encoding_formats/evt2.html and evt21.html
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..._numba_private import njit
from .words import Layout, WordArray, Words, advance, place_of_mark, put_vector

__all__ = ["evt2_layout", "evt21_layout", "is_upper_first"]

_ON = 1  # 0 is darker, 1 brighter: time 27..22, x 21..11, y 10..0
TIME_HIGH = 8  # 27..0: bits 33..6 of the time
LOW_BITS = 6
MARK_RANGE = 1 << 28
# Also defined: a trigger (10), a vendor's data (14) and its continuation (15). All other types are reserved.
_RESERVED = 0xFFFF & ~(1 << 0 | 1 << _ON | 1 << TIME_HIGH | 1 << 10 | 1 << 14 | 1 << 15)
_VECTOR = 32


class _State(NamedTuple):
    """high: last time mark, unwrapped, -1 before the first. upper_at: index of an EVT 2.1 word's upper half."""

    t0_us: int
    upper_at: int = 0
    high: int = -1
    untimed: int = 0
    strange: int = 0


_LOST = {"they precede any time mark": "untimed", "words of a type that EVT 2 reserves": "strange"}


@njit(cache=True, nogil=True)
def _fill_evt2(words, state, t_us, x, y, p):  # type: ignore[no-untyped-def]
    t0_us, upper_at, high, untimed, strange = state
    n = np.int64(0)
    used = min(len(words), len(t_us))
    for i in range(used):
        word = np.int64(words[i])
        kind = word >> 28
        if kind == TIME_HIGH:
            high = advance(high, word & (MARK_RANGE - 1), MARK_RANGE)
        # Always written, but the index advances only for an event.
        t_us[n] = t0_us + (high << LOW_BITS | word >> 22 & 63)
        x[n] = word >> 11 & 2047
        y[n] = word & 2047
        p[n] = kind
        is_event, is_timed = np.int64(kind <= _ON), np.int64(high >= 0)
        n += is_event & is_timed
        untimed += is_event & ~is_timed
        strange += _RESERVED >> kind & 1
    return used, n, _State(t0_us, upper_at, high, untimed, strange)


@njit(cache=True, nogil=True)
def _fill_evt21(words, state, t_us, x, y, p):  # type: ignore[no-untyped-def]
    t0_us, upper_at, high, untimed, strange = state
    halves = words.view(np.uint32)
    n = 0
    used = 0
    while used < len(words) and n + _VECTOR <= len(t_us):
        upper, lower = np.int64(halves[2 * used + upper_at]), np.int64(halves[2 * used + 1 - upper_at])
        used += 1
        kind = upper >> 28
        if kind <= _ON:
            start = n
            time_us = t0_us + (high << LOW_BITS | upper >> 22 & 63)
            n = put_vector(n, lower, time_us, upper >> 11 & 2047, upper & 2047, kind, t_us, x, y, p)
            if high < 0:
                untimed += n - start
                n = start
        elif kind == TIME_HIGH:
            high = advance(high, upper & (MARK_RANGE - 1), MARK_RANGE)
        else:
            strange += _RESERVED >> kind & 1
    return used, n, _State(t0_us, upper_at, high, untimed, strange)


@njit(cache=True, nogil=True)
def _first_mark(heads, step, least):  # type: ignore[no-untyped-def]
    for i in range(0, len(heads), step):
        head = np.int64(heads[i])
        if head >> 28 == TIME_HIGH and head & (MARK_RANGE - 1) >= least:
            return i // step, head & (MARK_RANGE - 1)
    return len(heads), 0


def _layout(dtype: type[np.unsignedinteger[Any]], most_events: int, fill: Callable[..., Any], start: _State) -> Layout:
    halves = np.dtype(dtype).itemsize // 4

    def first_mark(piece: WordArray, least: int) -> tuple[int, int]:
        index, mark = _first_mark(piece.view(np.uint32)[start.upper_at :], halves, least)
        return index, mark

    def seek(words: Words, from_us: int) -> tuple[int, _State]:
        return place_of_mark(words, first_mark, (from_us - start.t0_us) >> LOW_BITS), start

    return Layout(np.dtype(dtype), most_events, start, fill, seek, _LOST)


def evt2_layout(t0_us: int) -> Layout:
    """EVT 2.0, times from `t0_us`."""
    return _layout(np.uint32, 1, _fill_evt2, _State(t0_us))


def evt21_layout(t0_us: int, upper_first: bool) -> Layout:
    """EVT 2.1, times from `t0_us`; the upper half of each word comes first ("legacy" order), or the whole is little-endian."""
    return _layout(np.uint64, _VECTOR, _fill_evt21, _State(t0_us, upper_at=0 if upper_first else 1))


def is_upper_first(words: WordArray) -> bool:
    """Whether the upper half comes first in (n,) words of EVT 2.1, judged by the time marks, whose lower half is zero."""
    halves = words.view(np.uint32).reshape(-1, 2)
    marks = (halves >> 28 == TIME_HIGH) & (halves[:, ::-1] == 0)
    first, second = np.count_nonzero(marks, axis=0)
    return bool(first > second)
