# SPDX-License-Identifier: Apache-2.0
"""Compiled kernels of the golden model: one function per rule of docs/algorithm.md, state in integer tables."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

from numpy.typing import NDArray

from .._numba_private import njit, step
from ..tracks.log import DROPPED, Kind
from .contract import HIST_AVG_STILL, REGISTERS, Mode

__all__ = ["FIELD_COUNT", "GLOBAL_COUNT", "LIMIT_COUNT", "Global", "Limit", "feed", "initialise", "rewrite"]

Table = NDArray[Any]


class Limit(IntEnum):
    """Entries of the limits table: limits that follow from the hardware's widths."""

    FRAC = 0
    X_MAX = 1
    Y_MAX = 2
    TC_MAX = 3
    SUPPORT_MAX = 4
    ID_MASK = 5
    IS_CHAIN = 6
    REL_MASK = 7


class Global(IntEnum):
    """Entries of the global state."""

    NOW = 0  # ticks since reset
    SEQ = 1  # events so far
    BIRTHS = 2  # of the whole array
    NEXT_DEADLINE = 3  # lower bound of all slots' deadlines


LIMIT_COUNT = len(Limit)
GLOBAL_COUNT = len(Global)

# Numba inlines plain module-level integers as constants; enum members would be looked up at run time.
(LO_X, HI_X, LO_Y, HI_Y, CM_X, CM_Y, AV_X, AV_Y, G, N_EV, COUNT, RING, SUPPORT, ACTIVE, ID, BIRTH_COUNT, DEADLINE, START,
 LAST_TC2, BIRTH) = range(20)  # fmt: skip
FIELD_COUNT = 20

MODE, INIT_X, INIT_Y, INIT_RADIX, RADIX_TH, RADIX_STEP, RADIX_MIN, RADIX_MAX = (
    list(REGISTERS).index(name)
    for name in ("mode", "init_cm_x", "init_cm_y", "init_radix", "radix_th", "radix_step", "radix_min", "radix_max")
)
HIST_AVG, MAX_TICKS, CLUST_NEV, NEV_MIN, NEV_MAX, NEV_TH, DETECT_TICKS = (
    list(REGISTERS).index(name)
    for name in ("hist_avg", "max_ticks", "clust_nev", "nev_min", "nev_max", "nev_th", "detect_ticks")
)
FRAC, X_MAX, Y_MAX, TC_MAX, SUPPORT_MAX, ID_MASK, IS_CHAIN, REL_MASK = (int(i) for i in Limit)
NOW, SEQ, BIRTHS, NEXT_DEADLINE = (int(i) for i in Global)
OFF, FIXED, SEEDED = int(Mode.OFF), int(Mode.FIXED), int(Mode.SEEDED)
BORN, MOVED, MERGED, LOST = int(Kind.BORN), int(Kind.MOVED), int(Kind.MERGED), int(Kind.LOST)
NEVER = 1 << 62


@njit(cache=True, nogil=True, inline="always")
def _pixel(centre: int, frac: int) -> int:
    """The pixel of a fixed-point centre: rounded to nearest, halves up."""
    return (centre + ((1 << frac) >> 1)) >> frac


@njit(cache=True, nogil=True, inline="always")
def _approach(value: int, target: int, k: int, frac: int) -> int:
    """value + (target - value) * 2^-k: rounded to nearest with fractional bits, floor (the plain shift) without.

    A k from HIST_AVG_STILL on, which only a host without the bus can write, leaves the value as it is.
    """
    if k >= HIST_AVG_STILL:
        return value
    half = ((1 << k) >> 1) if frac > 0 else 0
    return value + ((target - value + half) >> k)


@njit(cache=True, nogil=True, inline="always")
def _set_window(s: Table, regs: Table, lim: Table, i: int) -> None:
    radius = s[G, i] + regs[RADIX_TH, i]
    px = _pixel(s[CM_X, i], lim[FRAC])
    py = _pixel(s[CM_Y, i], lim[FRAC])
    s[LO_X, i] = max(px - radius, 0)
    s[HI_X, i] = min(px + radius, lim[X_MAX])
    s[LO_Y, i] = max(py - radius, 0)
    s[HI_Y, i] = min(py + radius, lim[Y_MAX])


@njit(cache=True, nogil=True)
def _place(s: Table, regs: Table, lim: Table, i: int, x: int, y: int) -> None:
    """Set centre and average to pixel (x, y)."""
    s[CM_X, i] = x << lim[FRAC]
    s[CM_Y, i] = y << lim[FRAC]
    s[AV_X, i] = s[CM_X, i]
    s[AV_Y, i] = s[CM_Y, i]
    _set_window(s, regs, lim, i)


@njit(cache=True, nogil=True)
def _retire(s: Table, regs: Table, lim: Table, i: int) -> None:
    """INIT_CELL: a slot with a fixed start waits at its place; a seeded slot, or one that is off, has no window."""
    s[G, i] = regs[INIT_RADIX, i]
    s[N_EV, i] = regs[CLUST_NEV, i]
    s[COUNT, i] = 0
    s[RING, i] = 0
    s[SUPPORT, i] = 0
    s[ACTIVE, i] = 0
    s[DEADLINE, i] = NEVER
    _place(s, regs, lim, i, regs[INIT_X, i], regs[INIT_Y, i])
    if regs[MODE, i] != FIXED:
        s[LO_X, i] = 1
        s[HI_X, i] = 0


@njit(cache=True, nogil=True)
def initialise(s: Table, regs: Table, lim: Table, glob: Table) -> None:
    """Reset: send every slot through INIT_CELL."""
    glob[:] = 0
    glob[NEXT_DEADLINE] = NEVER
    for i in range(s.shape[1]):
        s[BIRTH_COUNT, i] = 0
        _retire(s, regs, lim, i)


@step
def _record(s: Table, regs: Table, lim: Table, i: int, kind: int, seq: int, time: int, other: int, out: Table, n: int) -> int:
    row = out[n]
    row.seq = seq
    row.time = time
    row.track_id = s[ID, i]
    row.other_id = other
    row.cm_x = s[CM_X, i]
    row.cm_y = s[CM_Y, i]
    row.support = s[SUPPORT, i]
    row.radius = s[G, i] + regs[RADIX_TH, i]
    row.n_ev = s[N_EV, i]
    row.slot = i
    row.kind = kind
    return n + 1


@step
def _expire(s: Table, regs: Table, lim: Table, glob: Table, now: int, out: Table, n: int) -> int:
    """End every life whose deadline has passed, in order of deadline, then of slot."""
    while True:
        first = -1
        deadline = NEVER
        for i in range(s.shape[1]):
            if s[DEADLINE, i] < deadline:
                first = i
                deadline = s[DEADLINE, i]
        if deadline > now:
            glob[NEXT_DEADLINE] = deadline
            return n
        if s[ACTIVE, first]:
            n = _record(s, regs, lim, first, LOST, glob[SEQ], deadline, 0, out, n)
        _retire(s, regs, lim, first)


@njit(cache=True, nogil=True, inline="always")
def _find_in_array(s: Table, regs: Table, x: int, y: int) -> tuple[int, bool]:
    """The active slot whose window holds the event, else the first such candidate, else the first free seeded slot."""
    candidate = -1
    n_slots = s.shape[1]
    for i in range(n_slots):
        if s[LO_X, i] <= x and x <= s[HI_X, i] and s[LO_Y, i] <= y and y <= s[HI_Y, i]:
            if s[ACTIVE, i]:
                return i, False
            if candidate < 0:
                candidate = i
    if candidate >= 0:
        return candidate, False
    for i in range(n_slots):
        if regs[MODE, i] == SEEDED and s[HI_X, i] < s[LO_X, i]:
            return i, True
    return -1, False


@njit(cache=True, nogil=True, inline="always")
def _find_in_chain(s: Table, regs: Table, x: int, y: int) -> tuple[int, bool]:
    """The first tracker whose window holds the event, or that is free to start at it."""
    for i in range(s.shape[1]):
        if s[LO_X, i] <= x and x <= s[HI_X, i] and s[LO_Y, i] <= y and y <= s[HI_Y, i]:
            return i, False
        if regs[MODE, i] == SEEDED and s[HI_X, i] < s[LO_X, i]:
            return i, True
    return -1, False


@njit(cache=True, nogil=True, inline="always")
def _take(s: Table, regs: Table, lim: Table, i: int, x: int, y: int, now: int) -> bool:
    """The part common to EV_NO_PROC and EV_PROC: average, ring, support, timers. True when N_ev is reached."""
    frac = lim[FRAC]
    ex = x << frac
    ey = y << frac
    g = s[G, i]
    if abs(x - _pixel(s[CM_X, i], frac)) > g or abs(y - _pixel(s[CM_Y, i], frac)) > g:
        s[RING, i] = 1
    k = regs[HIST_AVG, i]
    s[AV_X, i] = _approach(s[AV_X, i], ex, k, frac)
    s[AV_Y, i] = _approach(s[AV_Y, i], ey, k, frac)
    s[SUPPORT, i] = min(s[SUPPORT, i] + 1, lim[SUPPORT_MAX])
    if s[ACTIVE, i]:
        s[DEADLINE, i] = now + regs[MAX_TICKS, i]
    elif s[COUNT, i] == 0:
        s[DEADLINE, i] = now + regs[DETECT_TICKS, i] + 1
        s[START, i] = now
    s[COUNT, i] += 1
    return bool(s[COUNT, i] >= s[N_EV, i])


@step
def _adapt_n_ev(s: Table, regs: Table, i: int, tc2: int) -> None:
    if tc2 > s[LAST_TC2, i] + regs[NEV_TH, i]:
        s[N_EV, i] = min(2 * s[N_EV, i], regs[NEV_MAX, i])
    elif tc2 + regs[NEV_TH, i] < s[LAST_TC2, i]:
        s[N_EV, i] = max(s[N_EV, i] >> 1, regs[NEV_MIN, i])


@njit(cache=True, nogil=True)
def _proc(s: Table, regs: Table, lim: Table, glob: Table, i: int, now: int) -> int:
    """EV_PROC: radius, centre, N_ev, and a new window. Returns BORN or MOVED."""
    step = regs[RADIX_STEP, i]
    if s[RING, i]:
        s[G, i] = min(s[G, i] + step, regs[RADIX_MAX, i])
    else:
        s[G, i] = max(s[G, i] - step, regs[RADIX_MIN, i])
    k = regs[HIST_AVG, i]
    s[CM_X, i] = _approach(s[CM_X, i], s[AV_X, i], k, lim[FRAC])
    s[CM_Y, i] = _approach(s[CM_Y, i], s[AV_Y, i], k, lim[FRAC])
    tc2 = min(now - s[START, i], lim[TC_MAX])
    kind = MOVED
    if s[ACTIVE, i]:
        _adapt_n_ev(s, regs, i, tc2)
    else:
        kind = BORN
        s[ACTIVE, i] = 1
        s[DEADLINE, i] = now + regs[MAX_TICKS, i]
        if lim[IS_CHAIN]:
            s[ID, i] = (i + s[BIRTH_COUNT, i] * s.shape[1]) & lim[ID_MASK]
        else:
            s[ID, i] = glob[BIRTHS] & lim[ID_MASK]
        s[BIRTH, i] = glob[BIRTHS]
        s[BIRTH_COUNT, i] += 1
        glob[BIRTHS] += 1
    s[LAST_TC2, i] = tc2
    s[START, i] = now
    s[COUNT, i] = 0
    s[RING, i] = 0
    _set_window(s, regs, lim, i)
    return kind


@step
def _overlapping(s: Table, i: int) -> int:
    """The first active slot whose window shares a pixel with slot i's, or -1."""
    for j in range(s.shape[1]):
        if (
            j != i
            and s[ACTIVE, j]
            and s[LO_X, j] <= s[HI_X, i]
            and s[LO_X, i] <= s[HI_X, j]
            and s[LO_Y, j] <= s[HI_Y, i]
            and s[LO_Y, i] <= s[HI_Y, j]
        ):
            return j
    return -1


@step
def _merge(s: Table, regs: Table, lim: Table, glob: Table, moved: int, now: int, out: Table, n: int) -> int:
    """Merge the moved cluster with every cluster it overlaps until no active windows overlap; the first born survives."""
    while True:
        other = _overlapping(s, moved)
        if other < 0:
            return n
        stays, goes = (other, moved) if s[BIRTH, other] < s[BIRTH, moved] else (moved, other)
        a = s[SUPPORT, stays]
        b = s[SUPPORT, goes]
        half = ((a + b) >> 1) if lim[FRAC] > 0 else 0
        n = _record(s, regs, lim, goes, MERGED, glob[SEQ], now, s[ID, stays], out, n)
        s[CM_X, stays] = (s[CM_X, stays] * a + s[CM_X, goes] * b + half) // (a + b)
        s[CM_Y, stays] = (s[CM_Y, stays] * a + s[CM_Y, goes] * b + half) // (a + b)
        s[AV_X, stays] = s[CM_X, stays]
        s[AV_Y, stays] = s[CM_Y, stays]
        s[G, stays] = min(max(s[G, stays], s[G, goes]), regs[RADIX_MAX, stays])
        s[SUPPORT, stays] = min(a + b, lim[SUPPORT_MAX])
        s[DEADLINE, stays] = now + regs[MAX_TICKS, stays]
        glob[NEXT_DEADLINE] = min(glob[NEXT_DEADLINE], s[DEADLINE, stays])
        _set_window(s, regs, lim, stays)
        _retire(s, regs, lim, goes)
        n = _record(s, regs, lim, stays, MOVED, glob[SEQ], now, 0, out, n)
        moved = stays


@njit(cache=True, nogil=True)
def feed(
    s: Table, regs: Table, lim: Table, glob: Table,
    ticks: Table, xs: Table, ys: Table, keep: Table, begin: int, per_event_max: int,
    owner: Table, rel_x: Table, rel_y: Table, out: Table,
) -> tuple[int, int]:  # fmt: skip
    """Process events from `begin` on until all are done or `out` could overflow; returns (events done, records written).

    Events whose entry in `keep` is false only advance time and the event count; an empty `keep` keeps all.
    """
    n = 0
    frac = lim[FRAC]
    is_chain = lim[IS_CHAIN] != 0
    all_kept = len(keep) == 0
    for e in range(begin, len(ticks)):
        if n + per_event_max > len(out):
            return e, n
        x = int(xs[e])
        y = int(ys[e])
        now = ticks[e]
        glob[NOW] = now
        if now >= glob[NEXT_DEADLINE]:
            n = _expire(s, regs, lim, glob, now, out, n)
        if not (all_kept or keep[e]):
            owner[e] = DROPPED
            rel_x[e] = 0
            rel_y[e] = 0
            glob[SEQ] += 1
            continue
        slot, seeds = _find_in_chain(s, regs, x, y) if is_chain else _find_in_array(s, regs, x, y)
        owner[e] = slot
        if slot < 0:
            rel_x[e] = 0
            rel_y[e] = 0
        else:
            if seeds:
                _place(s, regs, lim, slot, x, y)
            radius = s[G, slot] + regs[RADIX_TH, slot]
            rel_x[e] = (x - _pixel(s[CM_X, slot], frac) + radius) & lim[REL_MASK]
            rel_y[e] = (y - _pixel(s[CM_Y, slot], frac) + radius) & lim[REL_MASK]
            if _take(s, regs, lim, slot, x, y, now):
                kind = _proc(s, regs, lim, glob, slot, now)
                n = _record(s, regs, lim, slot, kind, glob[SEQ], now, 0, out, n)
                if not is_chain:
                    n = _merge(s, regs, lim, glob, slot, now, out, n)
            glob[NEXT_DEADLINE] = min(glob[NEXT_DEADLINE], s[DEADLINE, slot])
        glob[SEQ] += 1
    return len(ticks), n


@njit(cache=True, nogil=True)
def rewrite(s: Table, regs: Table, lim: Table, glob: Table, i: int, values: Table, restart: bool, out: Table) -> int:
    """Change the registers of slot i between two events; returns the number of records written, one if a life ended.

    A tracker of a chain compares with its current registers, a slot of an array with the window last computed from them.
    """
    if lim[IS_CHAIN] and s[DEADLINE, i] != NEVER:
        limit = MAX_TICKS if s[ACTIVE, i] else DETECT_TICKS
        s[DEADLINE, i] += values[limit] - regs[limit, i]
        glob[NEXT_DEADLINE] = min(glob[NEXT_DEADLINE], s[DEADLINE, i])
    mode = values[MODE] if restart else regs[MODE, i]
    for register in range(len(values)):
        regs[register, i] = values[register]
    regs[MODE, i] = mode
    if lim[IS_CHAIN] and s[LO_X, i] <= s[HI_X, i]:
        _set_window(s, regs, lim, i)
    n = 0
    if restart:
        if s[ACTIVE, i]:
            n = _record(s, regs, lim, i, LOST, glob[SEQ], glob[NOW], 0, out, n)
        _retire(s, regs, lim, i)
    return n
