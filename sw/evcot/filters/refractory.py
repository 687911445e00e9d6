# SPDX-License-Identifier: Apache-2.0
"""Refractory filter: drops the events of a pixel for some time after one that passed."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..ticks import TickedEvents
from .base import NEVER, EventFilter, per_pixel
from .cells import CellMemory, cell_of
from .contract import FilterShape
from .registers import FilterRegisters

__all__ = ["RefractoryFilter"]


class RefractoryFilter(EventFilter):
    """An event passes if no event of its pixel has passed in the last `refractory_ticks` ticks. About 6 ns per event.

    With cells it passes unless the last event that passed in its cell was on its pixel, and less than `refractory_ticks` ago,
    both in units of 2^stamp_shift ticks.
    """

    def __init__(self, registers: FilterRegisters, shape: FilterShape) -> None:
        self._ticks = registers.refractory_ticks
        self._cells: CellMemory | None = None
        if shape.cell_px:
            self._cells = CellMemory(shape)
            self._shift = registers.stamp_shift
            self._units = min(registers.refractory_ticks >> registers.stamp_shift, shape.units_max)
            self._size = shape.width, shape.height
        else:
            self._stayed = per_pixel(shape, NEVER)

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        if self._cells is not None:
            cells = self._cells
            memory = cells.last, cells.place, cells.bits
            _narrow_cells(*memory, *self._size, self._shift, self._units, events.ticks, events.x, events.y, keep)
            return
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


@njit(cache=True, nogil=True)
def _narrow_cells(last, place, bits, width, height, shift, silence, ticks, x, y, keep):  # type: ignore[no-untyped-def]
    for i in range(len(keep)):
        if not keep[i]:
            continue
        keep[i] = False
        if x[i] < width and y[i] < height:
            row, column, here = cell_of(np.int64(x[i]), np.int64(y[i]), bits)
            unit = ticks[i] >> shift
            if place[row, column] != here or unit - last[row, column] >= silence:
                keep[i] = True
                last[row, column], place[row, column] = unit, here
