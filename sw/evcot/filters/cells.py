# SPDX-License-Identifier: Apache-2.0
"""The memory of cells that the filters refractory, activity and decay can use: a few bits for each square of pixels.

docs/filters.md, "One memory of cells", is the contract; `cell_memory.v` is the hardware.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._numba_private import step
from .base import NEVER, per_pixel
from .contract import FilterShape

__all__ = ["CellMemory", "cell_of", "supporting_cells"]


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


@step
def cell_of(x, y, bits):  # type: ignore[no-untyped-def]
    """Row and column in a memory with a border, and the place within the cell."""
    inner = (1 << bits) - 1
    return (y >> bits) + 1, (x >> bits) + 1, (y & inner) << bits | (x & inner)


@step
def supporting_cells(last, place, row, column, here, oldest):  # type: ignore[no-untyped-def]
    """How many of the 9 cells around have a last event not before `oldest`; of the own cell, one on another pixel."""
    count = 0
    for i in range(row - 1, row + 2):
        for j in range(column - 1, column + 2):
            other = i != row or j != column or place[i, j] != here
            count += other and last[i, j] >= oldest
    return count
