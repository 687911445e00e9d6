# SPDX-License-Identifier: Apache-2.0
"""The evidence that a cluster is an object, and the buffer of records, whose tail belongs to the open packet."""

from __future__ import annotations

from typing import Any

from ..._numba_private import step
from ...tracks.log import Kind
from .size import object_box
from .state import State

__all__ = ["BORN", "LOST", "MASS_TAU_US", "MERGED", "MOVED", "record", "weight"]


# Time constant of mass, the number of events that are not yet forgotten: ten packets of the paper. Shorter ones hide slow
# objects, longer ones show noise; tuned on the validation sets of docs/evaluation.md.
MASS_TAU_US = 10_000.0


@step
def weight(rules: Any, cluster: Any) -> Any:
    """The quantity that makes a cluster visible, as a multiple of its threshold.

    A constant event rate gives a mass of rate times time constant.
    """
    if rules.visible_rate_hz > 0.0:
        return cluster.mass * 1e6 / MASS_TAU_US / rules.visible_rate_hz
    return (cluster.before + cluster.packet_events) / rules.visible_events


BORN, MOVED, MERGED, LOST = int(Kind.BORN), int(Kind.MOVED), int(Kind.MERGED), int(Kind.LOST)


@step
def record(state: State, kind: int, index: int, t_us: int, seat: int, other_id: int) -> None:
    """Insert a record in order of its event index; a loss precedes the records caused by the event itself."""
    cur = state.cursor[0]
    out = state.out
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
    cluster = state.clusters[seat]
    row = out[at]
    row.t_us = t_us
    row.event_index = index
    row.kind = kind
    row.track_id = cluster.track_id
    row.slot = cluster.slot
    row.x = cluster.x
    row.y = cluster.y
    if state.rules[0].box_quantile > 0.0:
        row.radius = 0.5 * max(cluster.right - cluster.left, cluster.bottom - cluster.top, 1.0)
    else:
        row.radius = max(cluster.half_width, cluster.half_height)
    row.width, row.height = object_box(state.rules[0], cluster)
    row.angle = 0.0
    row.vx = cluster.velocity_x
    row.vy = cluster.velocity_y
    evidence = weight(state.rules[0], cluster)
    row.confidence = evidence / (evidence + 1.0)
    row.n_ev = cluster.packet_events
    row.support = cluster.before + cluster.packet_events
    row.other_id = other_id
    cur.records += 1
