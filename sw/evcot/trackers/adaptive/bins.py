# SPDX-License-Identifier: Apache-2.0
"""The bins of a look: pixels counted in squares of pixels, by row, and the parts into which they fall.

A row of bins is a word of 64 bits with a bit for each bin that is not empty. So empty bins cost nothing, and what touches is
found by shifted words, many bins at a time.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import step
from ...bits import lowest, without_lowest
from .layout import BINS, World

__all__ = ["NO_BINS", "clear", "fill", "find_parts", "pixels_in", "smooth", "span"]

Table = NDArray[Any]

NO_BINS, _ONE = np.uint64(0), np.uint64(1)


@step
def clear(world: World) -> None:
    """Empty the bins."""
    for y in range(BINS):
        row = world.filled[y]
        while row != NO_BINS:
            world.bins[y, int(lowest(row))] = 0.0
            row = without_lowest(row)
        world.filled[y] = NO_BINS


@step
def fill(world: World, y: int, x: int) -> None:
    """Count a pixel in a bin."""
    world.bins[y, x] += 1.0
    world.filled[y] |= _ONE << np.uint64(x)


@step
def smooth(world: World, rows: int, columns: int) -> None:
    """Sums of 3 x 3 bins, around those that are not empty."""
    for y in range(rows):
        row = world.filled[y]
        while row != NO_BINS:
            x = int(lowest(row))
            row = without_lowest(row)
            total = 0.0
            for v in range(max(y - 1, 0), min(y + 2, rows)):
                for u in range(max(x - 1, 0), min(x + 2, columns)):
                    total += world.bins[v, u]
            world.around[y, x] = total


@step
def _spread(row: Any, link: int) -> Any:
    """The bins of a row, a bit each, and those up to `link` beside them."""
    wide = row
    for k in range(1, link + 1):
        wide |= (row << np.uint64(k)) | (row >> np.uint64(k))
    return wide


@step
def _grow(world: World, y: int, rows: int, link: int) -> tuple[int, int]:
    """Move what is connected to the first free bin of a row from the free bins to the part; returns the rows that it spans."""
    free, part, fresh = world.free, world.part, world.fresh
    part[:rows] = NO_BINS
    part[y] = fresh[y] = free[y] & (~free[y] + _ONE)
    free[y] ^= part[y]
    top, bottom, grows = y, y, True
    while grows:
        grows = False
        for at in range(top, bottom + 1):
            while fresh[at] != NO_BINS:
                wide = _spread(fresh[at], link)
                fresh[at] = NO_BINS
                for k in range(max(at - link, 0), min(at + link + 1, rows)):
                    found = wide & free[k]
                    if found != NO_BINS:
                        free[k] ^= found
                        part[k] |= found
                        fresh[k] |= found
                        top, bottom, grows = min(top, k), max(bottom, k), True
    return top, bottom


@step
def find_parts(world: World, level: float, rows: int, half: Table, reach: Table, bin_px: int, link: int) -> int:
    """The connected parts; see `World.parts`. Returns how many there are."""
    label, free, parts = world.label, world.free, world.parts
    for y in range(rows):
        free[y] = row = world.filled[y]
        world.taken[y] = NO_BINS
        while row != NO_BINS:
            x = int(lowest(row))
            row = without_lowest(row)
            if world.around[y, x] < level:
                free[y] ^= _ONE << np.uint64(x)
    n = 0
    for y in range(rows):
        while free[y] != NO_BINS:
            if n == len(parts):
                return n
            top, bottom = _grow(world, y, rows, link)
            left, right, mass, inside = BINS, 0, 0.0, 0.0
            for yy in range(top, bottom + 1):
                row = world.part[yy]
                world.taken[yy] |= row
                while row != NO_BINS:
                    xx = int(lowest(row))
                    row = without_lowest(row)
                    label[yy, xx] = n + 1
                    mass += world.bins[yy, xx]
                    if abs((xx + 0.5) * bin_px - reach[0]) <= half[0] and abs((yy + 0.5) * bin_px - reach[1]) <= half[1]:
                        inside += world.bins[yy, xx]
                    left, right = min(left, xx), max(right, xx)
            parts[n, 0, 0], parts[n, 0, 1] = left, right + 1
            parts[n, 1, 0], parts[n, 1, 1] = top, bottom + 1
            parts[n, 2, 0], parts[n, 2, 1] = mass, inside
            n += 1
    return n


@step
def span(low: float, high: float, centre: float, count: int, bin_px: int, reach: float) -> tuple[int, int]:
    """The first bin whose middle lies from `low` to `high`, and the first after these."""
    begin = 0
    while begin < count and centre + ((begin + 0.5) * bin_px - reach) < low:
        begin += 1
    end = begin
    while end < count and centre + ((end + 0.5) * bin_px - reach) <= high:
        end += 1
    return begin, end


@step
def pixels_in(world: World, y: int, begin: int, end: int) -> float:
    """The pixels in a row of bins from `begin` to `end`, exclusive."""
    total = 0.0
    row = world.filled[y] & ((_ONE << np.uint64(end)) - (_ONE << np.uint64(begin)))
    while row != NO_BINS:
        total += world.bins[y, int(lowest(row))]
        row = without_lowest(row)
    return total
