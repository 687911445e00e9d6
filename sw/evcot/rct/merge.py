# SPDX-License-Identifier: Apache-2.0
"""Clusters that overlap become one."""

from __future__ import annotations

from typing import Any

from numba import njit

from .life import drop
from .records import MERGED, record, show
from .state import Rules, State

__all__ = ["merge_overlapping"]


@njit(cache=True, nogil=True)
def _merge(rules: Rules, state: State, i: int, j: int) -> int:
    """Merge the live clusters i < j: the one that became visible first stays; of two invisible ones, the one seeded first.

    Returns where the one that stays then stands among the live ones.
    """
    cur = state.cursor[0]
    a = state.clusters[state.live[i]].track_id
    b = state.clusters[state.live[j]].track_id
    stays, goes = (j, i) if b >= 0 and (a < 0 or b < a) else (i, j)
    slot = state.live[stays]
    into = state.clusters[slot]
    gone = state.clusters[state.live[goes]]
    index = cur.index - 1
    if gone.track_id >= 0:
        record(rules, state, MERGED, index, cur.last_us, state.live[goes], into.track_id)
    own = into.before + into.packet_events
    other = gone.before + gone.packet_events
    total = own + other
    into.x = (into.x * own + gone.x * other) / total
    into.y = (into.y * own + gone.y * other) / total
    into.velocity_x = (into.velocity_x * own + gone.velocity_x * other) / total
    into.velocity_y = (into.velocity_y * own + gone.velocity_y * other) / total
    into.from_x = into.x
    into.from_y = into.y
    into.from_us = cur.packet_end_us
    into.last_us = max(into.last_us, gone.last_us)
    into.before += gone.before
    into.packet_events += gone.packet_events
    if into.track_id < 0 and total >= rules.visible_events:
        show(rules, state, slot, index, cur.last_us)
    drop(rules, state, goes)
    return i if stays == i else j - 1


@njit(cache=True, nogil=True)
def _overlap(rules: Rules, state: State, i: int, j: int) -> Any:
    """Whether the windows of two live clusters share a point. None did after the last packet: one must have moved since."""
    a = state.clusters[state.live[i]]
    b = state.clusters[state.live[j]]
    reach_px = 2.0 * rules.radius_px
    return abs(a.x - b.x) <= reach_px and abs(a.y - b.y) <= reach_px and a.packet_events + b.packet_events > 0


@njit(cache=True, nogil=True)
def merge_overlapping(rules: Rules, state: State) -> None:
    """Merge until no two windows share a point, always the two that were seeded first."""
    cur = state.cursor[0]
    i = 0
    while i < cur.live - 1:
        for j in range(i + 1, cur.live):
            if _overlap(rules, state, i, j):
                survivor = _merge(rules, state, i, j)
                # Of the clusters before these two, which overlapped nobody, one may overlap what came of them.
                for k in range(i):
                    if _overlap(rules, state, k, survivor):
                        i = k
                        break
                break
        else:
            i += 1
