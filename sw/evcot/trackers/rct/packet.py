# SPDX-License-Identifier: Apache-2.0
"""Processing at the end of a packet, and merging of overlapping clusters, which happens there."""

from __future__ import annotations

import math
from typing import Any

from ..._numba_private import njit, step
from .find import events_within, set_room
from .life import check, drop, grow_mass, hide_weak, is_due, is_weak, missing_events, remove_silent, show_if_due
from .motion import advance, jump, measure_velocity
from .records import MASS_TAU_US, MERGED, MOVED, follow_size, record, set_mixing, set_steps
from .state import NEVER_US, State, Table

__all__ = ["close_packet", "open_packet"]


@step
def _blend(rules: Any, into: Any, gone: Any, now_us: int) -> None:
    """Average the two clusters, weighted by their events; with a visible rate, by mass, to which old events contribute less."""
    own = float(into.before + into.packet_events)
    other = float(gone.before + gone.packet_events)
    if rules.visible_rate_hz > 0.0 and into.mass + gone.mass > 0.0:
        own, other = into.mass, gone.mass
    total = own + other
    x, y = into.x, into.y
    into.x = (into.x * own + gone.x * other) / total
    into.y = (into.y * own + gone.y * other) / total
    into.velocity_x = (into.velocity_x * own + gone.velocity_x * other) / total
    into.velocity_y = (into.velocity_y * own + gone.velocity_y * other) / total
    jump(into, now_us)
    into.last_us = max(into.last_us, gone.last_us)
    into.before += gone.before
    into.packet_events += gone.packet_events
    into.mass += gone.mass
    into.left += into.x - x
    into.right += into.x - x
    into.top += into.y - y
    into.bottom += into.y - y
    into.extent_x = min(max(abs(into.x - gone.x) + gone.extent_x, into.extent_x), into.half_width)
    into.extent_y = min(max(abs(into.y - gone.y) + gone.extent_y, into.extent_y), into.half_height)
    set_mixing(into)


@step
def _second_survives(rules: Any, first: Any, second: Any) -> Any:
    """Whether the cluster that was seeded later survives: it does if it became visible first or, with a
    visible rate, has more mass; of two invisible clusters, the one seeded first survives."""
    if first.track_id < 0 or second.track_id < 0:
        return second.track_id > first.track_id
    if rules.visible_rate_hz > 0.0:
        return second.mass > first.mass
    return second.track_id < first.track_id


@step
def _merge(state: State, i: int, j: int) -> Any:
    """Merge the live clusters i < j into one.

    Returns the index of the survivor among the live clusters, or -1 if others were removed, too.
    """
    cur = state.cursor[0]
    rules = state.rules[0]
    swap = _second_survives(rules, state.clusters[state.live[i]], state.clusters[state.live[j]])
    stays, goes = (j, i) if swap else (i, j)
    seat = state.live[stays]
    into = state.clusters[seat]
    gone = state.clusters[state.live[goes]]
    index = cur.index - 1
    if gone.track_id >= 0:
        record(state, MERGED, index, cur.last_us, state.live[goes], into.track_id)
    _blend(rules, into, gone, cur.packet_end_us)
    drop(state, goes)
    if into.track_id < 0 and missing_events(rules, into) <= 0:
        taken_over = show_if_due(state, seat, index, cur.last_us)
        if taken_over >= 0:
            drop(state, taken_over)
            return -1
    return i if stays == i else j - 1


@step
def _may_merge(rules: Any, a: Any, b: Any, now_us: int) -> Any:
    """Whether two touching windows overlap enough, and no option prevents the merge."""
    if rules.coast_us > 0 and now_us - min(a.last_us, b.last_us) >= rules.lifetime_us:
        return False  # a coasting cluster may be behind the other
    wide = min(a.half_width + b.half_width - abs(a.x - b.x), 2.0 * min(a.half_width, b.half_width))
    high = min(a.half_height + b.half_height - abs(a.y - b.y), 2.0 * min(a.half_height, b.half_height))
    smaller = 4.0 * min(a.half_width * a.half_height, b.half_width * b.half_height)
    return wide * high >= rules.merge_overlap * smaller


@njit(cache=True, nogil=True, inline="always")
def _touch(a: Any, b: Any) -> Any:
    """Whether two windows share a point."""
    return max(abs(a.x - b.x) - (a.half_width + b.half_width), abs(a.y - b.y) - (a.half_height + b.half_height)) <= 0.0


@step
def _should_merge(rules: Any, a: Any, b: Any, now_us: int) -> Any:
    """Whether to merge two clusters. Those of the paper did not touch after the last packet, so one must have new events."""
    return _may_merge(rules, a, b, now_us) if rules.full > 0 else a.packet_events + b.packet_events > 0


@step
def _partner(rules: Any, clusters: Table, live: Table, i: int, begin: int, end: int, now_us: int) -> Any:
    """Index of the first live cluster from `begin` to `end` to merge with the i-th, or -1."""
    a = clusters[live[i]]
    for j in range(begin, end):
        b = clusters[live[j]]
        if _touch(a, b) and _should_merge(rules, a, b, now_us):
            return j
    return -1


@step
def merge_overlapping(state: State) -> None:
    """Merge pairs until none is left to merge, always the pair that was seeded first."""
    cur = state.cursor[0]
    rules, clusters, live = state.rules[0], state.clusters, state.live
    now_us = cur.packet_end_us
    i = 0
    while i < cur.live - 1:
        j = _partner(rules, clusters, live, i, i + 1, cur.live, now_us)
        if j < 0:
            i += 1
            continue
        survivor = _merge(state, i, j)
        # A cluster before these two, which had no partner, may have one in the merged cluster.
        first = _partner(rules, clusters, live, survivor, 0, i, now_us) if survivor >= 0 else 0
        i = first if first >= 0 else i


@step
def close_packet(state: State, now_us: int) -> None:
    """Close the open packet at `now_us`."""
    cur = state.cursor[0]
    rules = state.rules[0]
    remove_silent(state, now_us)
    for i in range(cur.live):
        seat = state.live[i]
        if state.clusters[seat].packet_events > 0:
            measure_velocity(state, seat, cur.packet_end_us)
    if rules.full > 0:
        _update_clusters(state)
    if rules.merge_overlap <= 1.0:
        merge_overlapping(state)
    if rules.full > 0:
        _update_tracks(state, now_us)
    for i in range(cur.live):
        seat = state.live[i]
        cluster = state.clusters[seat]
        coasts = rules.coast_us > 0 and now_us - cluster.last_us >= rules.lifetime_us
        if cluster.track_id >= 0 and (cluster.packet_events > 0 or coasts):
            record(state, MOVED, cur.index - 1, cur.last_us, seat, -1)
    _finish_packet(state)


@step
def _update_clusters(state: State) -> None:
    """Options: update mass and size of clusters from the events of the packet."""
    rules = state.rules[0]
    decay = math.exp(-rules.packet_us / MASS_TAU_US)
    for i in range(state.cursor[0].live):
        cluster = state.clusters[state.live[i]]
        grow_mass(cluster, decay)
        if cluster.packet_events > 0:
            follow_size(rules, cluster)


@step
def _update_tracks(state: State, now_us: int) -> None:
    """Options: remove clusters, hide weak tracks, and show new ones."""
    cur = state.cursor[0]
    rules = state.rules[0]
    for i in range(cur.live):
        if is_weak(rules, state.clusters[state.live[i]]):
            hide_weak(state, state.live[i], now_us, now_us)
    i = 0
    while i < cur.live:
        seat = state.live[i]
        cluster = state.clusters[seat]
        taken_over = -1
        if cluster.track_id < 0 and cluster.packet_events > 0 and is_due(rules, cluster):
            taken_over = show_if_due(state, seat, cur.index - 1, cur.last_us)
            if taken_over >= 0:
                drop(state, taken_over)
        if taken_over < 0 or taken_over > i:
            i += 1


@step
def _finish_packet(state: State) -> None:
    """Account for the packet's events; with prediction, advance the clusters."""
    cur = state.cursor[0]
    rules = state.rules[0]
    moves = rules.full > 0
    if moves:
        advance(state, cur.packet_end_us, cur.packet_end_us + rules.packet_us)
    for i in range(cur.live):
        seat = state.live[i]
        cluster = state.clusters[seat]
        if cluster.packet_events > 0 or moves:
            cluster.before += cluster.packet_events
            cluster.packet_events = 0
            if moves:
                set_room(cluster)
            else:
                set_steps(cluster)
            again = events_within(rules, cluster)
            if cluster.track_id < 0:
                again = min(again, max(0, missing_events(rules, cluster)))
            if again > 0:
                cluster.check_at = again
            else:
                check(state, seat, cur.index - 1, cur.last_us)


@step
def open_packet(state: State, t_us: int) -> None:
    """Close the packets before the one that holds `t_us`; in silent packets, clusters can only end or coast."""
    cur = state.cursor[0]
    rules = state.rules[0]
    if cur.packet_end_us == -NEVER_US:
        cur.packet_end_us = t_us + rules.packet_us
        return
    close_packet(state, cur.packet_end_us)
    silent = (t_us - cur.packet_end_us) // rules.packet_us
    if silent > 0:
        begin_us = cur.packet_end_us
        cur.packet_end_us += silent * rules.packet_us
        if rules.full > 0:
            _hide_weak_ones(state, begin_us)
        remove_silent(state, cur.packet_end_us)
        if rules.full > 0:
            _coast(state, begin_us)
    cur.packet_end_us += rules.packet_us
    cur.closed = cur.records


@step
def _hide_weak_ones(state: State, begin_us: int) -> None:
    """Options: hide clusters that become too weak in the silent packets from `begin_us` on."""
    cur = state.cursor[0]
    decay = math.exp(-(cur.packet_end_us - begin_us) / MASS_TAU_US)
    for i in range(cur.live):
        hide_weak(state, state.live[i], begin_us, cur.packet_end_us)
        grow_mass(state.clusters[state.live[i]], decay)


@step
def _coast(state: State, begin_us: int) -> None:
    """Options: with prediction, advance the clusters over the silent packets and the next one."""
    cur = state.cursor[0]
    advance(state, begin_us + state.rules[0].packet_us, cur.packet_end_us + state.rules[0].packet_us)
    for i in range(cur.live):
        check(state, state.live[i], cur.index - 1, cur.last_us)
