# SPDX-License-Identifier: Apache-2.0
"""Which slots hold a pixel, by sets of slots for each column and each row: an event need not ask every slot. And its owner."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..._numba_private import step
from ...bits import lowest, without_lowest
from ..contract import Mode
from ._state import (
    CANDIDATE,
    EV_BOX_HI_X,
    EV_BOX_HI_Y,
    EV_BOX_LO_X,
    EV_BOX_LO_Y,
    EV_STATE,
    EV_WIN_HI_X,
    EV_WIN_HI_Y,
    EV_WIN_LO_X,
    EV_WIN_LO_Y,
    FREE,
    HELD_BOX_HI_X,
    HELD_BOX_HI_Y,
    HELD_BOX_LO_X,
    HELD_BOX_LO_Y,
    HELD_WIN_HI_X,
    HELD_WIN_HI_Y,
    HELD_WIN_LO_X,
    HELD_WIN_LO_Y,
    LEFT,
    VISIBLE,
    Table,
)

__all__ = ["BOX_X", "BOX_Y", "OF_STATE", "ROWS", "WIN_X", "WIN_Y", "alone", "clear", "extent", "find", "hold", "renew"]

# Rows of the table: the slots whose window, or whose box, covers each column or row; in the last one those in each state.
WIN_X, WIN_Y, BOX_X, BOX_Y, OF_STATE = range(5)
ROWS = 5

# A slot's bounds in each of the first four rows: those in effect, and those that the row has.
_BOUNDS = (
    (WIN_X, EV_WIN_LO_X, EV_WIN_HI_X, HELD_WIN_LO_X, HELD_WIN_HI_X),
    (WIN_Y, EV_WIN_LO_Y, EV_WIN_HI_Y, HELD_WIN_LO_Y, HELD_WIN_HI_Y),
    (BOX_X, EV_BOX_LO_X, EV_BOX_HI_X, HELD_BOX_LO_X, HELD_BOX_HI_X),
    (BOX_Y, EV_BOX_LO_Y, EV_BOX_HI_Y, HELD_BOX_LO_Y, HELD_BOX_HI_Y),
)

_SEEDED = int(Mode.SEEDED)
_NONE = np.uint64(0)


def extent(x_w: int, y_w: int) -> int:
    """The length of the table's rows for addresses of so many bits."""
    return max(1 << x_w, 1 << y_w, LEFT + 1)


@step
def alone(i: int) -> Any:
    """The set of slot i alone."""
    return np.uint64(1) << np.uint64(i)


@step
def _join(sets: Table, lowest: int, highest: int, slot: Any) -> None:
    """Put a slot into the sets from the lowest to the highest column or row."""
    for k in range(max(lowest, 0), min(highest + 1, len(sets))):
        sets[k] |= slot


@step
def _leave(sets: Table, lowest: int, highest: int, slot: Any) -> None:
    """Take it out of them."""
    for k in range(max(lowest, 0), min(highest + 1, len(sets))):
        sets[k] &= ~slot


@step
def _shift(sets: Table, low: int, high: int, next_low: int, next_high: int, slot: Any) -> None:
    """Take a slot from its columns or rows to the next ones, most of which are the same."""
    _leave(sets, low, min(high, next_low - 1), slot)
    _leave(sets, max(low, next_high + 1), high, slot)
    _join(sets, next_low, min(next_high, low - 1), slot)
    _join(sets, max(next_low, high + 1), next_high, slot)


@step
def clear(s: Table, places: Table) -> None:
    """No slot holds a pixel."""
    places[:] = _NONE
    for i in range(s.shape[0]):
        for _, _, _, held_lo, held_hi in _BOUNDS:
            s[i, held_lo] = 1
            s[i, held_hi] = 0


@step
def hold(s: Table, places: Table, i: int) -> None:
    """Slot i holds the pixels of its box and window, which may have changed; none if it has neither."""
    holds = s[i, EV_STATE] in (CANDIDATE, VISIBLE)
    for row, lo, hi, held_lo, held_hi in _BOUNDS:
        low = s[i, lo] if holds else 1
        high = s[i, hi] if holds else 0
        if low == s[i, held_lo] and high == s[i, held_hi]:
            continue
        _shift(places[row], s[i, held_lo], s[i, held_hi], low, high, alone(i))
        s[i, held_lo] = low
        s[i, held_hi] = high


@step
def renew(s: Table, places: Table, modes: Table, i: int) -> None:
    """Bring the table up to date for slot i. Of those that could begin a candidate, only slots that do so by their mode."""
    for state in range(LEFT + 1):
        places[OF_STATE, state] &= ~alone(i)
    if s[i, EV_STATE] in (CANDIDATE, VISIBLE) or modes[i] == _SEEDED:
        places[OF_STATE, s[i, EV_STATE]] |= alone(i)
    hold(s, places, i)


@step
def _first(slots: Any) -> Any:
    """The lowest slot of a set, as a signed number."""
    return np.int64(lowest(slots))


@step
def find(places: Table, x: int, y: int) -> tuple[int, bool, bool]:
    """The owner or -1; whether the event could be another visible slot's as well; whether it seeds a candidate there.

    The lowest visible slot whose box holds the event; else the lowest visible one by its window; else the lowest candidate by
    its window; else the lowest free slot; else the lowest whose track may return.
    """
    held = places[WIN_X, x] & places[WIN_Y, y]
    visible = held & places[OF_STATE, VISIBLE]
    if visible:
        by_box = visible & places[BOX_X, x] & places[BOX_Y, y]
        if by_box:
            visible = by_box
        return _first(visible), without_lowest(visible) != 0, False
    candidates = held & places[OF_STATE, CANDIDATE]
    if candidates:
        return _first(candidates), False, False
    free = places[OF_STATE, FREE]
    if not free:
        free = places[OF_STATE, LEFT]
    if not free:
        return -1, False, False
    return _first(free), False, True
