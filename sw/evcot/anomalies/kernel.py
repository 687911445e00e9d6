# SPDX-License-Identifier: Apache-2.0
"""The compiled loop over records: assigns each record to a track, and closes the track's steps.

Rows of the table are live tracks, and some that ended recently: a track that is born at the predicted position of one of these
continues it, so that an interruption by the tracker neither hides a long stay nor repeats an alarm.
"""

from __future__ import annotations

import math

import numpy as np

from .._numba_private import njit
from ..tracks.log import Kind
from .judge import end, judge
from .motion import add_place, begin, close_step, extent_px

__all__ = ["CURSOR", "feed"]

BORN, MERGED, LOST = int(Kind.BORN), int(Kind.MERGED), int(Kind.LOST)

CURSOR = np.dtype(
    [
        ("rows", "<i8"),  # of the table in use
        ("alarms", "<i8"),  # in the buffer
        ("origin_us", "<i8"),  # the first record; -1 << 62 before it
        ("t_us", "<i8"),  # the record in hand
        ("event_index", "<i8"),
    ]
)


@njit(cache=True, nogil=True)
def _clear(table, places, i):  # type: ignore[no-untyped-def]
    trace = table[i]
    trace.ended_us = -1
    trace.settled = False
    trace.farthest_px = 0.0
    trace.moved_us = 0.0
    trace.slow_us = 0.0
    trace.braked_t = -1.0
    trace.jumped = False
    trace.raised[:] = 0
    trace.open[:] = 0
    trace.evidence_us[:] = 0.0
    places.since[i] = -1.0
    places.left[i] = -1.0
    places.raised[i] = False
    places.side[i] = 0
    places.line_raised[i] = False


@njit(cache=True, nogil=True)
def _forget(cur, table, places, stitch_us):  # type: ignore[no-untyped-def]
    """Remove the rows of tracks that ended too long ago; the last row moves into the free place."""
    i = 0
    while i < cur.rows:
        if table[i].ended_us >= 0 and cur.t_us - cur.origin_us - table[i].ended_us > stitch_us:
            cur.rows -= 1
            last = cur.rows
            table[i] = table[last]
            for part in (places.since, places.left, places.x, places.y):
                part[i] = part[last]
            for flags in (places.raised, places.line_raised):
                flags[i] = flags[last]
            places.side[i] = places.side[last]
        else:
            i += 1


@njit(cache=True, nogil=True)
def _ended_near(cur, table, x, y, stitch_px):  # type: ignore[no-untyped-def]
    """The row of the ended track with the nearest predicted position, -1 if none is near."""
    best = -1
    best_px = math.inf
    for i in range(cur.rows):
        trace = table[i]
        if trace.ended_us < 0 or not trace.settled:
            continue
        ahead_s = 1e-6 * (cur.t_us - cur.origin_us - trace.t) if trace.known else 0.0
        away_px = math.hypot(trace.x + trace.vx * ahead_s - x, trace.y + trace.vy * ahead_s - y)
        if away_px <= max(stitch_px, trace.radius) and away_px < best_px:
            best = i
            best_px = away_px
    return best


@njit(cache=True, nogil=True)
def _row(cur, table, places, track_id, born, x, y, stitch_us, stitch_px):  # type: ignore[no-untyped-def]
    """The row of a record's track; adds a row if it has none."""
    if not born:
        for i in range(cur.rows):
            if table[i].track_id == track_id and table[i].ended_us < 0:
                return i
    _forget(cur, table, places, stitch_us)
    i = _ended_near(cur, table, x, y, stitch_px)
    if i >= 0:
        table[i].ended_us = -1
    else:
        i = cur.rows
        cur.rows += 1
        _clear(table, places, i)
        begin(table[i], 0)
        table[i].birth_us = cur.t_us
    table[i].track_id = track_id
    return i


@njit(cache=True, nogil=True)
def feed(steps, rules, field, places, stays, stitch_us, stitch_px, cursor, table, records, first, spare, out):  # type: ignore[no-untyped-def]
    """Process records from `first` on; returns the first not processed: the table or the alarm buffer may be too small."""
    cur = cursor[0]
    for k in range(first, len(records)):
        if cur.rows == len(table) or cur.alarms + spare > len(out):
            return k
        record = records[k]
        if cur.origin_us == -(1 << 62):
            cur.origin_us = record.t_us
        cur.t_us = record.t_us
        cur.event_index = record.event_index
        ends = record.kind == LOST or record.kind == MERGED
        i = _row(cur, table, places, record.track_id, record.kind == BORN, record.x, record.y, stitch_us, stitch_px)
        trace = table[i]
        after_us = record.t_us - cur.origin_us
        step = after_us // steps.step_us
        if trace.n > 0 and (ends or step > trace.step):
            close_step(steps, trace, record.radius, extent_px(record))
            judge(rules, field, places, stays, i, cur, trace, out)
        if ends:
            end(rules, field, stays, cur, trace, out, record.kind == LOST)
            trace.ended_us = after_us
        else:
            trace.radius = record.radius
            trace.extent = extent_px(record)
            add_place(trace, after_us, step, steps.step_us, record.x, record.y)
    return len(records)
