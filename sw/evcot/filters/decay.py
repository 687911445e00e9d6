# SPDX-License-Identifier: Apache-2.0
"""Decay filter: keeps events with enough recent neighbours, weighted by exp(-dt / tau).

Time is counted in units of 1/32 of a half-life; docs/filters.md describes how weights are rounded to integers, and the error.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..ticks import TickedEvents
from .base import NEVER, EventFilter, per_pixel
from .contract import FilterShape
from .registers import FilterRegisters

__all__ = ["CLOCK_FRAC", "UNITS_PER_HALF_LIFE", "DecayFilter", "weights"]

UNITS_PER_HALF_LIFE = 32
CLOCK_FRAC = 24  # fractional bits of the clock that counts units
_AGES = 9 * UNITS_PER_HALF_LIFE + 1  # 256 has 9 bits: from the last of these ages on the weight is 0


def weights(epsilon: int) -> NDArray[np.int64]:
    """Weight of an event in 1/256 by its age in units, (289,) int64: 0 where it is not above `epsilon`, and at the end."""
    age = np.arange(_AGES)
    fraction = np.rint(256 * np.exp2(-np.arange(UNITS_PER_HALF_LIFE) / UNITS_PER_HALF_LIFE)).astype(np.int64)
    weight = fraction[age % UNITS_PER_HALF_LIFE] >> (age // UNITS_PER_HALF_LIFE)
    return np.where(weight > epsilon, weight, 0)


class DecayFilter(EventFilter):
    """An event passes if the weights of its 8 neighbours' last events add up to at least `decay_support`.

    About 12 ns per event.
    """

    def __init__(self, registers: FilterRegisters, shape: FilterShape) -> None:
        self._rate = registers.decay_rate
        self._support = registers.decay_support
        self._weights = weights(registers.decay_epsilon)
        self._last = per_pixel(shape, NEVER, border=1)

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        _narrow(self._last, self._rate, self._weights, self._support, events.ticks, events.x, events.y, keep)


@njit(cache=True, nogil=True)
def _weight(weight, age):  # type: ignore[no-untyped-def]
    return weight[np.uint64(min(age, _AGES - 1))]


@njit(cache=True, nogil=True)
def _narrow(last, rate, weight, support, ticks, x, y, keep):  # type: ignore[no-untyped-def]
    one, two = np.uint64(1), np.uint64(2)
    height, width = last.shape[0] - 2, last.shape[1] - 2
    for i in range(len(keep)):
        if not keep[i]:
            continue
        keep[i] = False
        if x[i] < width and y[i] < height:
            # (ticks * rate) >> 24 in two parts, as the product may have 86 bits.
            whole, rest = ticks[i] >> CLOCK_FRAC, ticks[i] & ((1 << CLOCK_FRAC) - 1)
            unit = whole * rate + ((rest * rate) >> CLOCK_FRAC)
            left, top = np.uint64(x[i]), np.uint64(y[i])
            middle, right = left + one, left + two
            centre, bottom = top + one, top + two
            total = (
                _weight(weight, unit - last[top, left])
                + _weight(weight, unit - last[top, middle])
                + _weight(weight, unit - last[top, right])
                + _weight(weight, unit - last[centre, left])
                + _weight(weight, unit - last[centre, right])
                + _weight(weight, unit - last[bottom, left])
                + _weight(weight, unit - last[bottom, middle])
                + _weight(weight, unit - last[bottom, right])
            )
            keep[i] = total >= support
            last[centre, middle] = unit
