# SPDX-License-Identifier: Apache-2.0
"""A slot's life: seeded by an event, corrected every so many events, visible once it has moved, ended by silence."""

from __future__ import annotations

from ..._numba_private import step
from ...tracks.log import Kind
from ._gaps import clear_bins, look_for_gaps
from ._sides import shrink
from ._state import (
    BEYOND,
    BIRTH_PX,
    BIRTH_SUPPORT,
    BIRTH_TICKS,
    BIRTH_TRAVEL,
    BIRTHS,
    CANDIDATE,
    COAST_TICKS,
    CORRECTIONS,
    CORRECTIONS_MAX,
    COUNT,
    DEADLINE,
    DETECT_TICKS,
    FREE,
    FROM_X,
    FROM_Y,
    HI_X,
    HI_Y,
    HIDDEN,
    ID,
    ID_MASK,
    LAST,
    LEFT,
    LIFE_LOG2,
    LIFE_TICKS,
    LO_X,
    LO_Y,
    MEETS,
    MOVES_FROM,
    N_EV,
    NEV_HIGH,
    NEV_LOW,
    NEVER,
    OFF_HI_X,
    OFF_HI_Y,
    OFF_LO_X,
    OFF_LO_Y,
    ONE,
    PARTNER,
    REPORTED,
    RUN_X,
    RUN_Y,
    SEED_PX,
    SEEDED,
    STATE,
    SUPPORT,
    TOGETHER,
    USUAL,
    V_X,
    V_Y,
    VISIBLE,
    WIN_HI_X,
    WIN_LO_X,
    Table,
)
from ._velocity import correct_velocity
from ._windows import length, next_window, windows_touch
from .contract import SUB

__all__ = ["BORN", "LOST", "MERGED", "MOVED", "appears", "correct", "name", "record", "seed"]

BORN, MOVED, MERGED, LOST = int(Kind.BORN), int(Kind.MOVED), int(Kind.MERGED), int(Kind.LOST)


@step
def record(s: Table, i: int, kind: int, seq: int, time: int, other: int, out: Table, n: int) -> int:
    """Write a record of slot i; returns the new number of records."""
    row = out[n]
    row.seq = seq
    row.time = time
    row.track_id = s[ID, i]
    row.other_id = other
    row.cm_x = (s[LO_X, i] + s[HI_X, i]) >> 1
    row.cm_y = (s[LO_Y, i] + s[HI_Y, i]) >> 1
    row.width = max(s[HI_X, i] - s[LO_X, i], 0)
    row.height = max(s[HI_Y, i] - s[LO_Y, i], 0)
    row.v_x = s[V_X, i]
    row.v_y = s[V_Y, i]
    row.support = s[SUPPORT, i]
    row.n_ev = s[N_EV, i]
    row.slot = i
    row.kind = kind
    s[REPORTED, i] = time
    return n + 1


@step
def seed(s: Table, r: Table, i: int, x: int, y: int, now: int) -> None:
    """A candidate begins: a square around the event, at rest, which holds no event until it is in force."""
    half = r[SEED_PX] << SUB
    s[STATE, i] = CANDIDATE
    s[LO_X, i] = (x << SUB) - half
    s[HI_X, i] = (x << SUB) + half
    s[LO_Y, i] = (y << SUB) - half
    s[HI_Y, i] = (y << SUB) + half
    for field in (
        V_X,
        V_Y,
        OFF_LO_X,
        OFF_HI_X,
        OFF_LO_Y,
        OFF_HI_Y,
        BEYOND,
        HIDDEN,
        MEETS,
        COUNT,
        CORRECTIONS,
        TOGETHER,
        RUN_X,
        RUN_Y,
    ):
        s[field, i] = 0
    s[SUPPORT, i] = 1
    s[PARTNER, i] = -1
    s[N_EV, i] = r[NEV_LOW]
    s[LAST, i] = now
    s[SEEDED, i] = now
    s[USUAL, i] = r[DETECT_TICKS]
    s[DEADLINE, i] = now + r[DETECT_TICKS]
    clear_bins(s, i)
    next_window(s, r, i)
    s[WIN_LO_X, i] = 1
    s[WIN_HI_X, i] = 0


@step
def correct(s: Table, r: Table, i: int, now: int) -> None:
    """After a window of N_ev events: sides, velocity, lifetime, the next N_ev, and the next window."""
    shrink(s, r, i)
    look_for_gaps(s, r, i)
    correct_velocity(s, r, i, now)
    s[CORRECTIONS, i] = min(s[CORRECTIONS, i] + 1, CORRECTIONS_MAX)
    if s[CORRECTIONS, i] == MOVES_FROM:
        s[FROM_X, i] = s[LO_X, i] + s[HI_X, i]
        s[FROM_Y, i] = s[LO_Y, i] + s[HI_Y, i]
    outline = length(s, LO_X, HI_X, i) + length(s, LO_Y, HI_Y, i)
    s[N_EV, i] = min(max(outline, r[NEV_LOW]), r[NEV_HIGH])
    s[DEADLINE, i] = now + min(max(s[USUAL, i] << r[LIFE_LOG2], r[LIFE_TICKS]), r[COAST_TICKS])
    next_window(s, r, i)


@step
def appears(s: Table, r: Table, i: int, now: int) -> bool:
    """Whether candidate i becomes visible: by support, size, time and the way that it has gone."""
    width = s[HI_X, i] - s[LO_X, i]
    height = s[HI_Y, i] - s[LO_Y, i]
    way_x = abs(s[LO_X, i] + s[HI_X, i] - s[FROM_X, i])
    way_y = abs(s[LO_Y, i] + s[HI_Y, i] - s[FROM_Y, i])
    return bool(
        s[CORRECTIONS, i] >= MOVES_FROM
        and s[SUPPORT, i] >= r[BIRTH_SUPPORT]
        and min(width, height) >= r[BIRTH_PX] << SUB
        and now - s[SEEDED, i] >= r[BIRTH_TICKS]
        and max(way_x, way_y) >= ((width + height) >> (r[BIRTH_TRAVEL] + 1)) + 2 * ONE
    )


@step
def name(s: Table, lim: Table, glob: Table, i: int) -> int:
    """Slot i becomes visible: as the track that was lost where its window is, or as a new one; returns the record's kind."""
    s[STATE, i] = VISIBLE
    for j in range(s.shape[1]):
        if s[STATE, j] == LEFT and windows_touch(s, i, j):
            s[ID, i] = s[ID, j]
            s[STATE, j] = FREE
            s[DEADLINE, j] = NEVER
            return MOVED
    s[ID, i] = glob[BIRTHS] & lim[ID_MASK]
    glob[BIRTHS] += 1
    return BORN
