# SPDX-License-Identifier: Apache-2.0
"""Polarity filter: keeps events of one polarity."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..ticks import TickedEvents
from .base import EventFilter
from .contract import FilterShape
from .registers import FilterRegisters

__all__ = ["PolarityFilter"]


class PolarityFilter(EventFilter):
    """An event passes if p = polarity. Well below 1 ns per event."""

    def __init__(self, registers: FilterRegisters, _shape: FilterShape) -> None:
        self._polarity = registers.polarity

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        _narrow(self._polarity, events.p, keep)


@njit(cache=True, nogil=True)
def _narrow(polarity, p, keep):  # type: ignore[no-untyped-def]
    for i in range(len(keep)):
        keep[i] &= p[i] == polarity
