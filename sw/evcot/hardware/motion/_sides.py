# SPDX-License-Identifier: Apache-2.0
"""The sides of a box: running quantiles of a slot's events, each measured where no other object hides it."""

from __future__ import annotations

from ..._numba_private import step
from ._state import (
    AT_HI_X,
    AT_HI_Y,
    AT_LO_X,
    AT_LO_Y,
    BEYOND,
    BURST_LOG2,
    CANDIDATE,
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
    OFF_HI_X,
    OFF_HI_Y,
    OFF_LO_X,
    OFF_LO_Y,
    SIDE_SHARE,
    SIDE_SHRINK,
    SIDE_STEP,
    Table,
)
from .contract import SUB

__all__ = ["measure", "shrink"]


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
