# SPDX-License-Identifier: Apache-2.0
"""The extended contract's loop over events and motion steps."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..._numba_private import njit, step
from ._gaps import count_in_bins
from ._lives import LOST, MOVED, appears, correct, name, record, seed
from ._meetings import absorbed, hide_sides, join
from ._places import OF_STATE, alone, clear, find, renew
from ._state import (
    BEYOND,
    BOX_LO_X,
    BURST_FROM,
    BUSY,
    CANDIDATE,
    COMPUTED,
    CORRECTIONS,
    CORRECTS,
    DEADLINE,
    DUE,
    DUE_TICK,
    EFFECT_EVENTS,
    EFFECT_TICKS,
    EMPTY,
    EMPTY_MAX,
    ENDS_WITH,
    EV_BEYOND,
    EV_BOX_HI_X,
    EV_BOX_HI_Y,
    EV_BOX_LO_X,
    EV_BOX_LO_Y,
    EV_COUNT,
    EV_LO_X,
    EV_OWNED,
    EV_STATE,
    FREE,
    GAP_CORRECTIONS,
    HI_X,
    HI_Y,
    IN_EFFECT,
    LEFT,
    LO_X,
    LO_Y,
    MOVES_FROM,
    MOVES_LO_X,
    N_EV,
    NEVER,
    NEXT_SLOT,
    NEXT_STATE,
    NEXT_STEP,
    NOW,
    OFF_LO_X,
    PAUSED,
    PERIOD,
    REL_MASK,
    REPORT_STEPS,
    REPORTED,
    RETURN_TICKS,
    SAME_TICK,
    SEEDING,
    SEQ,
    SLOTS_LOG2,
    STATE,
    STEP_LOG2,
    SUPPORT,
    SUPPORT_MAX,
    TICK,
    VISIBLE,
    WAITS,
    WAITS_TICK,
    Table,
)
from ._velocity import advance, follow_pace
from ._windows import await_return, bounded, measure, set_window

__all__ = ["RECORDS_PER_STEP", "feed", "initialise", "restart", "restep"]

RECORDS_PER_STEP = 3  # at most
NOBODY = -1  # owns an event
ENDING = 2  # COMPUTED, while slots end with one that takes effect


@njit(cache=True, nogil=True)
def initialise(s: Table, r: Table, glob: Table, modes: Table, places: Table) -> None:
    """Reset: every slot is free."""
    glob[:] = 0
    restep(r, glob)
    glob[DUE] = NEVER
    glob[DUE_TICK] = NEVER
    glob[SEEDING] = -1
    for i in range(s.shape[0]):
        s[i, STATE] = FREE
        s[i, EV_STATE] = FREE
        s[i, DEADLINE] = NEVER
    clear(s, places)
    for i in range(s.shape[0]):
        renew(s, places, modes, i)


@step
def _take_effect(s: Table, i: int) -> None:
    """What was computed of slot i takes effect: its sides move, and go on from where events have moved them meanwhile."""
    s[i, EV_STATE] = s[i, NEXT_STATE]
    for k in range(4):
        s[i, EV_LO_X + k] += s[i, MOVES_LO_X + k]
        s[i, MOVES_LO_X + k] = 0
    for k in range(BOX_LO_X, BEYOND):
        s[i, IN_EFFECT + k] = s[i, k]
    s[i, EV_BEYOND] |= s[i, BEYOND]
    s[i, CORRECTS] = 0
    s[i, COMPUTED] = 0


@step
def _end_with(s: Table, glob: Table, modes: Table, places: Table, i: int) -> None:
    """Slots that end with slot i, and those that end with them."""
    more = True
    s[i, COMPUTED] = ENDING
    while more:
        more = False
        for j in range(s.shape[0]):
            by = s[j, ENDS_WITH] - 1
            if by >= 0 and s[by, COMPUTED] == ENDING:
                s[j, ENDS_WITH] = 0
                s[j, WAITS] = 0
                s[j, CORRECTS] = 0
                s[j, COMPUTED] = ENDING
                s[j, EV_STATE] = FREE
                if glob[SEEDING] == j:
                    glob[SEEDING] = -1
                renew(s, places, modes, j)
                more = True
    for j in range(s.shape[0]):
        if s[j, COMPUTED] == ENDING:
            s[j, COMPUTED] = 0


@step
def _effects(s: Table, glob: Table, modes: Table, places: Table, event: int, tick: int) -> None:
    """All that takes effect before this event and tick; then see which are the next ones to wait for."""
    glob[DUE] = NEVER
    glob[DUE_TICK] = NEVER
    for i in range(s.shape[0]):
        if s[i, WAITS] and (s[i, WAITS] <= event or s[i, WAITS_TICK] <= tick):
            s[i, WAITS] = 0
            if s[i, COMPUTED]:  # not if another slot's step has ended it
                _take_effect(s, i)
                if glob[SEEDING] == i:
                    glob[SEEDING] = -1
                renew(s, places, modes, i)
                _end_with(s, glob, modes, places, i)
    for i in range(s.shape[0]):
        if s[i, WAITS]:
            _due(glob, s[i, WAITS], s[i, WAITS_TICK])


@step
def _due(glob: Table, event: int, tick: int) -> None:
    glob[DUE] = min(glob[DUE], event)
    glob[DUE_TICK] = min(glob[DUE_TICK], tick)


@step
def _wait(s: Table, glob: Table, i: int, now: int) -> None:
    """Slot i waits for what a job computes now, and for what it waits for already."""
    s[i, WAITS] = glob[SEQ] + EFFECT_EVENTS
    s[i, WAITS_TICK] = now + EFFECT_TICKS
    _due(glob, s[i, WAITS], s[i, WAITS_TICK])


@step
def _begin(s: Table, lim: Table, i: int) -> None:
    """A job on slot i begins with the sides in effect, moved as its last job says; their offsets have grown by as much."""
    for k in range(4):
        moved = s[i, EV_LO_X + k] + s[i, MOVES_LO_X + k] - s[i, LO_X + k]
        s[i, LO_X + k] += moved
        s[i, OFF_LO_X + k] += moved
    s[i, BEYOND] = 0
    s[i, SUPPORT] = min(s[i, SUPPORT] + s[i, EV_OWNED], lim[SUPPORT_MAX])
    s[i, EV_OWNED] = 0


@step
def _finish(s: Table, i: int) -> None:
    """The job on slot i ends: what takes effect later."""
    s[i, COMPUTED] = 1
    s[i, NEXT_STATE] = s[i, STATE]
    for k in range(4):
        s[i, MOVES_LO_X + k] = s[i, LO_X + k] - s[i, EV_LO_X + k]


@njit(cache=True, nogil=True)
def restep(r: Table, glob: Table) -> None:
    """`step_log2` has changed: the next step is slot 0's, at the next multiple of a period."""
    glob[PERIOD] = ((glob[NOW] >> r[STEP_LOG2]) + 1) << r[STEP_LOG2]
    glob[NEXT_SLOT] = 0
    glob[NEXT_STEP] = glob[PERIOD]


@njit(cache=True, nogil=True)
def restart(s: Table, lim: Table, glob: Table, modes: Table, places: Table, i: int, out: Table) -> int:
    """End slot i's life at once; returns the number of records, one if it was visible."""
    n = 0
    _effects(s, glob, modes, places, NEVER - 1, 0)
    if s[i, STATE] == VISIBLE:
        _begin(s, lim, i)
        n = record(s, i, LOST, glob[SEQ], glob[NOW], 0, out, n)
    s[i, STATE] = FREE
    s[i, EV_STATE] = FREE
    s[i, DEADLINE] = NEVER
    renew(s, places, modes, i)
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
    known = s[i, STATE] == VISIBLE or s[i, CORRECTIONS] >= MOVES_FROM
    if known:
        advance(s, r, lim, i, now)
    bounded(s, r, LO_X, HI_X, i)
    bounded(s, r, LO_Y, HI_Y, i)
    if known:
        follow_pace(s, i)
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
def _step(s: Table, r: Table, lim: Table, glob: Table, modes: Table, places: Table, out: Table, n: int) -> int:
    """The next motion step of a slot."""
    now = glob[NEXT_STEP]
    i = glob[NEXT_SLOT]
    if glob[DUE] <= glob[SEQ] or glob[DUE_TICK] <= now:
        _effects(s, glob, modes, places, glob[SEQ], now)
    if i == 0:
        _pause(r, glob)
    if s[i, STATE] != FREE:
        if not s[i, WAITS]:
            _wait(s, glob, i, now)
        _begin(s, lim, i)
        n = _step_slot(s, r, lim, glob, i, now, out, n)
        _finish(s, i)
    _go_on(r, lim, glob, s.shape[0])
    return n


@step
def _lives(s: Table) -> bool:
    """Whether any slot has a candidate, or a track, lost ones that may return among them."""
    for i in range(s.shape[0]):  # noqa: SIM110 (any() would allocate)
        if s[i, EV_STATE] != FREE:
            return True
    return False


@step
def _take(s: Table, r: Table, lim: Table, i: int, x: int, y: int, shared: bool, in_burst: bool) -> bool:
    """What an event does to its owner; true when the window of N_ev events is complete."""
    s[i, EV_OWNED] = min(s[i, EV_OWNED] + 1, lim[SUPPORT_MAX])
    if shared:
        return False
    if r[GAP_CORRECTIONS] and not s[i, CORRECTS]:
        count_in_bins(s, i, x, y)
    measure(s, r, i, x, y, in_burst)
    if s[i, CORRECTS]:
        return False
    s[i, EV_COUNT] += 1
    return bool(s[i, EV_COUNT] >= s[i, N_EV])


@step
def _in_burst(glob: Table, now: int) -> bool:
    """Count a kept event; whether enough of them have come at its tick before it."""
    if now != glob[TICK]:
        glob[TICK] = now
        glob[SAME_TICK] = 0
    glob[SAME_TICK] += 1
    return bool(glob[SAME_TICK] > BURST_FROM)


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
    while glob[NEXT_STEP] <= now and n + RECORDS_PER_STEP <= len(out):
        i = glob[NEXT_SLOT]
        if i > 0 and s[i, EV_STATE] == FREE and glob[DUE] == NEVER:
            _go_on(r, lim, glob, s.shape[0])
            continue
        if not _lives(s):  # steps in which nothing happens, however many
            glob[PERIOD] = (now >> r[STEP_LOG2]) << r[STEP_LOG2]
            glob[NEXT_SLOT] = 0
            while glob[NEXT_STEP] <= now:
                _go_on(r, lim, glob, s.shape[0])
            break
        glob[SEQ] = before + _first_from(ticks, glob[SEQ] - before, e, glob[NEXT_STEP])
        n = _step(s, r, lim, glob, modes, places, out, n)
    return n


@step
def _first_from(values: Table, begin: int, end: int, least: int) -> int:
    """The index of the first of the sorted values from `begin` to `end` that is at least `least`; `end` if none is."""
    while begin < end:
        middle = (begin + end) >> 1
        if values[middle] < least:
            begin = middle + 1
        else:
            end = middle
    return begin


@step
def _seed(s: Table, r: Table, glob: Table, places: Table, i: int, x: int, y: int, now: int) -> None:
    """An event begins a candidate in slot i, which no other one does until this one is in effect."""
    places[OF_STATE, s[i, EV_STATE]] &= ~alone(i)
    places[OF_STATE, CANDIDATE] |= alone(i)
    seed(s, r, i, x, y, now, now - glob[PAUSED])
    s[i, EV_STATE] = CANDIDATE
    for k in range(4):
        s[i, EV_LO_X + k] = s[i, LO_X + k]
    s[i, EV_BEYOND] = 0
    s[i, EV_OWNED] = 0
    s[i, EV_COUNT] = 0
    s[i, ENDS_WITH] = 0
    glob[SEEDING] = i
    s[i, CORRECTS] = 1
    _wait(s, glob, i, now)
    _finish(s, i)


@step
def _correct(s: Table, r: Table, lim: Table, glob: Table, i: int, now: int, in_burst: bool, out: Table, n: int) -> int:
    """An event completes a window of slot i; returns the new number of records."""
    s[i, CORRECTS] = 1
    _wait(s, glob, i, now)
    if s[i, STATE] == FREE or s[i, STATE] == LEFT:  # its life has ended
        return n
    _begin(s, lim, i)
    s[i, BEYOND] = s[i, EV_BEYOND]
    s[i, EV_BEYOND] = 0
    s[i, EV_COUNT] = 0
    correct(s, r, i, now, now - glob[PAUSED], in_burst)
    _finish(s, i)
    return record(s, i, MOVED, glob[SEQ], now, 0, out, n) if s[i, STATE] == VISIBLE else n


@njit(cache=True, nogil=True)
def feed(
    s: Table, r: Table, lim: Table, glob: Table, modes: Table, places: Table,
    ticks: Table, xs: Table, ys: Table, kept: Table, done: int,
    owner: Table, rel_x: Table, rel_y: Table, visible: Table, out: Table,
) -> tuple[int, int]:  # fmt: skip
    """Process a run of events, of which `done` are done, to its end or until `out` could overflow.

    `kept` are the numbers of those events that no filter took out, in order; the others only advance time and the event count.
    `owner`, `rel_x`, `rel_y` and `visible` are filled in for events that are kept; the last three hold zeros, which stay where
    there is no owner.

    Returns:
        Events done and records written.
    """
    n = 0
    before = glob[SEQ] - done
    for k in range(_first_from(kept, 0, len(kept), done), len(kept) + 1):
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
        if glob[SEQ] >= glob[DUE] or now >= glob[DUE_TICK]:
            _effects(s, glob, modes, places, glob[SEQ], now)
        glob[BUSY] = 1
        in_burst = _in_burst(glob, now)
        x: Any = np.int64(xs[e])  # signed: unsigned ones would be compared with sides as floats
        y: Any = np.int64(ys[e])
        i, shared, seeds = find(places, x, y)
        if i >= 0 and not seeds:
            owner[e] = i
            rel_x[e] = (2 * x - s[i, EV_BOX_LO_X] - s[i, EV_BOX_HI_X]) & lim[REL_MASK]
            rel_y[e] = (2 * y - s[i, EV_BOX_LO_Y] - s[i, EV_BOX_HI_Y]) & lim[REL_MASK]
            visible[e] = s[i, EV_STATE] == VISIBLE
            if _take(s, r, lim, i, x, y, shared, in_burst):
                n = _correct(s, r, lim, glob, i, now, in_burst, out, n)
        elif i >= 0 and glob[SEEDING] < 0:
            _seed(s, r, glob, places, i, x, y, now)
            owner[e] = i  # it is the middle of the candidate's box
        else:
            owner[e] = NOBODY
        glob[SEQ] += 1
    glob[NOW] = ticks[-1]
    glob[SEQ] = before + len(ticks)
    return len(ticks), n
