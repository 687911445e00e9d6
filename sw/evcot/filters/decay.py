# SPDX-License-Identifier: Apache-2.0
"""Decay filter: keeps events with enough recent neighbours, weighted by exp(-dt / tau).

Time is counted in units of 1/32 of a half-life; docs/filters.md describes how weights are rounded to integers, and the error.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit, step
from ..ticks import TickedEvents
from .base import NEVER, EventFilter, per_pixel
from .cells import CellMemory, cell_of
from .contract import CLOCK_FRAC, UNITS_PER_HALF_LIFE, FilterShape
from .registers import FilterRegisters

__all__ = ["DecayFilter", "weights"]

_AGES = 9 * UNITS_PER_HALF_LIFE + 1  # 256 has 9 bits: from the last of these ages on the weight is 0


def weights(epsilon: int) -> NDArray[np.int64]:
    """Weight of an event in 1/256 by its age in units, (289,) int64: 0 where it is not above `epsilon`, and at the end."""
    age = np.arange(_AGES)
    fraction = np.rint(256 * np.exp2(-np.arange(UNITS_PER_HALF_LIFE) / UNITS_PER_HALF_LIFE)).astype(np.int64)
    weight = fraction[age % UNITS_PER_HALF_LIFE] >> (age // UNITS_PER_HALF_LIFE)
    return np.where(weight > epsilon, weight, 0)


class DecayFilter(EventFilter):
    """An event passes if the weights of its 8 neighbours' last events add up to at least `decay_support`.

    About 12 ns per event. With cells, those of the 9 cells around, its own if that cell's last event was on another pixel; ages
    are rounded to units of cell_px^2 / 32 of a half-life.
    """

    def __init__(self, registers: FilterRegisters, shape: FilterShape) -> None:
        self._rate = registers.decay_rate
        self._support = registers.decay_support
        self._weights = weights(registers.decay_epsilon)
        self._cells: CellMemory | None = None
        if shape.cell_px:
            self._cells = CellMemory(shape)
            self._size = shape.width, shape.height
        else:
            self._last = per_pixel(shape, NEVER, border=1)

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        if self._cells is not None:
            cells = self._cells
            memory = cells.last, cells.place, cells.bits
            rule = self._rate, self._weights, self._support
            _narrow_cells(*memory, *self._size, *rule, events.ticks, events.x, events.y, keep)
            return
        _narrow(self._last, self._rate, self._weights, self._support, events.ticks, events.x, events.y, keep)


@step
def _weight(weight, age):  # type: ignore[no-untyped-def]
    return weight[np.uint64(min(age, _AGES - 1))]


@step
def _unit(ticks, rate):  # type: ignore[no-untyped-def]
    # (ticks * rate) >> 24 in two parts, as the product may have 86 bits.
    whole, rest = ticks >> CLOCK_FRAC, ticks & ((1 << CLOCK_FRAC) - 1)
    return whole * rate + ((rest * rate) >> CLOCK_FRAC)


@njit(cache=True, nogil=True)
def _narrow(last, rate, weight, support, ticks, x, y, keep):  # type: ignore[no-untyped-def]
    one, two = np.uint64(1), np.uint64(2)
    height, width = last.shape[0] - 2, last.shape[1] - 2
    for i in range(len(keep)):
        if not keep[i]:
            continue
        keep[i] = False
        if x[i] < width and y[i] < height:
            unit = _unit(ticks[i], rate)
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


@njit(cache=True, nogil=True)
def _narrow_cells(last, place, bits, width, height, rate, weight, support, ticks, x, y, keep):  # type: ignore[no-untyped-def]
    coarse = 2 * bits  # log2 of the units of 1/32 half-life in one of a stamp
    for n in range(len(keep)):
        if not keep[n]:
            continue
        keep[n] = False
        if x[n] < width and y[n] < height:
            row, column, here = cell_of(np.int64(x[n]), np.int64(y[n]), bits)
            unit = _unit(ticks[n], rate) >> coarse
            total = 0
            for i in range(row - 1, row + 2):
                for j in range(column - 1, column + 2):
                    if i != row or j != column or place[i, j] != here:
                        total += _weight(weight, min(unit - last[i, j], _AGES) << coarse)
            keep[n] = total >= support
            last[row, column], place[row, column] = unit, here
