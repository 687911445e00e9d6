# SPDX-License-Identifier: Apache-2.0
"""A slot's life: seeded by an event, corrected every so many events, visible once it has moved, ended by silence."""

from __future__ import annotations

from ..._numba_private import step
from ...tracks.log import Kind
from ._gaps import clear_bins, look_for_gaps
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
    DEADLINE,
    DETECT_TICKS,
    ENDS_WITH,
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
    STATED_X,
    STATED_Y,
    SUPPORT,
    TOGETHER,
    USUAL,
    V_X,
    V_Y,
    VISIBLE,
    Table,
)
from ._velocity import begin_pace, correct_velocity
from ._windows import length, set_window, shrink, windows_touch
from .contract import SUB

__all__ = ["BORN", "LOST", "MERGED", "MOVED", "appears", "correct", "end", "name", "record", "seed"]

BORN, MOVED, MERGED, LOST = int(Kind.BORN), int(Kind.MOVED), int(Kind.MERGED), int(Kind.LOST)


@step
def record(s: Table, i: int, kind: int, seq: int, time: int, other: int, out: Table, n: int) -> int:
    """Write a record of slot i; returns the new number of records."""
    row = out[n]
    row.seq = seq
    row.time = time
    row.track_id = s[i, ID]
    row.other_id = other
    row.cm_x = (s[i, LO_X] + s[i, HI_X]) >> 1
    row.cm_y = (s[i, LO_Y] + s[i, HI_Y]) >> 1
    row.width = max(s[i, HI_X] - s[i, LO_X], 0)
    row.height = max(s[i, HI_Y] - s[i, LO_Y], 0)
    row.v_x = s[i, STATED_X] >> 1
    row.v_y = s[i, STATED_Y] >> 1
    row.support = s[i, SUPPORT]
    row.n_ev = s[i, N_EV]
    row.slot = i
    row.kind = kind
    s[i, REPORTED] = time
    return n + 1


@step
def seed(s: Table, r: Table, i: int, x: int, y: int, now: int, counted: int) -> None:
    """A candidate begins: a square around the event, at rest, which holds no event until it is in effect."""
    half = r[SEED_PX] << SUB
    s[i, STATE] = CANDIDATE
    s[i, LO_X] = (x << SUB) - half
    s[i, HI_X] = (x << SUB) + half
    s[i, LO_Y] = (y << SUB) - half
    s[i, HI_Y] = (y << SUB) + half
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
        CORRECTIONS,
        TOGETHER,
        RUN_X,
        RUN_Y,
    ):
        s[i, field] = 0
    s[i, SUPPORT] = 1
    s[i, PARTNER] = -1
    s[i, N_EV] = r[NEV_LOW]
    s[i, LAST] = now
    s[i, SEEDED] = now
    s[i, USUAL] = r[DETECT_TICKS]
    s[i, DEADLINE] = counted + r[DETECT_TICKS]
    clear_bins(s, i)
    set_window(s, r, i)


@step
def correct(s: Table, r: Table, i: int, now: int, counted: int, in_burst: bool) -> None:
    """After a window of N_ev events: sides, velocity, lifetime, the next N_ev, and the next window."""
    shrink(s, r, i)
    look_for_gaps(s, r, i)
    correct_velocity(s, r, i, now, in_burst)
    s[i, CORRECTIONS] = min(s[i, CORRECTIONS] + 1, CORRECTIONS_MAX)
    if s[i, CORRECTIONS] == MOVES_FROM:
        s[i, FROM_X] = s[i, LO_X] + s[i, HI_X]
        s[i, FROM_Y] = s[i, LO_Y] + s[i, HI_Y]
        begin_pace(s, i)
    outline = length(s, LO_X, HI_X, i) + length(s, LO_Y, HI_Y, i)
    s[i, N_EV] = min(max(outline, r[NEV_LOW]), r[NEV_HIGH])
    s[i, DEADLINE] = counted + min(max(s[i, USUAL] << r[LIFE_LOG2], r[LIFE_TICKS]), r[COAST_TICKS])
    set_window(s, r, i)


@step
def appears(s: Table, r: Table, i: int, now: int) -> bool:
    """Whether candidate i becomes visible: by support, size, time and the way that it has gone."""
    width = s[i, HI_X] - s[i, LO_X]
    height = s[i, HI_Y] - s[i, LO_Y]
    way_x = abs(s[i, LO_X] + s[i, HI_X] - s[i, FROM_X])
    way_y = abs(s[i, LO_Y] + s[i, HI_Y] - s[i, FROM_Y])
    return bool(
        s[i, CORRECTIONS] >= MOVES_FROM
        and s[i, SUPPORT] >= r[BIRTH_SUPPORT]
        and min(width, height) >= r[BIRTH_PX] << SUB
        and now - s[i, SEEDED] >= r[BIRTH_TICKS]
        and max(way_x, way_y) >= ((width + height) >> (r[BIRTH_TRAVEL] + 1)) + 2 * ONE
    )


@step
def end(s: Table, i: int, j: int) -> None:
    """The step of slot i ends slot j, in effect as slot i takes effect."""
    s[j, STATE] = FREE
    s[j, DEADLINE] = NEVER
    s[j, ENDS_WITH] = i + 1


@step
def name(s: Table, lim: Table, glob: Table, i: int) -> int:
    """Slot i becomes visible: as the track that was lost where its window is, or as a new one; returns the record's kind."""
    s[i, STATE] = VISIBLE
    for j in range(s.shape[0]):
        if s[j, STATE] == LEFT and windows_touch(s, i, j):
            s[i, ID] = s[j, ID]
            end(s, i, j)
            return MOVED
    s[i, ID] = glob[BIRTHS] & lim[ID_MASK]
    glob[BIRTHS] += 1
    return BORN
