# SPDX-License-Identifier: Apache-2.0
"""What is known of a cluster, and its records.

Size and shape of windows change between packets only. The tail of the buffer of records belongs to the open packet.
"""

from __future__ import annotations

from typing import Any

from ..._numba_private import step
from ...tracks.log import Kind
from .motion import EXTENT_QUANTILE
from .state import State

__all__ = [
    "BORN",
    "LOST",
    "MASS_TAU_US",
    "MERGED",
    "MOVED",
    "follow_size",
    "record",
    "set_mixing",
    "set_steps",
    "start_size",
    "weight",
]

# Step of the sides of box and extent, as a share of half the window's side: tuned on the validation sets of docs/evaluation.md.
_STEP = 0.02
_YOUNG_STEP = 0.1  # the same for the first ten events: a box then has half its size after ten
# Mixing factor of the deviations: a mean over a hundred events, and over five for young clusters.
_MIX, _YOUNG_MIX = 0.01, 0.2
_SCALES = (0.05, 20.0)  # limits of the perspective's scale: windows stay finite at the vanishing row
_BOX_MIN_PX = 1.0  # a pixel
# A window of dynamic size is this many times as large as a filled object: above 1, so that it sees events beyond its box
# and can grow; below 2, so that it does not hold a neighbour.
_MARGIN = 1.4
_GROWTH = (1.0 / 3.0, 4.0)  # limits of a dynamic size, in sizes of a new window


@step
def _scale(rules: Any, y: float) -> Any:
    """Scale of sizes in a row: its distance from the vanishing row over that of the reference."""
    if rules.perspective == 0:
        return 1.0
    scale = abs((y - rules.vanishing_y_px) / (rules.reference_y_px - rules.vanishing_y_px))
    return min(max(scale, _SCALES[0]), _SCALES[1])


@step
def set_mixing(cluster: Any) -> None:
    """Compute what depends on the number of events and on the window's size: mixing factor and steps."""
    young = 1.0 / max(1.0, float(cluster.before + cluster.packet_events))
    cluster.mix = max(_MIX, min(_YOUNG_MIX, 2.0 * young))
    set_steps(cluster)


@step
def set_steps(cluster: Any) -> None:
    """Compute the steps of the sides: larger for the first events of a cluster."""
    young = 1.0 / max(1.0, float(cluster.before + cluster.packet_events))
    size = max(_STEP, min(_YOUNG_STEP, young))
    cluster.step_x = size * cluster.half_width
    cluster.step_y = size * cluster.half_height


@step
def object_box(rules: Any, cluster: Any) -> Any:
    """Width and height of the object: of its box, or of its events' extent around the centre."""
    if rules.box_quantile > 0.0:
        return max(cluster.right - cluster.left, _BOX_MIN_PX), max(cluster.bottom - cluster.top, _BOX_MIN_PX)
    return max(2.0 * cluster.extent_x, _BOX_MIN_PX), max(2.0 * cluster.extent_y, _BOX_MIN_PX)


@step
def start_size(rules: Any, cluster: Any) -> None:
    """Initialise a new cluster's window and event statistics."""
    cluster.half_width = rules.radius_px * _scale(rules, cluster.y)
    cluster.half_height = cluster.half_width * rules.aspect
    cluster.deviation_x = 0.0
    cluster.deviation_y = 0.0
    cluster.left = cluster.right = cluster.x
    cluster.top = cluster.bottom = cluster.y
    cluster.extent_x = 0.0
    cluster.extent_y = 0.0
    set_mixing(cluster)


@step
def follow_size(rules: Any, cluster: Any) -> None:
    """Update the window after a packet: by perspective and, with dynamic size, by its events once the cluster is visible."""
    if rules.perspective > 0 or rules.dynamic_size > 0:
        half_width = rules.radius_px * _scale(rules, cluster.y)
        if rules.dynamic_size > 0:
            half_width = _dynamic(rules, cluster, half_width) if cluster.track_id >= 0 else cluster.half_width
        cluster.half_width = half_width
        cluster.half_height = half_width * rules.aspect
    set_mixing(cluster)


@step
def _dynamic(rules: Any, cluster: Any, new_half_width: float) -> Any:
    """Half the width of the window around a visible object, by the larger of the object's sides."""
    width, height = object_box(rules, cluster)
    quantile = rules.box_quantile if rules.box_quantile > 0.0 else EXTENT_QUANTILE
    half_width = 0.5 * _MARGIN / (1.0 - 2.0 * quantile) * max(width, height / rules.aspect)
    return min(max(half_width, _GROWTH[0] * new_half_width), _GROWTH[1] * new_half_width)


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
