# SPDX-License-Identifier: Apache-2.0
"""Refractory and activity filter over one memory of cells: a time and a place for each square of pixels.

docs/filters.md, "One memory of cells", is the contract; `filter_cells.v` is the hardware.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit, step
from ..ticks import TickedEvents
from .activity import supporters
from .base import NEVER, EventFilter, per_pixel
from .contract import Filter, FilterShape
from .noise_level import ENDS, NUMBER, SUPPORT, NoiseLevel, end_window, note
from .registers import FilterRegisters

__all__ = ["CellMemory", "CellsFilter", "cell_of"]


class CellMemory:
    """For each cell of `cell_px` x `cell_px` pixels the time and the place of its last event, with a border of one cell.

    Attributes:
        bits: log2 of `cell_px`.
        last: (rows + 2, columns + 2) int64, in whatever unit the filter counts.
        place: (rows + 2, columns + 2) int64, y and x within the cell, side by side.
    """

    def __init__(self, shape: FilterShape) -> None:
        self.bits = shape.cell_px.bit_length() - 1
        columns, rows = (-(-pixels // shape.cell_px) for pixels in (shape.width, shape.height))
        cells = FilterShape(columns, rows)
        self.last: NDArray[np.int64] = per_pixel(cells, NEVER, border=1)
        self.place: NDArray[np.int64] = per_pixel(cells, 0, border=1)


class CellsFilter(EventFilter):
    """The filters refractory and activity, each if enabled. About 10 ns per event with cells of one pixel.

    Attributes:
        noise: what the support follows; None: `activity_support` holds.
        counts: (3,) int64, events that reached the filter, that refractory kept, and that activity kept.
    """

    def __init__(self, registers: FilterRegisters, shape: FilterShape) -> None:
        active = registers.enables(Filter.ACTIVITY)
        self.noise = NoiseLevel(registers, shape) if active and not registers.activity_support else None
        self.counts = np.zeros(3, np.int64)
        self._cells = CellMemory(shape)
        self._size = shape.width, shape.height
        silence = min(registers.refractory_ticks >> registers.stamp_shift, shape.units_max)
        window = min(registers.activity_ticks >> registers.stamp_shift, shape.units_max - 1)
        silence = silence if registers.enables(Filter.REFRACTORY) else 0
        self._rule = registers.stamp_shift, silence, window, registers.activity_support if active else 0
        self._level = self.noise or NoiseLevel(registers, shape)

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        cells, level = self._cells, self._level
        memory = cells.last, cells.place, cells.bits, *self._size
        noise = self.noise is not None, level.words, level.state, level.rule
        _narrow(*memory, *self._rule, *noise, events.ticks, events.x, events.y, keep, self.counts)


@step
def cell_of(x, y, bits):  # type: ignore[no-untyped-def]
    """Row and column in a memory with a border, and the place within the cell."""
    inner = (1 << bits) - 1
    return (y >> bits) + 1, (x >> bits) + 1, (y & inner) << bits | (x & inner)


@step
def _supporting_cells(last, place, row, column, here, oldest):  # type: ignore[no-untyped-def]
    """How many of the 9 cells around have a last event not before `oldest`; of the own cell, one on another pixel."""
    count = 0
    for i in range(row - 1, row + 2):
        for j in range(column - 1, column + 2):
            other = i != row or j != column or place[i, j] != here
            count += other and last[i, j] >= oldest
    return count


@njit(cache=True, nogil=True)
def _narrow(  # type: ignore[no-untyped-def]
    last, place, bits, width, height, shift, silence, window, support, follows, words, state, rule, ticks, xs, ys, keep, counts
):
    seen = rested = sent = 0
    x: Any
    y: Any
    one = np.uint64(1)
    across, down = np.uint64(width), np.uint64(height)
    ends, number = state[ENDS], state[NUMBER]
    if follows:
        support = state[SUPPORT]
    for i in range(len(keep)):
        if not keep[i]:
            continue
        seen += 1
        keep[i] = False
        x, y = np.uint64(xs[i]), np.uint64(ys[i])  # as indices that need no check for negative ones
        if x >= across or y >= down:
            continue
        tick = ticks[i]
        if follows:
            if tick >= ends:
                end_window(words, state, rule, tick)
                ends, number, support = state[ENDS], state[NUMBER], state[SUPPORT]
            note(words, state, number, x, y)
        unit = tick >> shift
        if bits:
            row, column, here = cell_of(np.int64(x), np.int64(y), bits)
            if place[row, column] == here and unit - last[row, column] < silence:
                continue
            keep[i] = _supporting_cells(last, place, row, column, here, unit - window) >= support
            last[row, column], place[row, column] = unit, here
        else:
            if unit - last[y + one, x + one] < silence:
                continue
            keep[i] = supporters(last, unit - window, unit, x, y) >= support
        rested += 1
        sent += keep[i]
    counts += np.array([seen, rested, sent])
