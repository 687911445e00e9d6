# SPDX-License-Identifier: Apache-2.0
"""Merging of overlapping clusters."""

from __future__ import annotations

from typing import Any

from ..._numba_private import njit, step
from .life import drop
from .motion import jump
from .records import MERGED, record
from .size import set_mixing
from .state import State, Table
from .visible import missing_events, show_if_due

__all__ = ["merge_overlapping"]


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
