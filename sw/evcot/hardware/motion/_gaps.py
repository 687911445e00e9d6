# SPDX-License-Identifier: Apache-2.0
"""Two objects in one box: a gap across the motion, found in a histogram of the events' places along each axis."""

from __future__ import annotations

from ..._numba_private import step
from ._state import (
    BIN_LOG2_X,
    BIN_LOG2_Y,
    BINS,
    BINS_LOG2,
    BINS_X,
    BINS_Y,
    CORRECTIONS,
    ELONGATION,
    EV_LO_X,
    EV_LO_Y,
    GAP_CORRECTIONS,
    GAP_PX,
    GAP_SHARE,
    HI_X,
    HI_Y,
    LO_X,
    LO_Y,
    LOOKED,
    LOOKS_FROM,
    ONE,
    V_X,
    V_Y,
    Table,
)
from ._velocity import bit_length
from ._windows import length
from .contract import SUB

__all__ = ["clear_bins", "count_in_bins", "look_for_gaps"]


@step
def clear_bins(s: Table, i: int) -> None:
    """Begin new histograms: bins of 2^n pixels from the box's low side, half of them or more for the whole side."""
    for b in range(2 * BINS):
        s[i, BINS_X + b] = 0
    s[i, LOOKED] = 0
    s[i, BIN_LOG2_X] = max(0, bit_length(length(s, LO_X, HI_X, i)) - BINS_LOG2)
    s[i, BIN_LOG2_Y] = max(0, bit_length(length(s, LO_Y, HI_Y, i)) - BINS_LOG2)


@step
def count_in_bins(s: Table, i: int, x: int, y: int) -> None:
    """Count an event in both histograms, in the box's own frame."""
    bin_x = (x - ((s[i, EV_LO_X] + (ONE >> 1)) >> SUB)) >> s[i, BIN_LOG2_X]
    bin_y = (y - ((s[i, EV_LO_Y] + (ONE >> 1)) >> SUB)) >> s[i, BIN_LOG2_Y]
    if 0 <= bin_x < BINS:
        s[i, BINS_X + bin_x] += 1
    if 0 <= bin_y < BINS:
        s[i, BINS_Y + bin_y] += 1


@step
def _cut(s: Table, r: Table, i: int, lo: int, hi: int, bins: int, bin_log2: int, narrowest: int) -> None:
    """If the histogram has a gap of so many pixels, leave the box with the part that has more events."""
    total = 0
    for b in range(BINS):
        total += s[i, bins + b]
    least = max(1, total >> r[GAP_SHARE])
    first = -1
    widest = 0
    end = 0  # of the widest gap, the first of equals
    run = 0
    for b in range(BINS):
        if s[i, bins + b] > least:
            if first < 0:
                first = b
            elif run > widest:
                widest = run
                end = b
            run = 0
        else:
            run += 1
    if widest == 0 or widest << bin_log2 < narrowest:
        return
    begin = end - widest
    below = 0
    above = 0
    for b in range(BINS):
        if b < begin:
            below += s[i, bins + b]
        elif b >= end:
            above += s[i, bins + b]
    if below >= above:
        s[i, hi] = s[i, lo] + (begin << bin_log2 << SUB)
    else:
        s[i, lo] = s[i, lo] + (end << bin_log2 << SUB)
        s[i, hi] = max(s[i, hi], s[i, lo])


@step
def look_for_gaps(s: Table, r: Table, i: int) -> None:
    """At a correction: after every `gap_corrections`, cut the box at a gap.

    Across the motion any gap counts: a moving object's front reaches from side to side. Along it objects are hollow; there a
    gap counts in a long box, if it is half as long as the box is wide.
    """
    if r[GAP_CORRECTIONS] == 0:
        return
    if s[i, LOOKED] < 0:  # it has merged since the last correction
        clear_bins(s, i)
        return
    s[i, LOOKED] += 1
    if s[i, LOOKED] < r[GAP_CORRECTIONS]:
        return
    speed_x = abs(s[i, V_X])
    speed_y = abs(s[i, V_Y])
    if s[i, CORRECTIONS] >= LOOKS_FROM and speed_x + speed_y > 0:
        width = length(s, LO_X, HI_X, i)
        height = length(s, LO_Y, HI_Y, i)
        if 2 * speed_y >= speed_x:
            _cut(s, r, i, LO_X, HI_X, BINS_X, s[i, BIN_LOG2_X], r[GAP_PX])
        elif width >= r[ELONGATION] * height:
            _cut(s, r, i, LO_X, HI_X, BINS_X, s[i, BIN_LOG2_X], max(r[GAP_PX], height >> 1))
        if 2 * speed_x >= speed_y:
            _cut(s, r, i, LO_Y, HI_Y, BINS_Y, s[i, BIN_LOG2_Y], r[GAP_PX])
        elif height >= r[ELONGATION] * width:
            _cut(s, r, i, LO_Y, HI_Y, BINS_Y, s[i, BIN_LOG2_Y], max(r[GAP_PX], width >> 1))
    clear_bins(s, i)
