# SPDX-License-Identifier: Apache-2.0
"""Recent-event filter: keeps events with enough neighbours among the last few events, which are held in a FIFO."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit, step
from ..ticks import TickedEvents
from .base import EventFilter
from .contract import FilterShape
from .registers import FilterRegisters

__all__ = ["RecentFilter"]

# Address in an empty entry: far from every pixel.
_NOWHERE = -(1 << 20)


class RecentFilter(EventFilter):
    """An event passes if at least `recent_support` of the last `recent_depth` events lie within `recent_radius` of it, on
    other pixels, and are at most `recent_ticks` ticks old. About 17 ns per event at a depth of 32.

    Independent of the sensor size: it stores addresses, and has no per-pixel memory.
    """

    def __init__(self, registers: FilterRegisters, shape: FilterShape) -> None:
        self._ticks = registers.recent_ticks
        self._radius = np.int32(registers.recent_radius)
        self._support = registers.recent_support
        self._x = np.full(shape.recent_depth, _NOWHERE, np.int32)
        self._y = np.full(shape.recent_depth, _NOWHERE, np.int32)
        self._at = np.zeros(shape.recent_depth, np.int64)
        self._place = np.zeros(2, np.int64)  # index of the next entry, and number of entries

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        fifo, rule = (self._x, self._y, self._at, self._place), (self._ticks, self._radius, self._support)
        _narrow(*fifo, *rule, events.ticks, events.x, events.y, keep)


@njit(cache=True, nogil=True)
def _narrow(fifo_x, fifo_y, fifo_at, place, window, radius, support, ticks, x, y, keep):  # type: ignore[no-untyped-def]
    depth = len(fifo_at)
    head, held = place
    tail = head - held + (depth if held > head else 0)
    for i in range(len(keep)):
        if not keep[i]:
            continue
        while held and ticks[i] - fifo_at[tail] > window:
            fifo_x[tail] = _NOWHERE
            tail = tail + 1 if tail + 1 < depth else 0
            held -= 1
        keep[i] = _near(fifo_x, fifo_y, np.int32(x[i]), np.int32(y[i]), radius) >= support
        fifo_x[head], fifo_y[head], fifo_at[head] = x[i], y[i], ticks[i]
        head = head + 1 if head + 1 < depth else 0
        if held < depth:
            held += 1
        else:
            tail = head
    place[0], place[1] = head, held


@step
def _near(fifo_x, fifo_y, x, y, radius):  # type: ignore[no-untyped-def]
    """The number of entries at a distance from 1 to `radius`."""
    # 32 bits throughout, casts included: vector code processes twice as many entries at once.
    count, one = np.int32(0), np.int32(1)
    for k in range(len(fifo_x)):
        dx, dy = np.int32(abs(np.int32(fifo_x[k] - x))), np.int32(abs(np.int32(fifo_y[k] - y)))
        distance = max(dx, dy)
        count = np.int32(count + np.int32((distance >= one) & (distance <= radius)))
    return count
