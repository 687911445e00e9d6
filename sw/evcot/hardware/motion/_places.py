# SPDX-License-Identifier: Apache-2.0
"""Which slots hold a pixel: sets of slots for each column and each row, so that an event need not ask every slot."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..._numba_private import step
from ..contract import Mode
from ._state import (
    BOX_HI_X,
    BOX_HI_Y,
    BOX_LO_X,
    BOX_LO_Y,
    CANDIDATE,
    LEFT,
    NEXT_BOX_HI_X,
    NEXT_BOX_HI_Y,
    NEXT_BOX_LO_X,
    NEXT_BOX_LO_Y,
    NEXT_WIN_HI_X,
    NEXT_WIN_HI_Y,
    NEXT_WIN_LO_X,
    NEXT_WIN_LO_Y,
    STATE,
    VISIBLE,
    WIN_HI_X,
    WIN_HI_Y,
    WIN_LO_X,
    WIN_LO_Y,
    Table,
)

__all__ = ["BOX_X", "BOX_Y", "OF_STATE", "ROWS", "WIN_X", "WIN_Y", "alone", "enter", "extent", "move", "renew"]

# Rows of the table: the slots whose window, or whose box, covers each column or row; in the last one those in each state.
WIN_X, WIN_Y, BOX_X, BOX_Y, OF_STATE = range(5)
ROWS = 5

# A slot's bounds in each of the first four rows: those in force, and the next ones.
_BOUNDS = (
    (WIN_X, WIN_LO_X, WIN_HI_X, NEXT_WIN_LO_X, NEXT_WIN_HI_X),
    (WIN_Y, WIN_LO_Y, WIN_HI_Y, NEXT_WIN_LO_Y, NEXT_WIN_HI_Y),
    (BOX_X, BOX_LO_X, BOX_HI_X, NEXT_BOX_LO_X, NEXT_BOX_HI_X),
    (BOX_Y, BOX_LO_Y, BOX_HI_Y, NEXT_BOX_LO_Y, NEXT_BOX_HI_Y),
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
def enter(s: Table, places: Table, i: int) -> None:
    """Slot i, which held no pixel, holds those of its box and window from now on."""
    for row, lo, hi, _, _ in _BOUNDS:
        _join(places[row], s[i, lo], s[i, hi], alone(i))


@step
def move(s: Table, places: Table, i: int) -> None:
    """Slot i holds the pixels of its next box and window instead of those of the present ones; before these change."""
    for row, lo, hi, next_lo, next_hi in _BOUNDS:
        _shift(places[row], s[i, lo], s[i, hi], s[i, next_lo], s[i, next_hi], alone(i))


@step
def renew(s: Table, places: Table, modes: Table) -> None:
    """Fill in the table anew. Of those that could begin a candidate, only slots that do so by their mode."""
    places[:] = _NONE
    for i in range(s.shape[0]):
        holds = s[i, STATE] in (CANDIDATE, VISIBLE)
        if holds or modes[i] == _SEEDED:
            places[OF_STATE, s[i, STATE]] |= alone(i)
        if holds:
            enter(s, places, i)
