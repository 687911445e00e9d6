# SPDX-License-Identifier: Apache-2.0
"""Background activity filter: drops isolated events."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit, step
from ..ticks import TickedEvents
from .base import NEVER, EventFilter, per_pixel
from .contract import FilterShape
from .registers import FilterRegisters

__all__ = ["ActivityFilter", "supporters"]


class ActivityFilter(EventFilter):
    """An event passes if at least `activity_support` of its 8 neighbours had an event at most `activity_ticks` ticks ago.

    About 8 ns per event, independent of the support. The memory has a border of one pixel without events, so that neighbours
    need no bounds check.
    """

    def __init__(self, registers: FilterRegisters, shape: FilterShape) -> None:
        self._ticks = registers.activity_ticks
        self._support = registers.activity_support
        self._last = per_pixel(shape, NEVER, border=1)

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        _narrow(self._last, self._ticks, self._support, events.ticks, events.x, events.y, keep)


@step
def supporters(last: Any, oldest: int, tick: int, x: int, y: int) -> int:
    """Note an event on the sensor; returns how many of its neighbours had one not before the tick `oldest`.

    Args:
        last: (height + 2, width + 2) int64, the tick of each pixel's last event, with a border of pixels without one.
    """
    # Unsigned indices avoid the check for negative ones.
    one, two = np.uint64(1), np.uint64(2)
    left, top = np.uint64(x), np.uint64(y)
    middle, right = left + one, left + two
    centre, bottom = top + one, top + two
    count = (
        (last[top, left] >= oldest)
        + (last[top, middle] >= oldest)
        + (last[top, right] >= oldest)
        + (last[centre, left] >= oldest)
        + (last[centre, right] >= oldest)
        + (last[bottom, left] >= oldest)
        + (last[bottom, middle] >= oldest)
        + (last[bottom, right] >= oldest)
    )
    last[centre, middle] = tick
    return int(count)


@njit(cache=True, nogil=True)
def _narrow(last, window, support, ticks, x, y, keep):  # type: ignore[no-untyped-def]
    height, width = last.shape[0] - 2, last.shape[1] - 2
    for i in range(len(keep)):
        if not keep[i]:
            continue
        keep[i] = False
        if x[i] < width and y[i] < height:
            keep[i] = supporters(last, ticks[i] - window, ticks[i], x[i], y[i]) >= support
