# SPDX-License-Identifier: Apache-2.0
"""Slots that meet: which sides they hide from each other, and which of them are one object and merge."""

from __future__ import annotations

from ..._numba_private import step
from ._lives import MERGED, MOVED, end, record
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
    LOOKED,
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
from ._velocity import settle_pace
from ._windows import gap, in_window, set_window, windows_touch

__all__ = ["absorbed", "hide_sides", "join"]


@step
def hide_sides(s: Table, i: int) -> None:
    """Which sides of slot i lie in another visible slot's window, so that its own events do not show where they are."""
    hidden = 0
    meets = 0
    for j in range(s.shape[0]):
        if j == i or s[j, STATE] != VISIBLE or not windows_touch(s, i, j):
            continue
        meets = 1
        if s[j, WIN_LO_Y] <= s[i, BOX_HI_Y] and s[i, BOX_LO_Y] <= s[j, WIN_HI_Y]:
            if s[j, WIN_LO_X] <= s[i, BOX_LO_X] and s[i, BOX_LO_X] <= s[j, WIN_HI_X]:
                hidden |= AT_LO_X
            if s[j, WIN_LO_X] <= s[i, BOX_HI_X] and s[i, BOX_HI_X] <= s[j, WIN_HI_X]:
                hidden |= AT_HI_X
        if s[j, WIN_LO_X] <= s[i, BOX_HI_X] and s[i, BOX_LO_X] <= s[j, WIN_HI_X]:
            if s[j, WIN_LO_Y] <= s[i, BOX_LO_Y] and s[i, BOX_LO_Y] <= s[j, WIN_HI_Y]:
                hidden |= AT_LO_Y
            if s[j, WIN_LO_Y] <= s[i, BOX_HI_Y] and s[i, BOX_HI_Y] <= s[j, WIN_HI_Y]:
                hidden |= AT_HI_Y
    s[i, HIDDEN] = hidden
    s[i, MEETS] = meets


@step
def _together(s: Table, r: Table, i: int, j: int) -> bool:
    """Whether two slots move alike."""
    fastest = max(abs(s[i, V_X]), abs(s[i, V_Y]), abs(s[j, V_X]), abs(s[j, V_Y]))
    apart = max(abs(s[i, V_X] - s[j, V_X]), abs(s[i, V_Y] - s[j, V_Y]))
    return bool(apart <= (fastest >> r[JOIN_SPEED]) + (ONE >> 6))


@step
def _one_object(s: Table, r: Table, i: int, j: int) -> bool:
    """Whether two boxes can be parts of one object: they overlap by half on an axis, and are near on the other."""
    faster = i if s[i, SUPPORT] >= s[j, SUPPORT] else j
    gap_x = gap(s, BOX_LO_X, BOX_HI_X, i, j)
    gap_y = gap(s, BOX_LO_Y, BOX_HI_Y, i, j)
    width_i = s[i, BOX_HI_X] - s[i, BOX_LO_X]
    width_j = s[j, BOX_HI_X] - s[j, BOX_LO_X]
    height_i = s[i, BOX_HI_Y] - s[i, BOX_LO_Y]
    height_j = s[j, BOX_HI_Y] - s[j, BOX_LO_Y]
    abreast_x = gap_x <= -(min(width_i, width_j) >> 1)
    abreast_y = gap_y <= -(min(height_i, height_j) >> 1)
    near_x = r[JOIN_PX]
    near_y = r[JOIN_PX]
    if abs(s[faster, V_Y]) >= abs(s[faster, V_X]):
        near_y += max(width_i, width_j) >> r[JOIN_REACH]
    else:
        near_x += max(height_i, height_j) >> r[JOIN_REACH]
    return bool((abreast_x and gap_y <= near_y) or (abreast_y and gap_x <= near_x))


@step
def _unite(s: Table, r: Table, lim: Table, stays: int, goes: int) -> None:
    """The box of the one that stays covers both; it keeps its velocity."""
    s[stays, LO_X] = min(s[stays, LO_X], s[goes, LO_X])
    s[stays, HI_X] = max(s[stays, HI_X], s[goes, HI_X])
    s[stays, LO_Y] = min(s[stays, LO_Y], s[goes, LO_Y])
    s[stays, HI_Y] = max(s[stays, HI_Y], s[goes, HI_Y])
    for field in (OFF_LO_X, OFF_HI_X, OFF_LO_Y, OFF_HI_Y):
        s[stays, field] = 0
    s[stays, BEYOND] = AT_LO_X | AT_HI_X | AT_LO_Y | AT_HI_Y
    s[stays, SUPPORT] = min(s[stays, SUPPORT] + s[goes, SUPPORT], lim[SUPPORT_MAX])
    s[stays, DEADLINE] = max(s[stays, DEADLINE], s[goes, DEADLINE])
    s[stays, PARTNER] = -1
    s[stays, TOGETHER] = 0
    end(s, stays, goes)
    settle_pace(s, stays)
    s[stays, LOOKED] = -1  # what its bins hold is of its old box
    set_window(s, r, stays)


@step
def _stays(s: Table, r: Table, i: int, j: int) -> bool:
    """Whether of two slots i stays: a visible one does; else the older, or the one with more support; of equals i."""
    if s[i, STATE] != s[j, STATE]:
        return bool(s[i, STATE] == VISIBLE)
    if r[KEEP_OLDER]:
        return bool(s[j, SEEDED] >= s[i, SEEDED])
    return bool(s[j, SUPPORT] <= s[i, SUPPORT])


@step
def join(s: Table, r: Table, lim: Table, glob: Table, i: int, now: int, out: Table, n: int) -> int:
    """Merge slot i with its partner once they have been one object, moving together, for long enough; returns records.

    The partner is the lowest such slot. A step together counts one up, a step apart one down; another partner begins at 0.
    """
    partner = -1
    if s[i, CORRECTIONS] >= MOVES_FROM:
        for j in range(s.shape[0]):
            lives = s[j, STATE] == CANDIDATE or s[j, STATE] == VISIBLE
            settled = j != i and lives and s[j, CORRECTIONS] >= MOVES_FROM
            if settled and _together(s, r, i, j) and _one_object(s, r, i, j):
                partner = j
                break
    if partner < 0:
        s[i, TOGETHER] = max(s[i, TOGETHER] - 1, 0)
        return n
    if s[i, PARTNER] != partner:
        s[i, PARTNER] = partner
        s[i, TOGETHER] = 0
    s[i, TOGETHER] += 1
    lived = (now - max(s[i, SEEDED], s[partner, SEEDED])) >> r[STEP_LOG2] >> r[JOIN_LIFE]
    if s[i, TOGETHER] < min(max(r[JOIN_STEPS], lived), TOGETHER_MAX):
        return n
    if not _stays(s, r, i, partner):
        return n
    if s[partner, STATE] == VISIBLE:
        n = record(s, partner, MERGED, glob[SEQ], now, s[i, ID], out, n)
    _unite(s, r, lim, i, partner)
    if s[i, STATE] == VISIBLE:
        n = record(s, i, MOVED, glob[SEQ], now, 0, out, n)
    return n


@step
def absorbed(s: Table, r: Table, lim: Table, i: int) -> bool:
    """Whether candidate i ends as its middle is in a visible window, or waits for another with more support that it touches.

    A candidate with no more support is united with it; then it goes on.
    """
    x = (s[i, BOX_LO_X] + s[i, BOX_HI_X]) >> 1
    y = (s[i, BOX_LO_Y] + s[i, BOX_HI_Y]) >> 1
    for j in range(s.shape[0]):
        if j != i and s[j, STATE] == VISIBLE and in_window(s, j, x, y):
            s[i, STATE] = FREE
            s[i, DEADLINE] = NEVER
            return True
    for j in range(s.shape[0]):
        if j == i or s[j, STATE] != CANDIDATE:
            continue
        if gap(s, BOX_LO_X, BOX_HI_X, i, j) <= 0 and gap(s, BOX_LO_Y, BOX_HI_Y, i, j) <= 0:
            if s[i, SUPPORT] < s[j, SUPPORT]:
                return True
            _unite(s, r, lim, i, j)
    return False
