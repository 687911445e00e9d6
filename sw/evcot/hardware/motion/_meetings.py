# SPDX-License-Identifier: Apache-2.0
"""Slots that meet: which sides they hide from each other, and which of them are one object and merge."""

from __future__ import annotations

from ..._numba_private import step
from ._gaps import clear_bins
from ._lives import MERGED, MOVED, record
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
    CANDIDATE,
    CORRECTIONS,
    DEADLINE,
    FREE,
    HI_X,
    HI_Y,
    HIDDEN,
    ID,
    JOIN_LIFE,
    JOIN_PX,
    JOIN_REACH,
    JOIN_SPEED,
    JOIN_STEPS,
    KEEP_OLDER,
    LO_X,
    LO_Y,
    MEETS,
    MOVES_FROM,
    NEVER,
    OFF_HI_X,
    OFF_HI_Y,
    OFF_LO_X,
    OFF_LO_Y,
    ONE,
    PARTNER,
    SEEDED,
    SEQ,
    STATE,
    STEP_LOG2,
    SUPPORT,
    SUPPORT_MAX,
    TOGETHER,
    TOGETHER_MAX,
    V_X,
    V_Y,
    VISIBLE,
    WIN_HI_X,
    WIN_HI_Y,
    WIN_LO_X,
    WIN_LO_Y,
    Table,
)
from ._windows import gap, in_window, set_window, windows_touch

__all__ = ["absorbed", "hide_sides", "join"]


@step
def hide_sides(s: Table, i: int) -> None:
    """Which sides of slot i lie in another visible slot's window, so that its own events do not show where they are."""
    hidden = 0
    meets = 0
    for j in range(s.shape[1]):
        if j == i or s[STATE, j] != VISIBLE or not windows_touch(s, i, j):
            continue
        meets = 1
        if s[WIN_LO_Y, j] <= s[BOX_HI_Y, i] and s[BOX_LO_Y, i] <= s[WIN_HI_Y, j]:
            if s[WIN_LO_X, j] <= s[BOX_LO_X, i] and s[BOX_LO_X, i] <= s[WIN_HI_X, j]:
                hidden |= AT_LO_X
            if s[WIN_LO_X, j] <= s[BOX_HI_X, i] and s[BOX_HI_X, i] <= s[WIN_HI_X, j]:
                hidden |= AT_HI_X
        if s[WIN_LO_X, j] <= s[BOX_HI_X, i] and s[BOX_LO_X, i] <= s[WIN_HI_X, j]:
            if s[WIN_LO_Y, j] <= s[BOX_LO_Y, i] and s[BOX_LO_Y, i] <= s[WIN_HI_Y, j]:
                hidden |= AT_LO_Y
            if s[WIN_LO_Y, j] <= s[BOX_HI_Y, i] and s[BOX_HI_Y, i] <= s[WIN_HI_Y, j]:
                hidden |= AT_HI_Y
    s[HIDDEN, i] = hidden
    s[MEETS, i] = meets


@step
def _together(s: Table, r: Table, i: int, j: int) -> bool:
    """Whether two slots move alike."""
    fastest = max(abs(s[V_X, i]), abs(s[V_Y, i]), abs(s[V_X, j]), abs(s[V_Y, j]))
    apart = max(abs(s[V_X, i] - s[V_X, j]), abs(s[V_Y, i] - s[V_Y, j]))
    return bool(apart <= (fastest >> r[JOIN_SPEED]) + (ONE >> 6))


@step
def _one_object(s: Table, r: Table, i: int, j: int) -> bool:
    """Whether two boxes can be parts of one object: they overlap by half on an axis, and are near on the other."""
    faster = i if s[SUPPORT, i] >= s[SUPPORT, j] else j
    gap_x = gap(s, BOX_LO_X, BOX_HI_X, i, j)
    gap_y = gap(s, BOX_LO_Y, BOX_HI_Y, i, j)
    width_i = s[BOX_HI_X, i] - s[BOX_LO_X, i]
    width_j = s[BOX_HI_X, j] - s[BOX_LO_X, j]
    height_i = s[BOX_HI_Y, i] - s[BOX_LO_Y, i]
    height_j = s[BOX_HI_Y, j] - s[BOX_LO_Y, j]
    abreast_x = gap_x <= -(min(width_i, width_j) >> 1)
    abreast_y = gap_y <= -(min(height_i, height_j) >> 1)
    near_x = r[JOIN_PX]
    near_y = r[JOIN_PX]
    if abs(s[V_Y, faster]) >= abs(s[V_X, faster]):
        near_y = max(width_i, width_j) >> r[JOIN_REACH]
    else:
        near_x = max(height_i, height_j) >> r[JOIN_REACH]
    return bool((abreast_x and gap_y <= near_y) or (abreast_y and gap_x <= near_x))


@step
def _unite(s: Table, r: Table, lim: Table, stays: int, goes: int) -> None:
    """The box of the one that stays covers both; it keeps its velocity."""
    s[LO_X, stays] = min(s[LO_X, stays], s[LO_X, goes])
    s[HI_X, stays] = max(s[HI_X, stays], s[HI_X, goes])
    s[LO_Y, stays] = min(s[LO_Y, stays], s[LO_Y, goes])
    s[HI_Y, stays] = max(s[HI_Y, stays], s[HI_Y, goes])
    for field in (OFF_LO_X, OFF_HI_X, OFF_LO_Y, OFF_HI_Y):
        s[field, stays] = 0
    s[BEYOND, stays] = AT_LO_X | AT_HI_X | AT_LO_Y | AT_HI_Y
    s[SUPPORT, stays] = min(s[SUPPORT, stays] + s[SUPPORT, goes], lim[SUPPORT_MAX])
    s[DEADLINE, stays] = max(s[DEADLINE, stays], s[DEADLINE, goes])
    s[PARTNER, stays] = -1
    s[TOGETHER, stays] = 0
    s[STATE, goes] = FREE
    s[DEADLINE, goes] = NEVER
    clear_bins(s, stays)
    set_window(s, r, stays)


@step
def _staying(s: Table, r: Table, i: int, j: int) -> int:
    """Of two slots the one that stays: a visible one; else the older, or the one with more support; else i."""
    if s[STATE, i] != s[STATE, j]:
        return i if s[STATE, i] == VISIBLE else j
    if r[KEEP_OLDER]:
        return j if s[SEEDED, j] < s[SEEDED, i] else i
    return j if s[SUPPORT, j] > s[SUPPORT, i] else i


@step
def join(s: Table, r: Table, lim: Table, glob: Table, i: int, now: int, out: Table, n: int) -> int:
    """Merge slot i with its partner once they have been one object, moving together, for long enough; returns records.

    The partner is the lowest such slot. A step together counts one up, a step apart one down; another partner begins at 0.
    """
    partner = -1
    if s[CORRECTIONS, i] >= MOVES_FROM:
        for j in range(s.shape[1]):
            lives = s[STATE, j] == CANDIDATE or s[STATE, j] == VISIBLE
            settled = j != i and lives and s[CORRECTIONS, j] >= MOVES_FROM
            if settled and _together(s, r, i, j) and _one_object(s, r, i, j):
                partner = j
                break
    if partner < 0:
        s[TOGETHER, i] = max(s[TOGETHER, i] - 1, 0)
        return n
    if s[PARTNER, i] != partner:
        s[PARTNER, i] = partner
        s[TOGETHER, i] = 0
    s[TOGETHER, i] += 1
    lived = (now - max(s[SEEDED, i], s[SEEDED, partner])) >> r[STEP_LOG2] >> r[JOIN_LIFE]
    if s[TOGETHER, i] < min(max(r[JOIN_STEPS], lived), TOGETHER_MAX):
        return n
    stays = _staying(s, r, i, partner)
    goes = partner if stays == i else i
    if s[STATE, goes] == VISIBLE:
        n = record(s, goes, MERGED, glob[SEQ], now, s[ID, stays], out, n)
    _unite(s, r, lim, stays, goes)
    if s[STATE, stays] == VISIBLE:
        n = record(s, stays, MOVED, glob[SEQ], now, 0, out, n)
    return n


@step
def absorbed(s: Table, r: Table, lim: Table, i: int) -> bool:
    """Whether candidate i ends: its middle is in a visible window, or its box touches another candidate's with more support.

    A candidate with no more support is united with it; then it goes on.
    """
    x = (s[BOX_LO_X, i] + s[BOX_HI_X, i]) >> 1
    y = (s[BOX_LO_Y, i] + s[BOX_HI_Y, i]) >> 1
    for j in range(s.shape[1]):
        if j != i and s[STATE, j] == VISIBLE and in_window(s, j, x, y):
            s[STATE, i] = FREE
            s[DEADLINE, i] = NEVER
            return True
    for j in range(s.shape[1]):
        if j == i or s[STATE, j] != CANDIDATE:
            continue
        if gap(s, BOX_LO_X, BOX_HI_X, i, j) <= 0 and gap(s, BOX_LO_Y, BOX_HI_Y, i, j) <= 0:
            if s[SUPPORT, i] < s[SUPPORT, j]:
                _unite(s, r, lim, j, i)
                return True
            _unite(s, r, lim, i, j)
    return False
