# SPDX-License-Identifier: Apache-2.0
"""Which cluster takes an event: by the paper's rule, and with all options."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from .lookup import cell_of, lowest, without_lowest
from .state import Table, choice

__all__ = ["NOBODY", "find_by_options", "find_nearest"]

NOBODY = 1 << 32
_FIRST = choice("assign", "first")
_CHEBYSHEV, _MANHATTAN = choice("distance", "chebyshev"), choice("distance", "manhattan")
_SEPARATE = choice("polarity", "separate")


@njit(cache=True, nogil=True, inline="always")
def find_nearest(clusters: Table, cells: Table, ex: Any, ey: Any, x: float, y: float) -> Any:
    """The slot whose centre is nearest by Chebyshev's distance, and that distance, infinite where no window is near.

    A window of radius R holds exactly the points at most R away. Of two equally near, the older takes the event.
    """
    cell = cell_of(ex, ey)
    nearest = np.uint64(0)
    nearest_px = np.inf
    words = len(cells)
    for word in range(words):
        near = cells[word, cell]
        while near != np.uint64(0):
            slot = lowest(near) + np.uint64(64 * word)
            near = without_lowest(near)
            distance_px = max(abs(x - clusters[slot].x), abs(y - clusters[slot].y))
            if distance_px < nearest_px or (distance_px == nearest_px and clusters[slot].order < clusters[nearest].order):
                nearest_px = distance_px
                nearest = slot
    return nearest, nearest_px


@njit(cache=True, nogil=True, inline="always")
def _remoteness(rules: Any, cluster: Any, dx: float, dy: float) -> Any:
    """What the cluster that takes the event has least of."""
    if rules.assign == _FIRST:
        return float(cluster.order)
    if rules.distance == _CHEBYSHEV:
        return max(abs(dx), abs(dy))
    if rules.distance == _MANHATTAN:
        return abs(dx) + abs(dy)
    return dx * dx + dy * dy


@njit(cache=True, nogil=True, inline="always")
def find_by_options(rules: Any, clusters: Table, cells: Table, times: float, ex: Any, ey: Any, p: Any) -> Any:
    """The slot whose window, so many times as large, holds the event: the nearest or first of such, or `NOBODY`."""
    x, y = float(ex), float(ey)
    polarity = np.int64(p) if rules.polarity == _SEPARATE else 0
    cell = cell_of(ex, ey)
    holder = np.uint64(NOBODY)
    least = np.inf
    for word in range(len(cells)):
        near = cells[word, cell]
        while near != np.uint64(0):
            slot = lowest(near) + np.uint64(64 * word)
            near = without_lowest(near)
            cluster = clusters[slot]
            if cluster.polarity != polarity:
                continue
            dx = x - cluster.x
            dy = y - cluster.y
            u = abs(cluster.cos * dx + cluster.sin * dy)
            v = abs(cluster.cos * dy - cluster.sin * dx)
            if u <= times * cluster.half_width and v <= times * cluster.half_height:
                remoteness = _remoteness(rules, cluster, dx, dy)
                if remoteness < least or (remoteness == least and cluster.order < clusters[holder].order):
                    least = remoteness
                    holder = slot
    return holder
