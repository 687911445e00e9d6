# SPDX-License-Identifier: Apache-2.0
"""Find the cluster that takes an event: by the paper's rule, and with all options."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from ...bits import lowest, without_lowest
from .lookup import cell_of
from .state import Table, choice

__all__ = ["NOBODY", "find_by_options", "find_nearest"]

NOBODY = 1 << 32
_FIRST = choice("assign", "first")


@njit(cache=True, nogil=True, inline="always")
def find_nearest(clusters: Table, cells: Table, ex: Any, ey: Any, x: float, y: float) -> Any:
    """The seat of the cluster with the nearest centre by Chebyshev distance, and that distance; infinite if none is near.

    A window of radius R holds exactly the points at most R away. Of two equally near, the older takes the event. The first one
    is taken without a comparison: usually there is only one, and no distance delays the loop.
    """
    cell = cell_of(ex, ey)
    nearest = np.uint64(0)
    nearest_px = np.inf
    near = cells[0, cell]
    if near != np.uint64(0):
        nearest = lowest(near)
        nearest_px = max(abs(x - clusters[nearest].x), abs(y - clusters[nearest].y))
        near = without_lowest(near)
    for word in range(len(cells)):
        if word > 0:
            near = cells[word, cell]
        while near != np.uint64(0):
            seat = lowest(near) + np.uint64(64 * word)
            near = without_lowest(near)
            distance_px = max(abs(x - clusters[seat].x), abs(y - clusters[seat].y))
            if distance_px < nearest_px:
                nearest_px = distance_px
                nearest = seat
    return nearest, nearest_px


@njit(cache=True, nogil=True, inline="always")
def find_by_options(options: Any, clusters: Table, cells: Table, times: float, cell: Any, x: float, y: float) -> Any:
    """The seat of the cluster whose scaled window holds the event: the nearest or first such cluster, or `NOBODY`.

    Also returns the event's distances u, v from the centre along x and y.
    """
    holder = np.uint64(NOBODY)
    held = 0.0, 0.0
    least_px = np.inf
    word = 0
    near = cells[0, cell]
    while True:
        while near != np.uint64(0):
            seat = lowest(near) + np.uint64(64 * word)
            near = without_lowest(near)
            cluster = clusters[seat]
            u = abs(x - cluster.x)
            v = abs(y - cluster.y)
            if max(u - times * cluster.half_width, v - times * cluster.half_height) <= 0.0:
                if options.assign == _FIRST:
                    return seat, (u, v)
                distance_px = max(u, v)
                if distance_px < least_px:
                    least_px = distance_px
                    holder = seat
                    held = u, v
        word += 1
        if word == len(cells):
            return holder, held
        near = cells[word, cell]
