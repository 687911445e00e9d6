# SPDX-License-Identifier: Apache-2.0
"""Row-and-column filter: keeps events near the last ones of their own and the neighbouring rows and columns.

After Khodamoradi and Kastner, "O(N)-space spatiotemporal filter for reducing noise in neuromorphic vision sensors", 2018.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit, step
from ..ticks import TickedEvents
from .base import NEVER, EventFilter
from .contract import FilterShape
from .registers import FilterRegisters

__all__ = ["RowColumnFilter"]


class RowColumnFilter(EventFilter):
    """An event passes if at least `rowcol_support` of six events support it: the last ones of columns x - 1, x, x + 1 and of
    rows y - 1, y, y + 1, each if it is at most `rowcol_ticks` ticks old, on another pixel, and at most `rowcol_radius` pixels
    away along its column or row.

    The memory holds one event per row and one per column, with a border of one without events.
    """

    def __init__(self, registers: FilterRegisters, shape: FilterShape) -> None:
        self._ticks = registers.rowcol_ticks
        self._radius = registers.rowcol_radius
        self._support = registers.rowcol_support
        self._columns = _line(shape.width)
        self._rows = _line(shape.height)

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        rule = self._ticks, self._radius, self._support
        _narrow(*self._columns, *self._rows, *rule, events.ticks, events.x, events.y, keep)


def _line(places: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Time and other coordinate of the last event at each place."""
    return np.full(places + 2, NEVER), np.zeros(places + 2, np.int64)


@njit(cache=True, nogil=True)
def _narrow(  # type: ignore[no-untyped-def]
    column_at, column_y, row_at, row_x, window, radius, support, ticks, x, y, keep
):
    width, height = len(column_at) - 2, len(row_at) - 2
    for i in range(len(keep)):
        if not keep[i]:
            continue
        keep[i] = False
        if x[i] < width and y[i] < height:
            here_x, here_y = np.int64(x[i]), np.int64(y[i])
            oldest = ticks[i] - window
            count = _supporters(column_at, column_y, here_x, here_y, oldest, radius)
            count += _supporters(row_at, row_x, here_y, here_x, oldest, radius)
            keep[i] = count >= support
            column_at[here_x + 1], column_y[here_x + 1] = ticks[i], here_y
            row_at[here_y + 1], row_x[here_y + 1] = ticks[i], here_x


@step
def _supporters(at, other, place, along, oldest, radius):  # type: ignore[no-untyped-def]
    """How many of the last events at place - 1, place, place + 1 support one at `place`, `along`."""
    count = 0
    for k in range(3):
        distance = abs(other[place + k] - along)
        count += (at[place + k] >= oldest) & (distance <= radius) & ((k != 1) | (distance != 0))
    return count
