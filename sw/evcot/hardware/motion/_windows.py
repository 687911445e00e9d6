# SPDX-License-Identifier: Apache-2.0
"""From a slot's sides to the pixels of its box and of its window, and the relative position of two slots' boxes."""

from __future__ import annotations

from ..._numba_private import njit, step
from ._state import (
    BOX_HI_X,
    BOX_HI_Y,
    BOX_LO_X,
    BOX_LO_Y,
    CANDIDATE,
    CORRECTIONS,
    ELONGATION,
    HI_X,
    HI_Y,
    LO_X,
    LO_Y,
    MOVES_FROM,
    ONE,
    RING_ACROSS,
    RING_ALONG,
    RING_ANY,
    RING_MAX,
    RING_PX,
    SIDE_MAX,
    STATE,
    V_X,
    V_Y,
    WIN_HI_X,
    WIN_HI_Y,
    WIN_LO_X,
    WIN_LO_Y,
    Table,
)
from .contract import SUB

__all__ = [
    "await_return",
    "bounded",
    "gap",
    "in_window",
    "length",
    "set_window",
    "windows_touch",
]


@step
def length(s: Table, lo: int, hi: int, i: int) -> int:
    """A side of the box in whole pixels, at least 0."""
    return int(max(s[i, hi] - s[i, lo], 0) >> SUB)


@step
def _box(s: Table, lo: int, hi: int, box_lo: int, box_hi: int, i: int) -> None:
    """The pixels of both sides, to nearest; sides that have passed each other give their middle pixel."""
    low = (s[i, lo] + (ONE >> 1)) >> SUB
    high = (s[i, hi] + (ONE >> 1)) >> SUB
    if high < low:
        low = (low + high) >> 1
        high = low
    s[i, box_lo] = low
    s[i, box_hi] = high


@step
def _reach(r: Table, across: int, along: int) -> int:
    """How far a window reaches beyond its box along the motion: by the width, as long as the box is not much longer."""
    if along < r[ELONGATION] * across:
        return int((across >> r[RING_ALONG]) + r[RING_PX])
    return int((along >> r[RING_ACROSS]) + r[RING_PX])


@step
def await_return(s: Table, r: Table, i: int) -> None:
    """The window in which what slot i has lost may return: as far from its box as a window may be."""
    set_window(s, r, i)
    _surround(s, i, r[RING_MAX], r[RING_MAX])


@step
def set_window(s: Table, r: Table, i: int) -> None:
    """Box and window of slot i from its sides and its velocity."""
    width = length(s, LO_X, HI_X, i)
    height = length(s, LO_Y, HI_Y, i)
    speed_x = abs(s[i, V_X])
    speed_y = abs(s[i, V_Y])
    known = s[i, STATE] != CANDIDATE or s[i, CORRECTIONS] >= MOVES_FROM
    if known and speed_y >= 2 * speed_x:
        ring_x = (width >> r[RING_ACROSS]) + r[RING_PX]
        ring_y = _reach(r, width, height)
    elif known and speed_x >= 2 * speed_y:
        ring_x = _reach(r, height, width)
        ring_y = (height >> r[RING_ACROSS]) + r[RING_PX]
    else:
        ring_x = (width >> r[RING_ANY]) + r[RING_PX]
        ring_y = (height >> r[RING_ANY]) + r[RING_PX]
    _box(s, LO_X, HI_X, BOX_LO_X, BOX_HI_X, i)
    _box(s, LO_Y, HI_Y, BOX_LO_Y, BOX_HI_Y, i)
    _surround(s, i, min(ring_x, r[RING_MAX]), min(ring_y, r[RING_MAX]))


@step
def _surround(s: Table, i: int, ring_x: int, ring_y: int) -> None:
    """Slot i's window, by the distances from its box."""
    s[i, WIN_LO_X] = s[i, BOX_LO_X] - ring_x
    s[i, WIN_HI_X] = s[i, BOX_HI_X] + ring_x
    s[i, WIN_LO_Y] = s[i, BOX_LO_Y] - ring_y
    s[i, WIN_HI_Y] = s[i, BOX_HI_Y] + ring_y


@step
def bounded(s: Table, r: Table, lo: int, hi: int, i: int) -> None:
    """Limit a side's length to `side_max`, about its middle."""
    most = r[SIDE_MAX] << SUB
    if s[i, hi] - s[i, lo] > most:
        middle = (s[i, hi] + s[i, lo]) >> 1
        s[i, lo] = middle - (most >> 1)
        s[i, hi] = middle + (most >> 1)


@njit(cache=True, nogil=True, inline="always")
def in_window(s: Table, i: int, x: int, y: int) -> bool:
    """Whether a pixel lies in slot i's window."""
    return bool(s[i, WIN_LO_X] <= x and x <= s[i, WIN_HI_X] and s[i, WIN_LO_Y] <= y and y <= s[i, WIN_HI_Y])


@step
def gap(s: Table, lo: int, hi: int, i: int, j: int) -> int:
    """Pixels from one interval to the other; negative: how far they overlap."""
    return int(max(s[i, lo], s[j, lo]) - min(s[i, hi], s[j, hi]))


@step
def windows_touch(s: Table, i: int, j: int) -> bool:
    """Whether two windows share a pixel."""
    return gap(s, WIN_LO_X, WIN_HI_X, i, j) <= 0 and gap(s, WIN_LO_Y, WIN_HI_Y, i, j) <= 0
