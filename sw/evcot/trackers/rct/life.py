# SPDX-License-Identifier: Apache-2.0
"""Creation and removal of clusters."""

from __future__ import annotations

from typing import Any

from ..._numba_private import njit, step
from .find import register, registered_for, take_seat, unregister
from .records import LOST, record
from .size import start_size
from .state import NEVER_US, State
from .visible import missing_events, show_if_due

__all__ = ["check", "drop", "note_ends_of_life", "remove_silent", "seed"]


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
