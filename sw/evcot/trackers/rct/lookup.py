# SPDX-License-Identifier: Apache-2.0
"""Which clusters an event can belong to: the plane in cells of 8x8 pixels, and per cell the set of clusters that may reach it.

A cluster is registered in every cell that its window touches, widened by a slack; as long as it has moved no farther than
that, the sets hold every window that holds an event, and an event is compared with the few clusters of its cell. Surrounds
have sets of their own, which only an event in no window asks for. The cells wrap around after 512 pixels either way, so that
no sensor size need be known: pixels so far apart share their sets, which only means more comparisons.

Sets are bits, 64 to a word: a cluster's bit is its seat. Seats are taken in the order of seeding, so that whoever looks at the
clusters of a cell sees the older ones first.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from ..._numba_private import step, trailing_zeros
from .state import CELLS, State, Table

__all__ = [
    "cell_of",
    "events_within",
    "lowest",
    "register",
    "registered_for",
    "set_room",
    "take_seat",
    "unregister",
    "without_lowest",
]

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
def lowest(word: Any) -> Any:
    """Number of the lowest bit that is set."""
    return np.uint64(trailing_zeros(word))  # type: ignore[call-arg]


@njit(cache=True, nogil=True, inline="always")
def without_lowest(word: Any) -> Any:
    """The word without that bit."""
    return word & (word - np.uint64(1))


@njit(cache=True, nogil=True, inline="always")
def _slack_px(reach_px: float) -> float:
    """How much wider than its window a cluster is registered: rarely moved, and in few cells in vain."""
    return max(2.0, 0.25 * reach_px)


@step
def _flip(cells: Table, seat: int, cluster: Any, times: float) -> None:
    """Put a cluster into the sets of the cells that its window, so many times as large, may touch, or take it out of them:
    the same bits change."""
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
    """Take a cluster out of all sets."""
    _flip_all(state, seat)


@step
def take_seat(state: State) -> Any:
    """A seat for a new cluster, behind all others; where none is left there, all move up."""
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
    """Put a cluster into the sets of the cells around it."""
    cluster = state.clusters[seat]
    slack = _slack_px(max(cluster.reach_x, cluster.reach_y))
    cluster.cells_x = cluster.x
    cluster.cells_y = cluster.y
    cluster.cells_reach_x = cluster.reach_x + slack
    cluster.cells_reach_y = cluster.reach_y + slack
    cluster.room = slack
    _flip_all(state, seat)


@njit(cache=True, nogil=True, inline="always")
def events_within(rules: Any, cluster: Any) -> Any:
    """How many events a cluster can take before it could leave the cells where it is registered; 0: it must move now.

    An event moves the paper's cluster by at most the mixing factor's share of the window's reach; with options, each event
    looks for itself whether there is `room` left.
    """
    step_px = 0.0 if rules.whole > 0 else rules.alpha * rules.radius_px
    left_px = cluster.room - max(abs(cluster.x - cluster.cells_x), abs(cluster.y - cluster.cells_y))
    if left_px <= step_px:
        return 0
    return _LONG if rules.whole > 0 else max(1, np.int64(left_px / step_px))


@njit(cache=True, nogil=True, inline="always")
def set_room(cluster: Any) -> None:
    """The window's size has changed, and with it the slack that is left."""
    cluster.room = min(cluster.cells_reach_x - cluster.reach_x, cluster.cells_reach_y - cluster.reach_y)


@step
def registered_for(state: State, seat: int) -> Any:
    """Register a cluster anew where it must be; returns after how many events to ask again."""
    rules = state.rules[0]
    cluster = state.clusters[seat]
    again = events_within(rules, cluster)
    if again == 0 or cluster.room > 3.0 * _slack_px(max(cluster.reach_x, cluster.reach_y)):
        unregister(state, seat)
        register(state, seat)
        again = max(1, events_within(rules, cluster))
    return again
