# SPDX-License-Identifier: Apache-2.0
"""The loop over events: find the cluster whose window holds the event, move it, or seed one."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from .life import check, note_ends_of_life, seed
from .lookup import cell_of, lowest, without_lowest
from .packet import close_packet, open_packet
from .state import NEVER_US, RECORDS_PER_PACKET, Rules, State, Table

__all__ = ["close_last_packet", "feed"]


@njit(cache=True, nogil=True)
def _at_times(rules: Rules, state: State, t_us: int) -> Any:
    """What time brings before an event; returns when to come again."""
    cur = state.cursor[0]
    if t_us >= cur.packet_end_us:
        open_packet(rules, state, t_us)
    if t_us >= cur.next_due_us:
        note_ends_of_life(rules, state, t_us)
    return min(cur.packet_end_us, cur.next_due_us)


@njit(cache=True, nogil=True)
def feed(rules: Rules, state: State, ts: Table, xs: Table, ys: Table, owner: Table) -> int:
    """Track events until all are done or the buffer could overflow; returns how many are done."""
    cursor, clusters, _, cells, out = state
    cur = cursor[0]
    n_max = len(clusters)
    words = cells.shape[1]
    keep = 1.0 - rules.alpha
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
            wake_us = _at_times(rules, state, t_us)
        x = float(xs[e])
        y = float(ys[e])
        cell = cell_of(xs[e], ys[e])
        nearest: Any = np.uint64(0)
        nearest_px = np.inf
        for word in range(words):
            near = cells[cell, word]
            while near != np.uint64(0):
                slot = lowest(near) + np.uint64(64 * word)
                near = without_lowest(near)
                distance_px = max(abs(x - clusters[slot].x), abs(y - clusters[slot].y))
                # A window of radius R holds exactly the points at most R away. Of two equally near, the older takes it.
                if distance_px < nearest_px or (distance_px == nearest_px and clusters[slot].order < clusters[nearest].order):
                    nearest_px = distance_px
                    nearest = slot
        if nearest_px <= rules.radius_px:
            cluster = clusters[nearest]
            cluster.x = keep * cluster.x + rules.alpha * x
            cluster.y = keep * cluster.y + rules.alpha * y
            cluster.last_us = t_us
            cluster.packet_events += 1
            owner[e] = nearest
            if cluster.packet_events >= cluster.check_at:
                check(rules, state, np.int64(nearest), first_index + e, t_us)  # type: ignore[arg-type]
        elif cur.live < n_max:
            slot_new = seed(rules, state, x, y, t_us)
            check(rules, state, slot_new, first_index + e, t_us)
            owner[e] = slot_new
        else:
            owner[e] = -1
    cur.index = first_index + len(ts)
    if len(ts) > 0:
        cur.last_us = ts[len(ts) - 1]
    return len(ts)


@njit(cache=True, nogil=True)
def close_last_packet(rules: Rules, state: State) -> None:
    """Close the open packet when no more events come: time has passed until the last event and no further."""
    cur = state.cursor[0]
    if cur.packet_end_us != -NEVER_US:
        close_packet(rules, state, cur.last_us)
    cur.closed = cur.records
