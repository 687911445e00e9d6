# SPDX-License-Identifier: Apache-2.0
"""The compiled inside of the Rectangular Cluster Tracker: one function per step of the algorithm.

Live clusters stand at the front of one array, in the order in which they were seeded, so that the search over them touches
nothing else. Records go into a buffer whose tail belongs to the packet that is still open.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..contract import Kind

__all__ = ["CLUSTER", "CURSOR", "NEVER_US", "RECORDS_PER_PACKET", "Rules", "close_last_packet", "feed"]

Table = NDArray[Any]

CLUSTER = np.dtype(
    [
        ("x", "<f8"),  # centre, pixels
        ("y", "<f8"),
        ("velocity_x", "<f8"),  # pixels per second
        ("velocity_y", "<f8"),
        ("from_x", "<f8"),  # where and when velocity was last measured
        ("from_y", "<f8"),
        ("from_us", "<i8"),  # NEVER_US before the end of its first packet
        ("last_us", "<i8"),  # its last event
        ("events", "<i8"),  # accumulated, its own and those of the clusters that it absorbed
        ("packet_events", "<i8"),  # of which in the open packet
        ("track_id", "<i8"),  # -1 until it is visible
        ("due_index", "<i8"),  # first event at or after the end of its life, -1 while there is none
        ("slot", "<i8"),
    ]
)

CURSOR = np.dtype(
    [
        ("live", "<i8"),  # clusters
        ("births", "<i8"),  # clusters that became visible so far: the next track id
        ("index", "<i8"),  # events so far
        ("last_us", "<i8"),  # the last event
        ("packet_end_us", "<i8"),  # exclusive; -NEVER_US before the first event
        ("next_due_us", "<i8"),  # no life without a due_index ends before it
        ("records", "<i8"),  # in the buffer
        ("closed", "<i8"),  # of which in packets that are closed
    ]
)


class Rules(NamedTuple):
    """`config.RctConfig` as the kernel takes it."""

    radius_px: float
    alpha: float
    velocity_alpha: float
    visible_events: int
    lifetime_us: int
    packet_us: int


NEVER_US = 1 << 62
# A cluster is born, and ends or moves, in one packet, and may be lost in the silence after it; then the next packet's births.
RECORDS_PER_PACKET = 4
BORN, MOVED, MERGED, LOST = int(Kind.BORN), int(Kind.MOVED), int(Kind.MERGED), int(Kind.LOST)


@njit(cache=True, nogil=True)
def _record(cur: Any, out: Table, kind: int, index: int, t_us: int, cluster: Any, radius_px: float, other_id: int) -> None:
    """Write one record where its event index puts it; a loss stands before what the event itself causes."""
    at = cur.records
    while at > cur.closed:
        before = out[at - 1]
        if kind == LOST and before.event_index == index:
            stays = before.kind == LOST and before.t_us <= t_us
        else:
            stays = before.event_index <= index
        if stays:
            break
        out[at] = before
        at -= 1
    row = out[at]
    row.t_us = t_us
    row.event_index = index
    row.kind = kind
    row.track_id = cluster.track_id
    row.slot = cluster.slot
    row.x = cluster.x
    row.y = cluster.y
    row.radius = radius_px
    row.n_ev = cluster.packet_events
    row.support = cluster.events
    row.other_id = other_id
    cur.records += 1


@njit(cache=True, nogil=True, inline="always")
def _distance(dx: float, dy: float) -> float:
    """Chebyshev: a window of radius R holds exactly the points at most R away."""
    return max(abs(dx), abs(dy))


@njit(cache=True, nogil=True)
def _show(cur: Any, out: Table, cluster: Any, index: int, t_us: int, radius_px: float) -> None:
    cluster.track_id = cur.births
    cur.births += 1
    _record(cur, out, BORN, index, t_us, cluster, radius_px, -1)


@njit(cache=True, nogil=True)
def _seed(cur: Any, clusters: Table, slot_taken: Table, x: float, y: float, t_us: int) -> Any:
    slot = 0
    while slot_taken[slot]:
        slot += 1
    slot_taken[slot] = True
    cluster = clusters[cur.live]
    cluster.x = x
    cluster.y = y
    cluster.velocity_x = 0.0
    cluster.velocity_y = 0.0
    cluster.from_us = NEVER_US
    cluster.last_us = t_us
    cluster.events = 1
    cluster.packet_events = 1
    cluster.track_id = -1
    cluster.due_index = -1
    cluster.slot = slot
    cur.live += 1
    return cluster


@njit(cache=True, nogil=True)
def _drop(cur: Any, clusters: Table, slot_taken: Table, i: int) -> None:
    slot_taken[clusters[i].slot] = False
    cur.live -= 1
    for k in range(i, cur.live):
        clusters[k] = clusters[k + 1]


@njit(cache=True, nogil=True)
def _note_ends_of_life(rules: Rules, cur: Any, clusters: Table, t_us: int) -> None:
    """Remember, for clusters whose life has ended by now, that the coming event is the first that finds them gone."""
    cur.next_due_us = NEVER_US
    for i in range(cur.live):
        cluster = clusters[i]
        if cluster.due_index < 0:
            end_us = cluster.last_us + rules.lifetime_us
            if end_us <= t_us:
                cluster.due_index = cur.index
            else:
                cur.next_due_us = min(cur.next_due_us, end_us)


@njit(cache=True, nogil=True)
def _remove_silent(rules: Rules, cur: Any, clusters: Table, slot_taken: Table, now_us: int, out: Table) -> None:
    i = 0
    while i < cur.live:
        cluster = clusters[i]
        end_us = cluster.last_us + rules.lifetime_us
        if end_us <= now_us:
            if cluster.track_id >= 0:
                index = cluster.due_index if cluster.due_index >= 0 else cur.index
                _record(cur, out, LOST, index, end_us, cluster, rules.radius_px, -1)
            _drop(cur, clusters, slot_taken, i)
        else:
            i += 1


@njit(cache=True, nogil=True)
def _measure_velocity(rules: Rules, cur: Any, cluster: Any) -> None:
    """Displacement between packet ends, mixed like a location: event times are too close together to divide by."""
    if cluster.from_us != NEVER_US:
        elapsed_s = 1e-6 * (cur.packet_end_us - cluster.from_us)
        keep = 1.0 - rules.velocity_alpha
        cluster.velocity_x = keep * cluster.velocity_x + rules.velocity_alpha * ((cluster.x - cluster.from_x) / elapsed_s)
        cluster.velocity_y = keep * cluster.velocity_y + rules.velocity_alpha * ((cluster.y - cluster.from_y) / elapsed_s)
    cluster.from_x = cluster.x
    cluster.from_y = cluster.y
    cluster.from_us = cur.packet_end_us


@njit(cache=True, nogil=True)
def _merge(rules: Rules, cur: Any, clusters: Table, slot_taken: Table, i: int, j: int, out: Table) -> None:
    """Merge clusters i < j: the one that became visible first stays; of two invisible ones, the one seeded first."""
    a = clusters[i].track_id
    b = clusters[j].track_id
    stays, goes = (j, i) if b >= 0 and (a < 0 or b < a) else (i, j)
    into = clusters[stays]
    gone = clusters[goes]
    index = cur.index - 1
    if gone.track_id >= 0:
        _record(cur, out, MERGED, index, cur.last_us, gone, rules.radius_px, into.track_id)
    total = into.events + gone.events
    into.x = (into.x * into.events + gone.x * gone.events) / total
    into.y = (into.y * into.events + gone.y * gone.events) / total
    into.velocity_x = (into.velocity_x * into.events + gone.velocity_x * gone.events) / total
    into.velocity_y = (into.velocity_y * into.events + gone.velocity_y * gone.events) / total
    into.from_x = into.x
    into.from_y = into.y
    into.from_us = cur.packet_end_us
    into.last_us = max(into.last_us, gone.last_us)
    into.events = total
    into.packet_events += gone.packet_events
    if into.track_id < 0 and into.events >= rules.visible_events:
        _show(cur, out, into, index, cur.last_us, rules.radius_px)
    _drop(cur, clusters, slot_taken, goes)


@njit(cache=True, nogil=True)
def _merge_overlapping(rules: Rules, cur: Any, clusters: Table, slot_taken: Table, out: Table) -> None:
    """Merge until no two windows share a point. None did after the last packet, so only what moved since can."""
    i = 0
    while i < cur.live:
        merged = False
        for j in range(i + 1, cur.live):
            a = clusters[i]
            b = clusters[j]
            if a.packet_events + b.packet_events > 0 and _distance(a.x - b.x, a.y - b.y) <= 2.0 * rules.radius_px:
                _merge(rules, cur, clusters, slot_taken, i, j, out)
                merged = True
                break
        i = 0 if merged else i + 1


@njit(cache=True, nogil=True)
def _close_packet(rules: Rules, cur: Any, clusters: Table, slot_taken: Table, now_us: int, out: Table) -> None:
    """What the algorithm does after the events of a packet."""
    _remove_silent(rules, cur, clusters, slot_taken, now_us, out)
    for i in range(cur.live):
        if clusters[i].packet_events > 0:
            _measure_velocity(rules, cur, clusters[i])
    _merge_overlapping(rules, cur, clusters, slot_taken, out)
    for i in range(cur.live):
        cluster = clusters[i]
        if cluster.packet_events > 0 and cluster.track_id >= 0:
            _record(cur, out, MOVED, cur.index - 1, cur.last_us, cluster, rules.radius_px, -1)
        cluster.packet_events = 0


@njit(cache=True, nogil=True)
def _open_packet(rules: Rules, cur: Any, clusters: Table, slot_taken: Table, t_us: int, out: Table) -> None:
    """Close the packets before the one that holds `t_us`: in the silent ones among them, clusters can only end."""
    if cur.packet_end_us == -NEVER_US:
        cur.packet_end_us = t_us + rules.packet_us
        return
    _close_packet(rules, cur, clusters, slot_taken, cur.packet_end_us, out)
    silent = (t_us - cur.packet_end_us) // rules.packet_us
    if silent > 0:
        cur.packet_end_us += silent * rules.packet_us
        _remove_silent(rules, cur, clusters, slot_taken, cur.packet_end_us, out)
    cur.packet_end_us += rules.packet_us
    cur.closed = cur.records


@njit(cache=True, nogil=True)
def feed(
    rules: Rules, cursor: Table, clusters: Table, slot_taken: Table,
    ts: Table, xs: Table, ys: Table, begin: int, owner: Table, out: Table,
) -> int:  # fmt: skip
    """Track events from `begin` on until all are done or `out` could overflow; returns how many are done."""
    cur = cursor[0]
    n_max = len(clusters)
    keep = 1.0 - rules.alpha
    for e in range(begin, len(ts)):
        t_us = ts[e]
        if t_us >= cur.packet_end_us:
            if cur.records + RECORDS_PER_PACKET * n_max > len(out):
                return e
            _open_packet(rules, cur, clusters, slot_taken, t_us, out)
        if t_us >= cur.next_due_us:
            _note_ends_of_life(rules, cur, clusters, t_us)
        x = float(xs[e])
        y = float(ys[e])
        nearest = -1
        nearest_px = np.inf
        for i in range(cur.live):
            distance_px = _distance(x - clusters[i].x, y - clusters[i].y)
            if distance_px < nearest_px:
                nearest_px = distance_px
                nearest = i
        if nearest_px <= rules.radius_px:
            cluster = clusters[nearest]
            cluster.x = keep * cluster.x + rules.alpha * x
            cluster.y = keep * cluster.y + rules.alpha * y
            cluster.last_us = t_us
            cluster.due_index = -1
            cluster.events += 1
            cluster.packet_events += 1
            owner[e] = cluster.slot
            if cluster.track_id < 0 and cluster.events >= rules.visible_events:
                _show(cur, out, cluster, cur.index, t_us, rules.radius_px)
        elif cur.live < n_max:
            cluster = _seed(cur, clusters, slot_taken, x, y, t_us)
            owner[e] = cluster.slot
            if cluster.events >= rules.visible_events:
                _show(cur, out, cluster, cur.index, t_us, rules.radius_px)
        else:
            owner[e] = -1
        cur.next_due_us = min(cur.next_due_us, t_us + rules.lifetime_us)
        cur.last_us = t_us
        cur.index += 1
    return len(ts)


@njit(cache=True, nogil=True)
def close_last_packet(rules: Rules, cursor: Table, clusters: Table, slot_taken: Table, out: Table) -> None:
    """Close the open packet when no more events come: time has passed until the last event and no further."""
    cur = cursor[0]
    if cur.packet_end_us != -NEVER_US:
        _close_packet(rules, cur, clusters, slot_taken, cur.last_us, out)
    cur.closed = cur.records
