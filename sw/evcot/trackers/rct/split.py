# SPDX-License-Identifier: Apache-2.0
"""Split a cluster whose events form two groups."""

from __future__ import annotations

from typing import Any

from ..._numba_private import step
from .advance import shift
from .life import seed
from .size import set_reach
from .state import State
from .velocity import jump

__all__ = ["split_apart"]


@step
def _halve(rules: Any, cluster: Any, along_x: bool, now_us: int) -> None:
    """Halve a cluster's window and event statistics along an axis, and prevent merging back for a lifetime."""
    if along_x:
        cluster.half_width = max(rules.radius_min_px, 0.95 * cluster.deviation_x)
        cluster.deviation_x = cluster.half_width / rules.size_ratio
        middle = 0.5 * (cluster.left + cluster.right)
        half = min(0.5 * (cluster.right - cluster.left), cluster.deviation_x)
        cluster.left, cluster.right = middle - half, middle + half
        cluster.extent_x = min(cluster.extent_x, cluster.deviation_x)
    else:
        cluster.half_height = max(rules.radius_min_px, 0.95 * cluster.deviation_y)
        cluster.deviation_y = cluster.half_height / rules.size_ratio
        middle = 0.5 * (cluster.top + cluster.bottom)
        half = min(0.5 * (cluster.bottom - cluster.top), cluster.deviation_y)
        cluster.top, cluster.bottom = middle - half, middle + half
        cluster.extent_y = min(cluster.extent_y, cluster.deviation_y)
    cluster.middle_x = cluster.middle_y = 0.25
    cluster.two = 0
    cluster.before = max(1, cluster.before // 2)
    cluster.mass *= 0.5
    cluster.apart_us = now_us + rules.lifetime_us
    set_reach(rules, cluster)
    jump(cluster, now_us)


@step
def _split(state: State, i: int, along_x: bool, now_us: int) -> None:
    """Split into two groups, each a mean deviation from the centre: the older cluster keeps the one ahead in the direction of
    motion or, at rest, the right or lower one."""
    rules = state.rules[0]
    old = state.clusters[state.live[i]]
    away = old.deviation_x if along_x else old.deviation_y
    dx = away * old.cos if along_x else -away * old.sin
    dy = away * old.sin if along_x else away * old.cos
    if dx * old.velocity_x + dy * old.velocity_y < 0.0:
        dx, dy = -dx, -dy
    new_seat = seed(state, old.x - dx, old.y - dy, old.last_us, old.polarity)
    old = state.clusters[state.live[i]]  # whose seat may have changed
    new = state.clusters[new_seat]
    for twin in (new, old):
        twin.half_width, twin.half_height = old.half_width, old.half_height
        twin.deviation_x, twin.deviation_y = old.deviation_x, old.deviation_y
        twin.extent_x, twin.extent_y = old.extent_x, old.extent_y
    new.cos, new.sin = old.cos, old.sin
    new.velocity_x, new.velocity_y = old.velocity_x, old.velocity_y
    new.mass = old.mass
    new.before, new.packet_events = old.before, old.packet_events - old.packet_events // 2
    old.packet_events //= 2
    new.left, new.right = old.left - dx, old.right - dx
    new.top, new.bottom = old.top - dy, old.bottom - dy
    shift(old, dx, dy)
    _halve(rules, old, along_x, now_us)
    _halve(rules, new, along_x, now_us)


@step
def split_apart(state: State, now_us: int) -> None:
    """After a packet: split visible clusters that had few events in the middle half of their longer axis for enough packets."""
    rules = state.rules[0]
    cur = state.cursor[0]
    if rules.split_share == 0.0:
        return
    for i in range(cur.live):
        seat = state.live[i]
        cluster = state.clusters[seat]
        if cluster.track_id < 0 or cluster.packet_events == 0:
            continue
        along_x = cluster.deviation_x >= cluster.deviation_y
        middle = cluster.middle_x if along_x else cluster.middle_y
        cluster.two = cluster.two + 1 if middle < rules.split_share else 0
        if cluster.two >= rules.split_packets and cur.live < len(state.live):
            _split(state, i, along_x, now_us)
