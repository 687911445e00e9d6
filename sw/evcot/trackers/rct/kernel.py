# SPDX-License-Identifier: Apache-2.0
"""The loop over events: find the cluster whose window holds the event, move it, or seed one."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from ..._numba_private import step
from .find import NOBODY, find_by_options, find_nearest
from .life import check, note_ends_of_life, seed
from .lookup import cell_of, events_within
from .move import move, pull_extent, pull_size
from .packet import close_packet, open_packet
from .state import NEVER_US, RECORDS_PER_PACKET, EventOptions, EventRules, State, Table

__all__ = ["close_last_packet", "feed"]


@step
def _at_times(state: State, t_us: int) -> Any:
    """Process what is due before an event; returns the time of the next call."""
    cur = state.cursor[0]
    if t_us >= cur.packet_end_us:
        open_packet(state, t_us)
    if t_us >= cur.next_due_us:
        note_ends_of_life(state, t_us)
    return min(cur.packet_end_us, cur.next_due_us)


@njit(cache=True, nogil=True)
def feed(
    state: State, rules: EventRules, options: EventOptions | None, ts: Table, xs: Table, ys: Table, owner: Table
) -> int:  # fmt: skip
    """Track events until all are done or the buffer could overflow; returns the number done.

    Without `options` it is the paper's tracker: Numba then compiles it without the code of the options.
    """
    _, cursor, clusters, live, _, cells, around, _, out = state
    cur = cursor[0]
    n_max = len(live)
    radius_px, alpha = rules.radius_px, rules.alpha
    keep = 1.0 - alpha
    wake_us = min(cur.packet_end_us, cur.next_due_us)
    first_index = cur.index
    for e in range(len(ts)):
        t_us = ts[e]
        if t_us >= wake_us:
            if e > 0:
                cur.last_us = ts[e - 1]
            cur.index = first_index + e
            if t_us >= cur.packet_end_us and cur.records + RECORDS_PER_PACKET * n_max > len(out):
                return e
            wake_us = _at_times(state, t_us)
        x = float(xs[e])
        y = float(ys[e])
        if options is None:
            seat, nearest_px = find_nearest(clusters, cells, xs[e], ys[e], x, y)
            held = nearest_px <= radius_px
        else:
            cell = cell_of(xs[e], ys[e])
            seat, (u, v) = find_by_options(options, clusters, cells, 1.0, cell, x, y)
            held = seat != np.uint64(NOBODY)
            if not held and len(around) > 0:
                seat, (u, v) = find_by_options(options, clusters, around, options.surround, cell, x, y)
        if held:
            cluster = clusters[seat]
            astray = False
            if options is None:
                pull_extent(cluster, abs(x - cluster.x), abs(y - cluster.y))
                cluster.x = keep * cluster.x + alpha * x
                cluster.y = keep * cluster.y + alpha * y
            else:
                move(options, cluster, x, y, u, v)
                astray = max(abs(cluster.x - cluster.cells_x), abs(cluster.y - cluster.cells_y)) > cluster.room
            cluster.last_us = t_us
            cluster.packet_events += 1
            owner[e] = cluster.slot
            if astray or cluster.packet_events >= cluster.check_at:
                again = events_within(rules, cluster) if options is None and cluster.track_id >= 0 else 0
                if again > 0:
                    cluster.check_at = cluster.packet_events + again
                    continue
                check(state, np.int64(seat), first_index + e, t_us)  # type: ignore[arg-type]
        elif options is not None and seat != np.uint64(NOBODY):
            pull_size(options, clusters[seat], x, y, u, v)
            owner[e] = -1
        elif cur.live < n_max:
            seat_new = seed(state, x, y, t_us)
            check(state, seat_new, first_index + e, t_us)
            owner[e] = clusters[seat_new].slot
        else:
            owner[e] = -1
    cur.index = first_index + len(ts)
    if len(ts) > 0:
        cur.last_us = ts[len(ts) - 1]
    return len(ts)


@njit(cache=True, nogil=True)
def close_last_packet(state: State) -> None:
    """Close the open packet at the end of the stream: time does not advance beyond the last event."""
    cur = state.cursor[0]
    if cur.packet_end_us != -NEVER_US:
        close_packet(state, cur.last_us)
    cur.closed = cur.records
