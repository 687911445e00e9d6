# SPDX-License-Identifier: Apache-2.0
"""Size and shape of windows. They change between packets only."""

from __future__ import annotations

from typing import Any

from ..._numba_private import step
from .motion import EXTENT_QUANTILE

__all__ = ["follow_size", "object_box", "set_mixing", "set_steps", "start_size"]

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
