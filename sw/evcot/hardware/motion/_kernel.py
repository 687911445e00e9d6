# SPDX-License-Identifier: Apache-2.0
"""The extended contract's loop over events and motion steps."""

from __future__ import annotations

from numba import njit

from ..._numba_private import step
from ...tracks.log import DROPPED
from ._gaps import count_in_bins
from ._lives import LOST, MOVED, appears, correct, name, record, seed
from ._meetings import absorbed, hide_sides, join
from ._owner import find
from ._sides import measure
from ._state import (
    CANDIDATE,
    CORRECTIONS,
    COUNT,
    DEADLINE,
    FREE,
    GAP_CORRECTIONS,
    HI_X,
    HI_Y,
    IN_FORCE,
    IN_FORCE_AFTER,
    LEFT,
    LO_X,
    LO_Y,
    MOVES_FROM,
    N_EV,
    NEVER,
    NEXT_STEP,
    NEXT_WIN_LO_X,
    NEXT_WIN_LO_Y,
    NOW,
    REL_MASK,
    REPORT_STEPS,
    REPORTED,
    RETURN_TICKS,
    SEEDING,
    SEQ,
    STATE,
    STEP_LOG2,
    SUPPORT,
    SUPPORT_MAX,
    VISIBLE,
    WAITS,
    WIN_LO_X,
    WIN_LO_Y,
    Table,
)
from ._velocity import advance
from ._windows import await_return, bounded, set_window, take_window

__all__ = ["RECORDS_PER_SLOT", "feed", "initialise", "restart", "restep"]

RECORDS_PER_SLOT = 3  # at most, of a motion step, or of an event


@njit(cache=True, nogil=True)
def initialise(s: Table, r: Table, glob: Table) -> None:
    """Reset: every slot is free."""
    glob[:] = 0
    glob[NEXT_STEP] = 1 << r[STEP_LOG2]
    glob[IN_FORCE] = NEVER
    glob[SEEDING] = -1
    for i in range(s.shape[1]):
        s[STATE, i] = FREE
        s[DEADLINE, i] = NEVER


@step
def _put_in_force(s: Table, glob: Table, upto: int) -> None:
    """Put windows and candidates in force that wait for an event up to this one, and see which is next."""
    glob[IN_FORCE] = NEVER
    for i in range(s.shape[1]):
        if s[WAITS, i]:
            if s[WAITS, i] <= upto:
                take_window(s, i)
                s[COUNT, i] = 0
                s[WAITS, i] = 0
                if glob[SEEDING] == i:
                    glob[SEEDING] = -1
            else:
                glob[IN_FORCE] = min(glob[IN_FORCE], s[WAITS, i])


@step
def _wait(s: Table, glob: Table, i: int) -> None:
    """What was computed of slot i, with this event, is in force so many events later."""
    s[WAITS, i] = glob[SEQ] + IN_FORCE_AFTER
    glob[IN_FORCE] = min(glob[IN_FORCE], s[WAITS, i])


@njit(cache=True, nogil=True)
def restep(r: Table, glob: Table) -> None:
    """The registers have changed: the next step is at the next multiple of its length."""
    glob[NEXT_STEP] = ((glob[NOW] >> r[STEP_LOG2]) + 1) << r[STEP_LOG2]


@njit(cache=True, nogil=True)
def restart(s: Table, glob: Table, i: int, out: Table) -> int:
    """End slot i's life at once; returns the number of records, one if it was visible."""
    n = 0
    _put_in_force(s, glob, NEVER)
    if s[STATE, i] == VISIBLE:
        n = record(s, i, LOST, glob[SEQ], glob[NOW], 0, out, n)
    s[STATE, i] = FREE
    s[DEADLINE, i] = NEVER
    return n


@step
def _step_slot(s: Table, r: Table, lim: Table, glob: Table, i: int, now: int, out: Table, n: int) -> int:
    """The motion step of one slot that is not free."""
    if now >= s[DEADLINE, i]:
        if s[STATE, i] == VISIBLE:
            n = record(s, i, LOST, glob[SEQ], now, 0, out, n)
            if r[RETURN_TICKS]:
                s[STATE, i] = LEFT
                await_return(s, r, i)
                s[DEADLINE, i] = now + r[RETURN_TICKS]
                return n
        s[STATE, i] = FREE
        s[DEADLINE, i] = NEVER
        return n
    if s[STATE, i] == LEFT:
        return n
    if s[STATE, i] == VISIBLE or s[CORRECTIONS, i] >= MOVES_FROM:
        advance(s, r, lim, i, now)
    bounded(s, r, LO_X, HI_X, i)
    bounded(s, r, LO_Y, HI_Y, i)
    set_window(s, r, i)
    n = join(s, r, lim, glob, i, now, out, n)
    if s[STATE, i] == CANDIDATE and not absorbed(s, r, lim, i) and appears(s, r, i, now):
        return record(s, i, name(s, lim, glob, i), glob[SEQ], now, 0, out, n)
    if s[STATE, i] == VISIBLE:
        hide_sides(s, i)
        if now - s[REPORTED, i] >= r[REPORT_STEPS] << r[STEP_LOG2]:
            n = record(s, i, MOVED, glob[SEQ], now, 0, out, n)
    return n


@step
def _step(s: Table, r: Table, lim: Table, glob: Table, out: Table, n: int) -> int:
    """One motion step of all slots, in order."""
    now = glob[NEXT_STEP]
    if glob[IN_FORCE] != NEVER:
        _put_in_force(s, glob, NEVER)
    glob[NEXT_STEP] += 1 << r[STEP_LOG2]
    for i in range(s.shape[1]):
        if s[STATE, i] != FREE:
            n = _step_slot(s, r, lim, glob, i, now, out, n)
    return n


@step
def _lives(s: Table) -> bool:
    """Whether any slot has a candidate, or a track, lost ones that may return among them."""
    for i in range(s.shape[1]):  # noqa: SIM110 (any() would allocate)
        if s[STATE, i] != FREE:
            return True
    return False


@step
def _take(s: Table, r: Table, lim: Table, i: int, x: int, y: int, shared: bool) -> bool:
    """What an event does to its owner; true when the window of N_ev events is complete."""
    s[SUPPORT, i] = min(s[SUPPORT, i] + 1, lim[SUPPORT_MAX])
    if shared or s[WAITS, i]:
        return False
    if r[GAP_CORRECTIONS]:
        count_in_bins(s, i, x, y)
    measure(s, r, i, x, y)
    s[COUNT, i] += 1
    return bool(s[COUNT, i] >= s[N_EV, i])


@njit(cache=True, nogil=True)
def feed(
    s: Table, r: Table, lim: Table, glob: Table, modes: Table,
    ticks: Table, xs: Table, ys: Table, keep: Table, begin: int, owner: Table, rel_x: Table, rel_y: Table, out: Table,
) -> tuple[int, int]:  # fmt: skip
    """Process events from `begin` on until all are done or `out` could overflow; returns (events done, records written).

    Events whose entry in `keep` is false only advance time and the event count; an empty `keep` keeps all.
    """
    n = 0
    room = RECORDS_PER_SLOT * s.shape[1]
    all_kept = len(keep) == 0
    for e in range(begin, len(ticks)):
        x = int(xs[e])
        y = int(ys[e])
        now = ticks[e]
        while glob[NEXT_STEP] <= now:
            if not _lives(s):  # steps in which nothing happens, however many
                glob[NEXT_STEP] += (((now - glob[NEXT_STEP]) >> r[STEP_LOG2]) + 1) << r[STEP_LOG2]
                break
            if n + room > len(out):
                return e, n
            n = _step(s, r, lim, glob, out, n)
        if n + room > len(out):
            return e, n
        glob[NOW] = now
        rel_x[e] = 0
        rel_y[e] = 0
        if not (all_kept or keep[e]):
            owner[e] = DROPPED
        else:
            if glob[SEQ] >= glob[IN_FORCE]:
                _put_in_force(s, glob, glob[SEQ])
            i, shared, seeds = find(s, modes, x, y)
            if seeds and glob[SEEDING] >= 0:
                i, seeds = -1, False
            owner[e] = i
            if seeds:
                seed(s, r, i, x, y, now)
                glob[SEEDING] = i
                _wait(s, glob, i)
                rel_x[e] = (x - s[NEXT_WIN_LO_X, i]) & lim[REL_MASK]
                rel_y[e] = (y - s[NEXT_WIN_LO_Y, i]) & lim[REL_MASK]
            elif i >= 0:
                rel_x[e] = (x - s[WIN_LO_X, i]) & lim[REL_MASK]
                rel_y[e] = (y - s[WIN_LO_Y, i]) & lim[REL_MASK]
                if _take(s, r, lim, i, x, y, shared):
                    correct(s, r, i, now)
                    _wait(s, glob, i)
                    if s[STATE, i] == VISIBLE:
                        n = record(s, i, MOVED, glob[SEQ], now, 0, out, n)
        glob[SEQ] += 1
    return len(ticks), n
