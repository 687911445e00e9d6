# SPDX-License-Identifier: Apache-2.0
"""What the algorithm does after the events of a packet."""

from __future__ import annotations

from numba import njit

from .life import check, remove_silent
from .merge import merge_overlapping
from .records import MOVED, record
from .state import NEVER_US, Rules, State
from .velocity import measure_velocity

__all__ = ["close_packet", "open_packet"]


@njit(cache=True, nogil=True)
def close_packet(rules: Rules, state: State, now_us: int) -> None:
    """Close the open packet; time has passed until `now_us`."""
    cur = state.cursor[0]
    remove_silent(rules, state, now_us)
    for i in range(cur.live):
        cluster = state.clusters[state.live[i]]
        if cluster.packet_events > 0:
            measure_velocity(rules, cluster, cur.packet_end_us)
    merge_overlapping(rules, state)
    for i in range(cur.live):
        slot = state.live[i]
        cluster = state.clusters[slot]
        if cluster.packet_events > 0:
            if cluster.track_id >= 0:
                record(rules, state, MOVED, cur.index - 1, cur.last_us, slot, -1)
            cluster.before += cluster.packet_events
            cluster.packet_events = 0
            check(rules, state, slot, cur.index - 1, cur.last_us)


@njit(cache=True, nogil=True)
def open_packet(rules: Rules, state: State, t_us: int) -> None:
    """Close the packets before the one that holds `t_us`: in the silent ones among them, clusters can only end."""
    cur = state.cursor[0]
    if cur.packet_end_us == -NEVER_US:
        cur.packet_end_us = t_us + rules.packet_us
        return
    close_packet(rules, state, cur.packet_end_us)
    silent = (t_us - cur.packet_end_us) // rules.packet_us
    if silent > 0:
        cur.packet_end_us += silent * rules.packet_us
        remove_silent(rules, state, cur.packet_end_us)
    cur.packet_end_us += rules.packet_us
    cur.closed = cur.records
