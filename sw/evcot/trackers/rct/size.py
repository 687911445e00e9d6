# SPDX-License-Identifier: Apache-2.0
"""Size, shape and direction of windows. They change between packets only."""

from __future__ import annotations

import math
from typing import Any

from ..._numba_private import step
from .state import choice

__all__ = ["follow_size", "object_box", "set_reach", "set_steps", "start_size"]

_FIXED, _QUANTILE = choice("size", "fixed"), choice("size", "quantile")
_ROW, _POINT = choice("perspective", "row"), choice("perspective", "point")
_SCALES = (0.05, 20.0)
_ROUND = 0.1  # anisotropy below which a cluster has no direction
_YOUNG_MIX, _YOUNG_STEP = 0.2, 0.1  # of the first events
_TURNED = 1.5  # half a turned box's side, in standard deviations: from a filled rectangle's 1.7 to an outline's 1.2
_BOX_MIN_PX = 1.0


@step
def _scale(rules: Any, x: float, y: float) -> Any:
    """Scale of sizes at a position: its distance from the vanishing point over that of the reference."""
    across, down = x - rules.vanishing_x_px, y - rules.vanishing_y_px
    whole_across, whole_down = rules.reference_x_px - rules.vanishing_x_px, rules.reference_y_px - rules.vanishing_y_px
    if rules.perspective == _ROW:
        scale = abs(down / whole_down)
    elif rules.perspective == _POINT:
        scale = math.hypot(across, down) / math.hypot(whole_across, whole_down)
    else:
        return 1.0
    return min(max(scale, _SCALES[0]), _SCALES[1])


@step
def set_reach(rules: Any, cluster: Any) -> None:
    """Compute half the sides of the upright rectangle around the window, and the mixing factors that depend on its size."""
    cos, sin = abs(cluster.cos), abs(cluster.sin)
    cluster.reach_x = cos * cluster.half_width + sin * cluster.half_height
    cluster.reach_y = sin * cluster.half_width + cos * cluster.half_height
    young = 1.0 / max(1.0, float(cluster.before + cluster.packet_events))
    cluster.mix = max(rules.size_alpha, min(_YOUNG_MIX, 2.0 * young))
    set_steps(rules, cluster)


@step
def set_steps(rules: Any, cluster: Any) -> None:
    """Compute the steps of the sides: larger for the first events of a cluster."""
    young = 1.0 / max(1.0, float(cluster.before + cluster.packet_events))
    size = max(rules.box_alpha, min(_YOUNG_STEP, young))
    cluster.step_x = size * cluster.half_width
    cluster.step_y = size * cluster.half_height


@step
def object_box(rules: Any, cluster: Any) -> Any:
    """Width, height and angle of the object: its events' extent, in which all but the share `box_quantile` of them beyond each
    side lie; for windows that turn, by their second moments along the window's axes."""
    if rules.angle > 0:
        cos, sin = cluster.cos, cluster.sin
        across = 2.0 * cos * sin * cluster.moment_xy
        along_width = cos * cos * cluster.moment_xx + across + sin * sin * cluster.moment_yy
        along_height = sin * sin * cluster.moment_xx - across + cos * cos * cluster.moment_yy
        width = 2.0 * _TURNED * math.sqrt(max(along_width, 0.0))
        height = 2.0 * _TURNED * math.sqrt(max(along_height, 0.0))
        return max(width, _BOX_MIN_PX), max(height, _BOX_MIN_PX), math.atan2(sin, cos)
    if rules.boxed > 0:
        return max(cluster.right - cluster.left, _BOX_MIN_PX), max(cluster.bottom - cluster.top, _BOX_MIN_PX), 0.0
    return max(2.0 * cluster.extent_x, _BOX_MIN_PX), max(2.0 * cluster.extent_y, _BOX_MIN_PX), 0.0


@step
def start_size(rules: Any, cluster: Any) -> None:
    """Initialise a new cluster's window and event statistics."""
    scale = _scale(rules, cluster.x, cluster.y)
    cluster.half_width = rules.radius_px * scale
    cluster.half_height = rules.radius_px * scale * rules.aspect
    cluster.cos = 1.0
    cluster.sin = 0.0
    cluster.deviation_x = 0.0
    cluster.deviation_y = 0.0
    cluster.middle_x = 0.25
    cluster.middle_y = 0.25
    cluster.moment_xx = 0.0
    cluster.moment_xy = 0.0
    cluster.moment_yy = 0.0
    cluster.left = cluster.right = cluster.x
    cluster.top = cluster.bottom = cluster.y
    cluster.extent_x = 0.0
    cluster.extent_y = 0.0
    set_reach(rules, cluster)


@step
def follow_size(rules: Any, cluster: Any) -> None:
    """Update the window after a packet: by perspective and, once the cluster is visible, by its events."""
    scale = _scale(rules, cluster.x, cluster.y) if rules.perspective > 0 else 1.0
    if rules.size == _FIXED:
        if rules.perspective > 0:
            cluster.half_width = rules.radius_px * scale
            cluster.half_height = rules.radius_px * scale * rules.aspect
    elif cluster.track_id >= 0:
        if rules.size == _QUANTILE:
            wide, high = 0.5 * (cluster.right - cluster.left), 0.5 * (cluster.bottom - cluster.top)
        else:
            wide, high = cluster.deviation_x, cluster.deviation_y
        if not rules.free_aspect:
            wide = max(wide, high / rules.aspect)
            high = wide * rules.aspect
        low, top = rules.radius_min_px * scale, rules.radius_max_px * scale
        cluster.half_width = min(max(rules.size_ratio * wide, low), top)
        cluster.half_height = min(max(rules.size_ratio * high, low), top)
    if rules.angle > 0:
        _turn(cluster)
    set_reach(rules, cluster)


@step
def _turn(cluster: Any) -> None:
    """Turn the window to the principal axis of the second moments, if there is a distinct one."""
    apart, across = cluster.moment_xx - cluster.moment_yy, 2.0 * cluster.moment_xy
    if math.hypot(apart, across) > _ROUND * (cluster.moment_xx + cluster.moment_yy):
        angle = 0.5 * math.atan2(across, apart)
        cluster.cos = math.cos(angle)
        cluster.sin = math.sin(angle)
