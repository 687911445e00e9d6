# SPDX-License-Identifier: Apache-2.0
"""Creation and removal of clusters, and their visibility: when a cluster becomes a track, and when it ceases to be one."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..._numba_private import njit, step
from .find import register, registered_for, take_seat, unregister
from .records import BORN, LOST, MASS_TAU_US, record, start_size, weight
from .state import NEVER_US, State

__all__ = [
    "check",
    "drop",
    "grow_mass",
    "hide_weak",
    "is_due",
    "is_weak",
    "missing_events",
    "note_ends_of_life",
    "remove_silent",
    "seed",
    "show_if_due",
]

_LONG = 1 << 40  # events
# Share of the rate below which a track is hidden: noise of the estimated rate does not end it.
_HIDDEN_SHARE = 0.2
# Distance at which a new cluster continues a coasting track: the error of a prediction over 50 ms.
_COAST_REACH_PX = 20.0


@njit(cache=True, nogil=True, inline="always")
def missing_events(rules: Any, cluster: Any) -> Any:
    """Number of events a cluster needs to become visible; very large with rates, which are checked per packet."""
    return rules.visible_events - cluster.before - cluster.packet_events if rules.visible_rate_hz == 0.0 else _LONG


@step
def grow_mass(cluster: Any, decay: float) -> None:
    """Update the mass after a packet: it decays, and each event adds 1."""
    cluster.mass = cluster.mass * decay + cluster.packet_events


@step
def is_due(rules: Any, cluster: Any) -> Any:
    """Whether a cluster meets the conditions to become visible."""
    return weight(rules, cluster) >= 1.0 and cluster.deviation_x + cluster.deviation_y >= rules.birth_spread_px


@step
def is_weak(rules: Any, cluster: Any) -> Any:
    """Whether a track no longer meets the conditions to stay visible."""
    return rules.visible_rate_hz > 0.0 and cluster.track_id >= 0 and weight(rules, cluster) < _HIDDEN_SHARE


@step
def show_if_due(state: State, seat: int, index: int, t_us: int) -> Any:
    """Make an invisible cluster that meets the conditions a track: a new one, or one that coasted nearby.

    Returns the index among the live clusters of the one whose track was taken over and which must now be dropped, or -1.
    """
    rules = state.rules[0]
    cluster = state.clusters[seat]
    if not is_due(rules, cluster):
        return -1
    lost = _coasting_nearby(state, seat, t_us) if rules.coast_us > 0 else -1
    if lost >= 0:
        gone = state.clusters[state.live[lost]]
        cluster.track_id = gone.track_id
        cluster.before += gone.before
        cluster.velocity_x = gone.velocity_x
        cluster.velocity_y = gone.velocity_y
    else:
        cur = state.cursor[0]
        cluster.track_id = cur.births
        cur.births += 1
        record(state, BORN, index, t_us, seat, -1)
    return lost


@step
def _coasting_nearby(state: State, seat: int, now_us: int) -> Any:
    """The nearest visible cluster without events for a lifetime whose predicted position is within reach, or -1."""
    rules = state.rules[0]
    cluster = state.clusters[seat]
    nearest = -1
    nearest_px = _COAST_REACH_PX
    for i in range(state.cursor[0].live):
        other = state.clusters[state.live[i]]
        if other.track_id >= 0 and now_us - other.last_us >= rules.lifetime_us:
            distance_px = max(abs(other.x - cluster.x), abs(other.y - cluster.y))
            if distance_px <= nearest_px:
                nearest_px = distance_px
                nearest = i
    return nearest


@step
def _falls_at(rules: Any, level: float, begin_us: int, end_us: int) -> Any:
    """The end of the packet in which a level that decays like mass falls below `_HIDDEN_SHARE`, if that is not after `end_us`.

    `begin_us` if it is already below.
    """
    if level < _HIDDEN_SHARE:
        return begin_us
    if begin_us == end_us:
        return NEVER_US
    packets = np.int64(MASS_TAU_US / rules.packet_us * math.log(level / _HIDDEN_SHARE)) + 1
    return begin_us + packets * rules.packet_us


@step
def hide_weak(state: State, seat: int, begin_us: int, end_us: int) -> None:
    """End a track whose rate falls below its share of the threshold in the silence from `begin_us` to `end_us`.

    Its cluster continues to exist, invisible.
    """
    rules = state.rules[0]
    cluster = state.clusters[seat]
    if rules.visible_rate_hz == 0.0 or cluster.track_id < 0:
        return
    at_us = _falls_at(rules, weight(rules, cluster), begin_us, end_us)
    if rules.coast_us > 0:
        at_us = max(at_us, cluster.last_us + rules.lifetime_us + rules.coast_us)
    if at_us <= end_us:
        record(state, LOST, state.cursor[0].index, at_us, seat, -1)
        cluster.track_id = -1


@step
def seed(state: State, x: float, y: float, t_us: int) -> Any:
    """Create a cluster at an event, in the lowest free slot. Returns its seat."""
    cur = state.cursor[0]
    seat = take_seat(state)
    slot = 0
    while state.taken[slot] > 0:
        slot += 1
    state.taken[slot] = 1
    cluster = state.clusters[seat]
    cluster.slot = slot
    cluster.x = x
    cluster.y = y
    cluster.velocity_x = 0.0
    cluster.velocity_y = 0.0
    cluster.from_us = NEVER_US
    cluster.last_us = t_us
    cluster.due_us = -NEVER_US
    cluster.before = 0
    cluster.packet_events = 1
    cluster.places = 0
    cluster.measured = 0
    cluster.mass = 0.0
    cluster.track_id = -1
    state.live[cur.live] = seat
    cur.live += 1
    start_size(state.rules[0], cluster)
    register(state, seat)
    return seat


@step
def check(state: State, seat: int, index: int, t_us: int) -> None:
    """Checks not needed for every event: whether the cluster has become visible, and whether it must be re-registered."""
    cluster = state.clusters[seat]
    again = registered_for(state, seat)
    if cluster.track_id < 0:
        missing = missing_events(state.rules[0], cluster)
        if missing <= 0:
            taken_over = show_if_due(state, seat, index, t_us)
            if taken_over >= 0:
                drop(state, taken_over)
        else:
            again = min(again, missing)
    cluster.check_at = cluster.packet_events + again


@step
def drop(state: State, i: int) -> None:
    """Remove the i-th live cluster."""
    cur = state.cursor[0]
    seat = state.live[i]
    unregister(state, seat)
    state.taken[state.clusters[seat].slot] = 0
    cur.live -= 1
    for k in range(i, cur.live):
        state.live[k] = state.live[k + 1]


@njit(cache=True, nogil=True, inline="always")
def _end_us(rules: Any, cluster: Any) -> Any:
    return cluster.last_us + rules.lifetime_us + (rules.coast_us if cluster.track_id >= 0 else 0)


@step
def note_ends_of_life(state: State, t_us: int) -> None:
    """Record, for clusters whose lifetime has passed, the next event as the first one after their end."""
    cur = state.cursor[0]
    rules = state.rules[0]
    cur.next_due_us = t_us + rules.lifetime_us  # for clusters that take an event from now on
    for i in range(cur.live):
        cluster = state.clusters[state.live[i]]
        if cluster.due_us != cluster.last_us:
            end_us = _end_us(rules, cluster)
            if end_us <= t_us:
                cluster.due_index = cur.index
                cluster.due_us = cluster.last_us
            else:
                cur.next_due_us = min(cur.next_due_us, end_us)


@step
def remove_silent(state: State, now_us: int) -> None:
    """Remove clusters without an event for a lifetime; visible ones may coast for some time before."""
    cur = state.cursor[0]
    rules = state.rules[0]
    i = 0
    while i < cur.live:
        seat = state.live[i]
        cluster = state.clusters[seat]
        end_us = _end_us(rules, cluster)
        if end_us <= now_us:
            if cluster.track_id >= 0:
                index = cluster.due_index if cluster.due_us == cluster.last_us else cur.index
                record(state, LOST, index, end_us, seat, -1)
            drop(state, i)
        else:
            i += 1
