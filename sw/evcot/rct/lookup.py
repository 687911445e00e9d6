# SPDX-License-Identifier: Apache-2.0
"""Which clusters an event can belong to: the plane in cells of 8x8 pixels, and per cell the set of clusters that may reach it.

A cluster is registered in every cell that its window touches, the window being widened by a slack; as long as it has moved
no farther than that, the sets hold every window that holds an event, and an event is compared with the few clusters of its
cell. The cells wrap around after 512 pixels either way, so that no sensor size need be known: pixels so far apart share their
sets, which only means more comparisons. Sets are bits, 64 to a word.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numba.cpython.unsafe.numbers import trailing_zeros

from .state import CELLS, Rules, Table

__all__ = ["cell_of", "checked_after", "lowest", "register", "slack_px", "unregister", "without_lowest"]

_SHIFT = 3  # a cell is 8 pixels wide
_WORD = 64


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
def slack_px(reach_px: float) -> float:
    """How much wider than its window a cluster is registered: rarely moved, and in few cells in vain."""
    return max(2.0, 0.4 * reach_px)


@njit(cache=True, nogil=True)
def _set(cells: Table, slot: int, x: float, y: float, reach_px: float, there: bool) -> None:
    word = slot // _WORD
    bit = np.uint64(1) << np.uint64(slot % _WORD)
    reach = reach_px + slack_px(reach_px)
    left = np.int64(np.floor(x - reach)) >> _SHIFT
    top = np.int64(np.floor(y - reach)) >> _SHIFT
    right = min(np.int64(np.floor(x + reach)) >> _SHIFT, left + CELLS - 1)
    bottom = min(np.int64(np.floor(y + reach)) >> _SHIFT, top + CELLS - 1)
    for row in range(top, bottom + 1):
        first = (row & (CELLS - 1)) * CELLS
        for column in range(left, right + 1):
            cell = first + (column & (CELLS - 1))
            if there:
                cells[cell, word] |= bit
            else:
                cells[cell, word] &= ~bit


@njit(cache=True, nogil=True)
def unregister(rules: Rules, cells: Table, clusters: Table, slot: int) -> None:
    """Take a cluster out of all sets."""
    cluster = clusters[slot]
    _set(cells, slot, cluster.cells_x, cluster.cells_y, rules.radius_px, False)


@njit(cache=True, nogil=True)
def register(rules: Rules, cells: Table, clusters: Table, slot: int) -> None:
    """Put a cluster into the sets of the cells around it."""
    cluster = clusters[slot]
    cluster.cells_x = cluster.x
    cluster.cells_y = cluster.y
    _set(cells, slot, cluster.x, cluster.y, rules.radius_px, True)


@njit(cache=True, nogil=True)
def checked_after(rules: Rules, cells: Table, clusters: Table, slot: int) -> Any:
    """Register a cluster anew if its next event could take it out of its slack; returns after how many events to ask again.

    An event moves it by at most the mixing factor's share of the window's reach.
    """
    cluster = clusters[slot]
    slack = slack_px(rules.radius_px)
    step = rules.alpha * rules.radius_px
    moved = max(abs(cluster.x - cluster.cells_x), abs(cluster.y - cluster.cells_y))
    if moved + step >= slack:
        unregister(rules, cells, clusters, slot)
        register(rules, cells, clusters, slot)
        moved = 0.0
    return max(1, np.int64((slack - moved) / step))
