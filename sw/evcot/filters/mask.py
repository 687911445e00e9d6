# SPDX-License-Identifier: Apache-2.0
"""Hot pixel mask: drops the events of marked pixels."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..ticks import TickedEvents
from .base import EventFilter, per_pixel
from .contract import FilterShape
from .registers import FilterRegisters

__all__ = ["MaskFilter"]


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
        _narrow(self.quiet, events.x, events.y, keep)


@njit(cache=True, nogil=True)
def _narrow(quiet, x, y, keep):  # type: ignore[no-untyped-def]
    height, width = quiet.shape
    for i in range(len(keep)):
        keep[i] = keep[i] and x[i] < width and y[i] < height and quiet[y[i], x[i]]
