# SPDX-License-Identifier: Apache-2.0
"""Decoders of Prophesee's EVT 2.0 (32-bit words) and EVT 3.0 (16-bit words), after the published word tables.

Time is the last time mark, as it is. A mark that falls by more than half its range has wrapped around; one that falls by
less is left to run backwards, for `Recording` to refuse if an event follows.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..events import Events

__all__ = ["decode_evt2", "decode_evt3"]

# EVT 2.0: bits 31..28 of a word tell what it is.
_EVT2_ON = 1  # 0 is darker, 1 brighter: time 27..22, x 21..11, y 10..0
_EVT2_TIME_HIGH = 8  # 27..0: bits 33..6 of the time
_EVT2_HIGH_RANGE = 1 << 28

# EVT 3.0: bits 15..12 of a word tell what it is.
_EVT3_Y = 0  # 10..0: row of what follows
_EVT3_X = 2  # 11: polarity, 10..0: one event
_EVT3_BASE_X = 3  # 11: polarity, 10..0: where the next vector starts
_EVT3_VECTOR_12 = 4  # 11..0: one event per set bit, to the right of the base, which moves on by 12
_EVT3_VECTOR_8 = 5  # 7..0: the same with 8
_EVT3_TIME_LOW = 6  # 11..0: bits 11..0 of the time
_EVT3_TIME_HIGH = 8  # 11..0: bits 23..12 of the time
_EVT3_HIGH_RANGE = 1 << 12


def _allocate(count: int) -> Events:
    return Events(np.empty(count, np.int64), np.empty(count, np.uint16), np.empty(count, np.uint16), np.empty(count, np.uint8))


@njit(cache=True, nogil=True)
def _advance(high, mark, mark_range):  # type: ignore[no-untyped-def]
    """Unwrap the upper part of a time; `high` < 0 before the first mark."""
    if high < 0:
        return mark
    turns = high // mark_range
    if high - turns * mark_range - mark > mark_range // 2:
        turns += 1
    return turns * mark_range + mark


@njit(cache=True, nogil=True)
def _fill_evt2(words, t0_us, t_us, x, y, p):  # type: ignore[no-untyped-def]
    high = np.int64(-1)
    n = 0
    untimed = 0
    for word in words:
        kind = word >> np.uint32(28)
        if kind == _EVT2_TIME_HIGH:
            high = _advance(high, np.int64(word & np.uint32(_EVT2_HIGH_RANGE - 1)), _EVT2_HIGH_RANGE)
        elif kind <= _EVT2_ON:
            if high < 0:
                untimed += 1
                continue
            t_us[n] = t0_us + (high << 6) + np.int64(word >> np.uint32(22) & np.uint32(63))
            x[n] = word >> np.uint32(11) & np.uint32(2047)
            y[n] = word & np.uint32(2047)
            p[n] = kind
            n += 1
    return n, untimed


def decode_evt2(words: NDArray[np.uint32], t0_us: int = 0) -> tuple[Events, int]:
    """Events of (n,) uint32 words, times from `t0_us`; and how many events came before the first time mark."""
    events = _allocate(int(np.count_nonzero(words < (_EVT2_ON + 1) << 28)))
    n, untimed = _fill_evt2(words, t0_us, events.t_us, events.x, events.y, events.p)
    return events[:n], untimed


@njit(cache=True, nogil=True)
def _count_evt3(words):  # type: ignore[no-untyped-def]
    count = 0
    for word in words:
        kind = word >> np.uint16(12)
        if kind == _EVT3_X:
            count += 1
        elif kind in (_EVT3_VECTOR_12, _EVT3_VECTOR_8):
            for bit in range(12 if kind == _EVT3_VECTOR_12 else 8):
                count += word >> bit & 1
    return count


@njit(cache=True, nogil=True)
def _fill_evt3(words, t0_us, t_us, x, y, p):  # type: ignore[no-untyped-def]
    high = np.int64(-1)
    low = np.int64(0)
    row = np.int64(-1)
    base = np.int64(-1)
    polarity = np.int64(0)
    n = 0
    untimed = 0
    for each in words:
        word = np.int64(each)
        kind = word >> 12
        if kind == _EVT3_TIME_HIGH:
            advanced = _advance(high, word & (_EVT3_HIGH_RANGE - 1), _EVT3_HIGH_RANGE)
            if advanced != high:
                low = np.int64(0)  # until its own low part arrives
            high = advanced
        elif kind == _EVT3_TIME_LOW:
            low = word & 4095
        elif kind == _EVT3_Y:
            row = word & 2047
        elif kind == _EVT3_BASE_X:
            base = word & 2047
            polarity = word >> 11 & 1
        elif kind in (_EVT3_X, _EVT3_VECTOR_12, _EVT3_VECTOR_8):
            if kind == _EVT3_X:
                start, bits, length = word & 2047, np.int64(1), 1
                polarity_here = word >> 11 & 1
            else:
                length = 12 if kind == _EVT3_VECTOR_12 else 8
                start, bits = base, word & ((1 << length) - 1)
                polarity_here = polarity
                if base >= 0:
                    base += length
            for offset in range(length):
                if bits >> offset & 1:
                    if high < 0 or row < 0 or start < 0:
                        untimed += 1
                        continue
                    t_us[n] = t0_us + (high << 12) + low
                    x[n] = start + offset
                    y[n] = row
                    p[n] = polarity_here
                    n += 1
    return n, untimed


def decode_evt3(words: NDArray[np.uint16], t0_us: int = 0) -> tuple[Events, int]:
    """Events of (n,) uint16 words, times from `t0_us`; and how many events came before the first time mark or address."""
    events = _allocate(int(_count_evt3(words)))
    n, untimed = _fill_evt3(words, t0_us, events.t_us, events.x, events.y, events.p)
    return events[:n], untimed
