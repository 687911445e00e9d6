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
    CANDIDATE,
    HI_X,
    HI_Y,
    HIDDEN,
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
    STATE,
    Table,
)
from .contract import SUB

__all__ = ["measure", "shrink"]


@step
def _axis(
    s: Table, i: int, lo: int, hi: int, off_lo: int, off_hi: int, at_lo: int, at_hi: int, place: int, out: int, back: int
) -> None:
    """Both sides of an axis: out by `out` for an event beyond, in by `back` for any other.

    A side that is hidden goes where the opposite one goes; if both are hidden neither is measured.
    """
    hide_lo = s[HIDDEN, i] & at_lo
    hide_hi = s[HIDDEN, i] & at_hi
    if hide_lo and hide_hi:
        return
    move_lo = back
    move_hi = -back
    if place < s[lo, i]:
        move_lo = -out
        s[BEYOND, i] |= at_lo
    if place > s[hi, i]:
        move_hi = out
        s[BEYOND, i] |= at_hi
    if hide_lo:
        move_lo = move_hi
    elif hide_hi:
        move_hi = move_lo
    s[lo, i] += move_lo
    s[hi, i] += move_hi
    s[off_lo, i] += move_lo
    s[off_hi, i] += move_hi


@step
def measure(s: Table, r: Table, i: int, x: int, y: int) -> None:
    """Move the sides of slot i by one event; those of a candidate move twice as fast."""
    back = r[SIDE_STEP] >> r[SIDE_SHARE]
    out = r[SIDE_STEP] - back
    if s[STATE, i] == CANDIDATE:
        out <<= 1
        back <<= 1
    _axis(s, i, LO_X, HI_X, OFF_LO_X, OFF_HI_X, AT_LO_X, AT_HI_X, x << SUB, out, back)
    _axis(s, i, LO_Y, HI_Y, OFF_LO_Y, OFF_HI_Y, AT_LO_Y, AT_HI_Y, y << SUB, out, back)


@step
def shrink(s: Table, r: Table, i: int) -> None:
    """At a correction: a side that no event was beyond moves inwards by a part of the box, unless the slot meets another."""
    if r[SIDE_SHRINK] and not s[MEETS, i]:
        width = max(s[HI_X, i] - s[LO_X, i], 0) >> r[SIDE_SHRINK]
        height = max(s[HI_Y, i] - s[LO_Y, i], 0) >> r[SIDE_SHRINK]
        marked = s[BEYOND, i]
        if not marked & AT_LO_X:
            s[LO_X, i] += width
            s[OFF_LO_X, i] += width
        if not marked & AT_HI_X:
            s[HI_X, i] -= width
            s[OFF_HI_X, i] -= width
        if not marked & AT_LO_Y:
            s[LO_Y, i] += height
            s[OFF_LO_Y, i] += height
        if not marked & AT_HI_Y:
            s[HI_Y, i] -= height
            s[OFF_HI_Y, i] -= height
    s[BEYOND, i] = 0
