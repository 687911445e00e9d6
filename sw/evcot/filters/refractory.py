# SPDX-License-Identifier: Apache-2.0
"""Refractory filter: drops the events of a pixel for some time after one that passed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit
from ..ticks import TickedEvents
from .base import NEVER, EventFilter, per_pixel
from .contract import FilterShape
from .registers import FilterRegisters

__all__ = ["RefractoryFilter"]


class RefractoryFilter(EventFilter):
    """An event passes if no event of its pixel has passed in the last `refractory_ticks` ticks. About 6 ns per event."""

    def __init__(self, registers: FilterRegisters, shape: FilterShape) -> None:
        self._ticks = registers.refractory_ticks
        self._stayed = per_pixel(shape, NEVER)

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        _narrow(self._stayed, self._ticks, events.ticks, events.x, events.y, keep)


@njit(cache=True, nogil=True)
def _narrow(stayed, silence, ticks, x, y, keep):  # type: ignore[no-untyped-def]
    height, width = stayed.shape
    for i in range(len(keep)):
        if not keep[i]:
            continue
        keep[i] = x[i] < width and y[i] < height and ticks[i] - stayed[y[i], x[i]] >= silence
        if keep[i]:
            stayed[y[i], x[i]] = ticks[i]
