# SPDX-License-Identifier: Apache-2.0
"""Processing at the end of a packet."""

from __future__ import annotations

import math

from ..._numba_private import step
from .find import events_within, set_room
from .life import check, drop, remove_silent
from .merge import merge_overlapping
from .motion import advance, measure_velocity
from .records import MASS_TAU_US, MOVED, record
from .size import follow_size, set_steps
from .state import NEVER_US, State
from .visible import grow_mass, hide_weak, is_due, is_weak, missing_events, show_if_due

__all__ = ["close_packet", "open_packet"]


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
