# SPDX-License-Identifier: Apache-2.0
"""The encoding `libcaer_cmp` of event_camera_msgs: how libcaer_driver packs the events of iniVation's cameras.

16-bit words, as in EVT 3.0 but with x and y exchanged: bits 15..12 are the type of a word. Each message starts anew, and counts
microseconds from its own time base. A column of up to eight pixels with one polarity is a base and a mask; then the base is
eight further down. The driver keeps 16 of the 24 bits of the time only, so the upper part wraps around after 15.
https://github.com/ros-event-camera/event_camera_codecs (libcaer_cmp_types.h, libcaer_cmp_decoder.h)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from .time_marks import advance
from .vectors import put_vector

__all__ = ["LOST", "MOST_EVENTS", "State", "fill"]

TIME_HIGH = 0  # 11..0: bits 23..12 of the time
TIME_LOW = 1  # 11..0: bits 11..0 of the time
X = 2  # 10..0: column of the events that follow
Y = 3  # 11: polarity, 10..0: one event
BASE_Y = 4  # 11: polarity, 10..0: where the next vector starts
VECTOR_8 = 5  # 7..0: one event per set bit, from the base down
MOST_EVENTS = 8  # per word

_LOW_BITS = 12
_DRIVER_MARKS, _MARKS = 1 << 4, 1 << 12  # range of the upper part of the time: as the driver writes it, as it is defined
_FAR = 1 << 15  # upper limit of the base, outside every sensor that these words can address


class State(NamedTuple):
    """State of the decoder in a message; `column` and `base` are -1 until a word sets them. high: unwrapped."""

    base_us: int
    high: int = 0
    low: int = 0
    column: int = -1
    base: int = -1
    polarity: int = 0
    unplaced: int = 0
    strange: int = 0


LOST = {"they precede any address": "unplaced", "words of a type that libcaer_cmp does not define": "strange"}


@njit(cache=True, nogil=True)
def fill(words, state, t_us, x, y, p):  # type: ignore[no-untyped-def]
    """Decode words until they end or the columns are nearly full: (words used, events decoded, state)."""
    base_us, high, low, column, base, polarity, unplaced, strange = state
    time_us = base_us + (high << _LOW_BITS | low)
    n = np.int64(0)
    used = 0
    while used < len(words) and n + MOST_EVENTS <= len(t_us):
        word = np.int64(words[used])
        used += 1
        kind = word >> 12
        if kind == Y:
            t_us[n] = time_us
            x[n] = column
            y[n] = word & 2047
            p[n] = word >> 11 & 1
            n += column >= 0
            unplaced += column < 0
        elif kind == X:
            column = word & 2047
        elif kind == TIME_LOW:
            low = word & 4095
            time_us = base_us + (high << _LOW_BITS | low)
        elif kind == BASE_Y:
            base, polarity = word & 2047, word >> 11 & 1
        elif kind == VECTOR_8:
            start = n
            n = put_vector(n, word & 255, time_us, base, column, polarity, t_us, y, x, p)
            if (column < 0) | (base < 0):
                unplaced += n - start
                n = start
            base = min(base + 8, _FAR) if base >= 0 else base
        elif kind == TIME_HIGH:
            mark = word & 4095
            high = advance(high, mark, _DRIVER_MARKS if mark < _DRIVER_MARKS else _MARKS)
            time_us = base_us + (high << _LOW_BITS | low)
        else:
            strange += 1
    return used, n, State(base_us, high, low, column, base, polarity, unplaced, strange)
