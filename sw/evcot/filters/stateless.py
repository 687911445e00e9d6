# SPDX-License-Identifier: Apache-2.0
"""Filters without memory: hot pixels, one polarity, a region."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit
from ..ticks import TickedEvents
from .base import EventFilter, per_pixel
from .contract import FilterShape
from .registers import FilterRegisters

__all__ = ["MaskFilter", "PolarityFilter", "RegionFilter"]


class MaskFilter(EventFilter):
    """An event passes if its pixel lies on the sensor and is not marked as hot. About 1.5 ns per event.

    Attributes:
        quiet: (height, width) bool, the pixels that are not marked.
    """

    def __init__(self, registers: FilterRegisters, shape: FilterShape) -> None:
        self.quiet = per_pixel(shape, True)
        for x, y in registers.hot_pixels:
            self.quiet[y, x] = False

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        _keep_quiet(self.quiet, events.x, events.y, keep)


@njit(cache=True, nogil=True)
def _keep_quiet(quiet, x, y, keep):  # type: ignore[no-untyped-def]
    height, width = quiet.shape
    for i in range(len(keep)):
        keep[i] = keep[i] and x[i] < width and y[i] < height and quiet[y[i], x[i]]


class PolarityFilter(EventFilter):
    """An event passes if p = polarity. Well below 1 ns per event."""

    def __init__(self, registers: FilterRegisters, _shape: FilterShape) -> None:
        self._polarity = registers.polarity

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        _keep_polarity(self._polarity, events.p, keep)


@njit(cache=True, nogil=True)
def _keep_polarity(polarity, p, keep):  # type: ignore[no-untyped-def]
    for i in range(len(keep)):
        keep[i] &= p[i] == polarity


class RegionFilter(EventFilter):
    """An event passes if region_x0 <= x <= region_x1 and region_y0 <= y <= region_y1. Well below 1 ns per event."""

    def __init__(self, registers: FilterRegisters, _shape: FilterShape) -> None:
        self._x = registers.region_x0, registers.region_x1
        self._y = registers.region_y0, registers.region_y1

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        _keep_inside(*self._x, *self._y, events.x, events.y, keep)


@njit(cache=True, nogil=True)
def _keep_inside(x0, x1, y0, y1, x, y, keep):  # type: ignore[no-untyped-def]
    for i in range(len(keep)):
        keep[i] &= (x0 <= x[i]) & (x[i] <= x1) & (y0 <= y[i]) & (y[i] <= y1)
