# SPDX-License-Identifier: Apache-2.0
"""Find the cluster that takes an event: candidates from a grid of cells, then the paper's rule or that with all options."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..._numba_private import njit, step
from ...bits import lowest, without_lowest
from .state import CELLS, State, Table, choice

__all__ = [
    "NOBODY",
    "cell_of",
    "events_within",
    "find_by_options",
    "find_nearest",
    "register",
    "registered_for",
    "set_room",
    "take_seat",
    "unregister",
]


# Spatial lookup of candidate clusters: a grid of 8x8-pixel cells, with the set of clusters that may reach each cell.
#
# A cluster is registered in every cell that its window, widened by a slack, touches; as long as it moves no farther than the
# slack, a cell's set includes every cluster whose window holds an event in the cell, and an event is compared with only these.
# Surrounds have separate sets, used only for events in no window. The cells wrap around after 512 pixels in x and y, so that
# the sensor size need not be known: pixels that far apart share a set, which only costs more comparisons.
#
# Sets are bit masks of 64-bit words: a cluster's bit is its seat. Seats are assigned in the order of seeding, so that iterating
# over a set visits older clusters first.

_SHIFT = 3  # a cell is 8 pixels wide
_WORD = 64
_LONG = 1 << 40  # events


@njit(cache=True, nogil=True, inline="always")
def cell_of(x: Any, y: Any) -> Any:
    """The cell of a pixel, uint64."""
    last = np.uint64(CELLS - 1)
    shift = np.uint64(_SHIFT)
    return ((np.uint64(y) >> shift) & last) * np.uint64(CELLS) + ((np.uint64(x) >> shift) & last)


@njit(cache=True, nogil=True, inline="always")
def _slack_px(reach_px: float) -> float:
    """Slack of the registration: a compromise between few registrations and few unnecessary cells."""
    return max(2.0, 0.25 * reach_px)


@step
def _flip(cells: Table, seat: int, cluster: Any, times: float) -> None:
    """Toggle a cluster's bit in the sets of all cells that its window, scaled by `times`, may touch: adds it to these sets, or
    removes it."""
    sets = cells[seat // _WORD]
    bit = np.uint64(1) << np.uint64(seat % _WORD)
    reach_x, reach_y = times * cluster.cells_reach_x, times * cluster.cells_reach_y
    left: Any = np.int64(np.floor(cluster.cells_x - reach_x)) >> _SHIFT
    top: Any = np.int64(np.floor(cluster.cells_y - reach_y)) >> _SHIFT
    columns: Any = min((np.int64(np.floor(cluster.cells_x + reach_x)) >> _SHIFT) + 1 - left, CELLS)
    rows: Any = min((np.int64(np.floor(cluster.cells_y + reach_y)) >> _SHIFT) + 1 - top, CELLS)
    left &= CELLS - 1
    beyond: Any = max(0, left + columns - CELLS)
    for row in range(top, top + rows):
        first = (row & (CELLS - 1)) * CELLS
        for cell in range(first + left, first + left + columns - beyond):
            sets[cell] ^= bit
        for cell in range(first, first + beyond):
            sets[cell] ^= bit


@step
def _flip_all(state: State, seat: int) -> None:
    cluster = state.clusters[seat]
    _flip(state.cells, seat, cluster, 1.0)
    if len(state.around) > 0:
        _flip(state.around, seat, cluster, state.rules[0].surround)


@step
def unregister(state: State, seat: int) -> None:
    """Remove a cluster from all sets."""
    _flip_all(state, seat)


@step
def take_seat(state: State) -> Any:
    """A seat for a new cluster, after all others; if none is left, the seats are compacted first."""
    cur = state.cursor[0]
    if cur.seated == len(state.clusters):
        state.cells[:] = 0
        state.around[:] = 0
        for seat in range(cur.live):
            state.clusters[seat] = state.clusters[state.live[seat]]
            state.live[seat] = seat
            _flip_all(state, seat)
        cur.seated = cur.live
    cur.seated += 1
    return cur.seated - 1


@step
def register(state: State, seat: int) -> None:
    """Add a cluster to the sets of the cells around it."""
    cluster = state.clusters[seat]
    slack = _slack_px(max(cluster.half_width, cluster.half_height))
    cluster.cells_x = cluster.x
    cluster.cells_y = cluster.y
    cluster.cells_reach_x = cluster.half_width + slack
    cluster.cells_reach_y = cluster.half_height + slack
    cluster.room = slack
    _flip_all(state, seat)


@njit(cache=True, nogil=True, inline="always")
def events_within(rules: Any, cluster: Any) -> Any:
    """Number of events a cluster can take before it could leave its registered cells; 0: it must be re-registered now.

    An event moves the paper's cluster by at most the mixing factor times the window's reach; with options, `room` is checked
    at each event.
    """
    step_px = 0.0 if rules.full > 0 else rules.alpha * rules.radius_px
    left_px = cluster.room - max(abs(cluster.x - cluster.cells_x), abs(cluster.y - cluster.cells_y))
    if left_px <= step_px:
        return 0
    return _LONG if rules.full > 0 else max(1, np.int64(left_px / step_px))


@njit(cache=True, nogil=True, inline="always")
def set_room(cluster: Any) -> None:
    """Update the remaining slack after a change of the window's size."""
    cluster.room = min(cluster.cells_reach_x - cluster.half_width, cluster.cells_reach_y - cluster.half_height)


@step
def registered_for(state: State, seat: int) -> Any:
    """Re-register a cluster if necessary; returns the number of events until the next check."""
    rules = state.rules[0]
    cluster = state.clusters[seat]
    again = events_within(rules, cluster)
    if again == 0 or cluster.room > 3.0 * _slack_px(max(cluster.half_width, cluster.half_height)):
        unregister(state, seat)
        register(state, seat)
        again = max(1, events_within(rules, cluster))
    return again


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
