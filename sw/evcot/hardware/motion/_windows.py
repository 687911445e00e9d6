# SPDX-License-Identifier: Apache-2.0
"""The sides of a box, and the pixels of a slot's box and of its window; the relative position of two slots' boxes.

The sides are running quantiles of a slot's events, each measured where no other object hides it.
"""

from __future__ import annotations

from ..._numba_private import njit, step
from ._state import (
    AT_HI_X,
    AT_HI_Y,
    AT_LO_X,
    AT_LO_Y,
    BEYOND,
    BOX_HI_X,
    BOX_HI_Y,
    BOX_LO_X,
    BOX_LO_Y,
    BURST_LOG2,
    CANDIDATE,
    CORRECTIONS,
    ELONGATION,
    EV_BEYOND,
    EV_HI_X,
    EV_HI_Y,
    EV_HIDDEN,
    EV_LO_X,
    EV_LO_Y,
    EV_STATE,
    HI_X,
    HI_Y,
    LO_X,
    LO_Y,
    MEETS,
    MOVES_FROM,
    OFF_HI_X,
    OFF_HI_Y,
    OFF_LO_X,
    OFF_LO_Y,
    ONE,
    RING_ACROSS,
    RING_ALONG,
    RING_ANY,
    RING_MAX,
    RING_PX,
    SIDE_MAX,
    SIDE_SHARE,
    SIDE_SHRINK,
    SIDE_STEP,
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

__all__ = ["await_return", "bounded", "gap", "in_window", "length", "measure", "set_window", "shrink", "windows_touch"]


@step
def _axis(s: Table, i: int, lo: int, hi: int, at_lo: int, at_hi: int, place: int, out: int, back: int) -> None:
    """Both sides of an axis: out by `out` for an event beyond, in by `back` for any other.

    A side that is hidden goes where the opposite one goes; if both are hidden neither is measured.
    """
    hide_lo = s[i, EV_HIDDEN] & at_lo
    hide_hi = s[i, EV_HIDDEN] & at_hi
    if hide_lo and hide_hi:
        return
    move_lo = back
    move_hi = -back
    if place < s[i, lo]:
        move_lo = -out
        s[i, EV_BEYOND] |= at_lo
    if place > s[i, hi]:
        move_hi = out
        s[i, EV_BEYOND] |= at_hi
    if hide_lo:
        move_lo = move_hi
    elif hide_hi:
        move_hi = move_lo
    s[i, lo] += move_lo
    s[i, hi] += move_hi


@step
def measure(s: Table, r: Table, i: int, x: int, y: int, in_burst: bool) -> None:
    """Move the sides of slot i by one event; those of a candidate move twice as fast, and outwards more within a burst."""
    back = r[SIDE_STEP] >> r[SIDE_SHARE]
    out = r[SIDE_STEP] - back
    if s[i, EV_STATE] == CANDIDATE:
        out <<= 1
        back <<= 1
    if in_burst:
        out <<= BURST_LOG2
    _axis(s, i, EV_LO_X, EV_HI_X, AT_LO_X, AT_HI_X, x << SUB, out, back)
    _axis(s, i, EV_LO_Y, EV_HI_Y, AT_LO_Y, AT_HI_Y, y << SUB, out, back)


@step
def shrink(s: Table, r: Table, i: int) -> None:
    """At a correction: a side that no event was beyond moves inwards by a part of the box, unless the slot meets another."""
    if r[SIDE_SHRINK] and not s[i, MEETS]:
        width = max(s[i, HI_X] - s[i, LO_X], 0) >> r[SIDE_SHRINK]
        height = max(s[i, HI_Y] - s[i, LO_Y], 0) >> r[SIDE_SHRINK]
        marked = s[i, BEYOND]
        if not marked & AT_LO_X:
            s[i, LO_X] += width
            s[i, OFF_LO_X] += width
        if not marked & AT_HI_X:
            s[i, HI_X] -= width
            s[i, OFF_HI_X] -= width
        if not marked & AT_LO_Y:
            s[i, LO_Y] += height
            s[i, OFF_LO_Y] += height
        if not marked & AT_HI_Y:
            s[i, HI_Y] -= height
            s[i, OFF_HI_Y] -= height
    s[i, BEYOND] = 0


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
