# SPDX-License-Identifier: Apache-2.0
"""How clusters begin and end."""

from __future__ import annotations

from numba import njit

from .lookup import checked_after, register, unregister
from .records import LOST, record, show
from .state import NEVER_US, Rules, State

__all__ = ["check", "drop", "note_ends_of_life", "remove_silent", "seed"]


@njit(cache=True, nogil=True)
def seed(rules: Rules, state: State, x: float, y: float, t_us: int) -> int:
    """A new cluster at an event; returns its slot, the lowest that is free."""
    cur = state.cursor[0]
    slot = 0
    while state.clusters[slot].order >= 0:
        slot += 1
    cluster = state.clusters[slot]
    cluster.x = x
    cluster.y = y
    cluster.velocity_x = 0.0
    cluster.velocity_y = 0.0
    cluster.from_us = NEVER_US
    cluster.last_us = t_us
    cluster.due_us = -NEVER_US
    cluster.before = 0
    cluster.packet_events = 1
    cluster.track_id = -1
    cluster.order = cur.seeded
    cur.seeded += 1
    state.live[cur.live] = slot
    cur.live += 1
    register(rules, state.cells, state.clusters, slot)
    return slot


@njit(cache=True, nogil=True)
def check(rules: Rules, state: State, slot: int, index: int, t_us: int) -> None:
    """What need not be asked with every event: is the cluster visible by now, is it still where it was registered?"""
    cluster = state.clusters[slot]
    again = checked_after(rules, state.cells, state.clusters, slot)
    if cluster.track_id < 0:
        missing = rules.visible_events - cluster.before - cluster.packet_events
        if missing <= 0:
            show(rules, state, slot, index, t_us)
        else:
            again = min(again, missing)
    cluster.check_at = cluster.packet_events + again


@njit(cache=True, nogil=True)
def drop(rules: Rules, state: State, i: int) -> None:
    """The i-th live cluster is gone."""
    cur = state.cursor[0]
    slot = state.live[i]
    unregister(rules, state.cells, state.clusters, slot)
    state.clusters[slot].order = -1
    cur.live -= 1
    for k in range(i, cur.live):
        state.live[k] = state.live[k + 1]


@njit(cache=True, nogil=True)
def note_ends_of_life(rules: Rules, state: State, t_us: int) -> None:
    """Remember, for clusters whose life has ended by now, that the coming event is the first that finds them gone."""
    cur = state.cursor[0]
    cur.next_due_us = t_us + rules.lifetime_us  # of those that take an event from now on
    for i in range(cur.live):
        cluster = state.clusters[state.live[i]]
        if cluster.due_us != cluster.last_us:
            end_us = cluster.last_us + rules.lifetime_us
            if end_us <= t_us:
                cluster.due_index = cur.index
                cluster.due_us = cluster.last_us
            else:
                cur.next_due_us = min(cur.next_due_us, end_us)


@njit(cache=True, nogil=True)
def remove_silent(rules: Rules, state: State, now_us: int) -> None:
    """Clusters without an event for a lifetime end."""
    cur = state.cursor[0]
    i = 0
    while i < cur.live:
        slot = state.live[i]
        cluster = state.clusters[slot]
        end_us = cluster.last_us + rules.lifetime_us
        if end_us <= now_us:
            if cluster.track_id >= 0:
                index = cluster.due_index if cluster.due_us == cluster.last_us else cur.index
                record(rules, state, LOST, index, end_us, slot, -1)
            drop(rules, state, i)
        else:
            i += 1
