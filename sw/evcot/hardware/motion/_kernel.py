# SPDX-License-Identifier: Apache-2.0
"""The extended contract's loop over events and motion steps."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from ..._numba_private import step
from ._gaps import count_in_bins
from ._lives import LOST, MOVED, appears, correct, name, record, seed
from ._meetings import absorbed, hide_sides, join
from ._owner import find
from ._places import OF_STATE, alone, clear, hold, renew
from ._sides import measure
from ._state import (
    BOX_HI_X,
    BOX_HI_Y,
    BOX_LO_X,
    BOX_LO_Y,
    BUSY,
    CANDIDATE,
    CORRECTIONS,
    COUNT,
    DEADLINE,
    EMPTY,
    EMPTY_MAX,
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
    NEXT_SLOT,
    NEXT_STEP,
    NOW,
    PAUSED,
    PERIOD,
    REL_MASK,
    REPORT_STEPS,
    REPORTED,
    RETURN_TICKS,
    SEEDING,
    SEQ,
    SLOTS_LOG2,
    STATE,
    STEP_LOG2,
    SUPPORT,
    SUPPORT_MAX,
    VISIBLE,
    WAITS,
    Table,
)
from ._velocity import advance
from ._windows import await_return, bounded, set_window, take_window

__all__ = ["RECORDS_PER_STEP", "feed", "initialise", "restart", "restep"]

RECORDS_PER_STEP = 3  # at most
NOBODY = -1  # owns an event


@njit(cache=True, nogil=True)
def initialise(s: Table, r: Table, glob: Table, modes: Table, places: Table) -> None:
    """Reset: every slot is free."""
    glob[:] = 0
    restep(r, glob)
    glob[IN_FORCE] = NEVER
    glob[SEEDING] = -1
    for i in range(s.shape[0]):
        s[i, STATE] = FREE
        s[i, DEADLINE] = NEVER
    clear(s, places)
    renew(s, places, modes)


@step
def _put_in_force(s: Table, glob: Table, places: Table, upto: int) -> None:
    """Put windows and candidates in force that wait for an event up to this one, and see which is next."""
    glob[IN_FORCE] = NEVER
    for i in range(s.shape[0]):
        if s[i, WAITS]:
            if s[i, WAITS] <= upto:
                if glob[SEEDING] == i:
                    glob[SEEDING] = -1
                take_window(s, i)
                hold(s, places, i)
                s[i, COUNT] = 0
                s[i, WAITS] = 0
            else:
                glob[IN_FORCE] = min(glob[IN_FORCE], s[i, WAITS])


@step
def _wait(s: Table, glob: Table, i: int) -> None:
    """What was computed of slot i, with this event, is in force so many events later."""
    s[i, WAITS] = glob[SEQ] + IN_FORCE_AFTER
    glob[IN_FORCE] = min(glob[IN_FORCE], s[i, WAITS])


@njit(cache=True, nogil=True)
def restep(r: Table, glob: Table) -> None:
    """`step_log2` has changed: the next step is slot 0's, at the next multiple of a period."""
    glob[PERIOD] = ((glob[NOW] >> r[STEP_LOG2]) + 1) << r[STEP_LOG2]
    glob[NEXT_SLOT] = 0
    glob[NEXT_STEP] = glob[PERIOD]


@njit(cache=True, nogil=True)
def restart(s: Table, glob: Table, modes: Table, places: Table, i: int, out: Table) -> int:
    """End slot i's life at once; returns the number of records, one if it was visible."""
    n = 0
    _put_in_force(s, glob, places, NEVER)
    if s[i, STATE] == VISIBLE:
        n = record(s, i, LOST, glob[SEQ], glob[NOW], 0, out, n)
    s[i, STATE] = FREE
    s[i, DEADLINE] = NEVER
    renew(s, places, modes)
    return n


@step
def _step_slot(s: Table, r: Table, lim: Table, glob: Table, i: int, now: int, out: Table, n: int) -> int:
    """The motion step of one slot that is not free."""
    if now - glob[PAUSED] >= s[i, DEADLINE]:
        if s[i, STATE] == VISIBLE:
            n = record(s, i, LOST, glob[SEQ], now, 0, out, n)
            if r[RETURN_TICKS]:
                s[i, STATE] = LEFT
                await_return(s, r, i)
                s[i, DEADLINE] = now - glob[PAUSED] + r[RETURN_TICKS]
                return n
        s[i, STATE] = FREE
        s[i, DEADLINE] = NEVER
        return n
    if s[i, STATE] == LEFT:
        return n
    if s[i, STATE] == VISIBLE or s[i, CORRECTIONS] >= MOVES_FROM:
        advance(s, r, lim, i, now)
    bounded(s, r, LO_X, HI_X, i)
    bounded(s, r, LO_Y, HI_Y, i)
    set_window(s, r, i)
    n = join(s, r, lim, glob, i, now, out, n)
    if s[i, STATE] == CANDIDATE and not absorbed(s, r, lim, i) and appears(s, r, i, now):
        return record(s, i, name(s, lim, glob, i), glob[SEQ], now, 0, out, n)
    if s[i, STATE] == VISIBLE:
        hide_sides(s, i)
        if now - s[i, REPORTED] >= r[REPORT_STEPS] << r[STEP_LOG2]:
            n = record(s, i, MOVED, glob[SEQ], now, 0, out, n)
    return n


@step
def _pause(r: Table, glob: Table) -> None:
    """A period in which no kept event came does not count for deadlines, up to so many in a row."""
    if glob[BUSY]:
        glob[EMPTY] = 0
    elif glob[EMPTY] < EMPTY_MAX:
        glob[EMPTY] += 1
        glob[PAUSED] += 1 << r[STEP_LOG2]
    glob[BUSY] = 0


@step
def _go_on(r: Table, lim: Table, glob: Table, n_slots: int) -> None:
    """From one slot's step to the next one's, spread over the period."""
    glob[NEXT_SLOT] += 1
    if glob[NEXT_SLOT] == n_slots:
        glob[NEXT_SLOT] = 0
        glob[PERIOD] += 1 << r[STEP_LOG2]
    glob[NEXT_STEP] = glob[PERIOD] + ((glob[NEXT_SLOT] << r[STEP_LOG2]) >> lim[SLOTS_LOG2])


@step
def _step(s: Table, r: Table, lim: Table, glob: Table, places: Table, out: Table, n: int) -> int:
    """The next motion step of a slot."""
    now = glob[NEXT_STEP]
    i = glob[NEXT_SLOT]
    if glob[IN_FORCE] != NEVER:
        _put_in_force(s, glob, places, NEVER)
    if i == 0:
        _pause(r, glob)
    if s[i, STATE] != FREE:
        n = _step_slot(s, r, lim, glob, i, now, out, n)
    _go_on(r, lim, glob, s.shape[0])
    return n


@step
def _lives(s: Table) -> bool:
    """Whether any slot has a candidate, or a track, lost ones that may return among them."""
    for i in range(s.shape[0]):  # noqa: SIM110 (any() would allocate)
        if s[i, STATE] != FREE:
            return True
    return False


@step
def _take(s: Table, r: Table, lim: Table, i: int, x: int, y: int, shared: bool) -> bool:
    """What an event does to its owner; true when the window of N_ev events is complete."""
    s[i, SUPPORT] = min(s[i, SUPPORT] + 1, lim[SUPPORT_MAX])
    if shared or s[i, WAITS]:
        return False
    if r[GAP_CORRECTIONS]:
        count_in_bins(s, i, x, y)
    measure(s, r, i, x, y)
    s[i, COUNT] += 1
    return bool(s[i, COUNT] >= s[i, N_EV])


@step
def _steps(
    s: Table, r: Table, lim: Table, glob: Table, modes: Table, places: Table,
    ticks: Table, before: int, e: int, out: Table, n: int,
) -> int:  # fmt: skip
    """All motion steps up to event e of a run, or fewer if `out` could overflow; returns the new number of records.

    Each comes before the first event that is not earlier, whether that was kept or not. `before` is how many events there were
    before the run.
    """
    now = ticks[e]
    changed = False
    while glob[NEXT_STEP] <= now and n + RECORDS_PER_STEP <= len(out):
        i = glob[NEXT_SLOT]
        if i > 0 and s[i, STATE] == FREE and glob[IN_FORCE] == NEVER:
            _go_on(r, lim, glob, s.shape[0])
            continue
        if not _lives(s):  # steps in which nothing happens, however many
            glob[PERIOD] = (now >> r[STEP_LOG2]) << r[STEP_LOG2]
            glob[NEXT_SLOT] = 0
            while glob[NEXT_STEP] <= now:
                _go_on(r, lim, glob, s.shape[0])
            break
        done = glob[SEQ] - before
        glob[SEQ] += np.searchsorted(ticks[done:e], glob[NEXT_STEP])
        n = _step(s, r, lim, glob, places, out, n)
        changed = True
    if changed:
        renew(s, places, modes)
    return n


@step
def _seed(s: Table, r: Table, glob: Table, places: Table, i: int, x: int, y: int, now: int) -> None:
    """An event begins a candidate in slot i, which no other one does until this one is in force."""
    places[OF_STATE, s[i, STATE]] &= ~alone(i)
    places[OF_STATE, CANDIDATE] |= alone(i)
    seed(s, r, i, x, y, now, now - glob[PAUSED])
    glob[SEEDING] = i
    _wait(s, glob, i)


@step
def _correct(s: Table, r: Table, glob: Table, i: int, now: int, out: Table, n: int) -> int:
    """An event completes a window of slot i; returns the new number of records."""
    correct(s, r, i, now, now - glob[PAUSED])
    _wait(s, glob, i)
    return record(s, i, MOVED, glob[SEQ], now, 0, out, n) if s[i, STATE] == VISIBLE else n


@njit(cache=True, nogil=True)
def feed(
    s: Table, r: Table, lim: Table, glob: Table, modes: Table, places: Table,
    ticks: Table, xs: Table, ys: Table, kept: Table, done: int, owner: Table, rel_x: Table, rel_y: Table, out: Table,
) -> tuple[int, int]:  # fmt: skip
    """Process a run of events, of which `done` are done, to its end or until `out` could overflow.

    `kept` are the numbers of those events that no filter took out, in order; the others only advance time and the event count.
    `owner`, `rel_x` and `rel_y` are filled in for events that are kept; the last two hold zeros, which stay without an owner.

    Returns:
        Events done and records written.
    """
    n = 0
    before = glob[SEQ] - done
    for k in range(np.searchsorted(kept, done), len(kept) + 1):
        e = kept[k] if k < len(kept) else len(ticks) - 1  # in the end time has come to the last event, kept or not
        now = ticks[e]
        if glob[NEXT_STEP] <= now:
            n = _steps(s, r, lim, glob, modes, places, ticks, before, e, out, n)
            if glob[NEXT_STEP] <= now:
                return glob[SEQ] - before, n
        if k == len(kept):
            break
        glob[SEQ] = before + e
        if n == len(out):
            return e, n
        if glob[SEQ] >= glob[IN_FORCE]:
            _put_in_force(s, glob, places, glob[SEQ])
        glob[BUSY] = 1
        x: Any = np.int64(xs[e])  # signed: unsigned ones would be compared with sides as floats
        y: Any = np.int64(ys[e])
        i, shared, seeds = find(places, x, y)
        if i >= 0 and not seeds:
            owner[e] = i
            rel_x[e] = (2 * x - s[i, BOX_LO_X] - s[i, BOX_HI_X]) & lim[REL_MASK]
            rel_y[e] = (2 * y - s[i, BOX_LO_Y] - s[i, BOX_HI_Y]) & lim[REL_MASK]
            if _take(s, r, lim, i, x, y, shared):
                n = _correct(s, r, glob, i, now, out, n)
        elif i >= 0 and glob[SEEDING] < 0:
            _seed(s, r, glob, places, i, x, y, now)
            owner[e] = i  # it is the middle of the candidate's box
        else:
            owner[e] = NOBODY
        glob[SEQ] += 1
    glob[NOW] = ticks[-1]
    glob[SEQ] = before + len(ticks)
    return len(ticks), n
