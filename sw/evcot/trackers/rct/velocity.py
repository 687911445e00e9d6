# SPDX-License-Identifier: Apache-2.0
"""Velocity estimation from the positions at the ends of packets: event times are too close together to divide by."""

from __future__ import annotations

from typing import Any

from ..._numba_private import step
from .state import NEVER_US, State

__all__ = ["jump", "measure_velocity"]

_REGRESSION_MIN = 3  # positions: a line through two has no error to average


@step
def measure_velocity(state: State, seat: int, now_us: int) -> None:
    """Update the velocity after a packet in which the cluster took events."""
    rules = state.rules[0]
    cluster = state.clusters[seat]
    if rules.path_points > 0:
        place = state.paths[cluster.slot, cluster.places % rules.path_points]
        place.t_us = cluster.last_us
        place.x = cluster.x
        place.y = cluster.y
        cluster.places += 1
    cluster.measured += 1
    if rules.path_points >= _REGRESSION_MIN:
        _regress(state, seat)
    else:
        _filter(rules, cluster, now_us)
    cluster.from_x = cluster.x
    cluster.from_y = cluster.y
    cluster.from_us = now_us


@step
def _filter(rules: Any, cluster: Any, now_us: int) -> None:
    """Displacement since the last packet with events, low-pass filtered like a location."""
    if cluster.from_us != NEVER_US:
        elapsed_s = 1e-6 * (now_us - cluster.from_us)
        keep = 1.0 - rules.velocity_alpha
        cluster.velocity_x = keep * cluster.velocity_x + rules.velocity_alpha * ((cluster.x - cluster.from_x) / elapsed_s)
        cluster.velocity_y = keep * cluster.velocity_y + rules.velocity_alpha * ((cluster.y - cluster.from_y) / elapsed_s)


@step
def _regress(state: State, seat: int) -> None:
    """Slope of the least-squares line through the last positions: sum dt dx / sum dt dt, about their means."""
    cluster = state.clusters[seat]
    size = state.paths.shape[1]
    n = min(cluster.measured, size)
    if n < _REGRESSION_MIN:
        return
    path = state.paths[cluster.slot]
    sum_t = sum_x = sum_y = sum_tt = sum_tx = sum_ty = 0.0
    at = (cluster.places - n) % size
    for _ in range(n):
        place = path[at]
        at = at + 1 if at + 1 < size else 0
        t_s = 1e-6 * (place.t_us - cluster.last_us)
        x = place.x - cluster.x
        y = place.y - cluster.y
        sum_t += t_s
        sum_x += x
        sum_y += y
        sum_tt += t_s * t_s
        sum_tx += t_s * x
        sum_ty += t_s * y
    spread = sum_tt - sum_t * sum_t / n
    if spread > 0.0:
        cluster.velocity_x = (sum_tx - sum_t * sum_x / n) / spread
        cluster.velocity_y = (sum_ty - sum_t * sum_y / n) / spread


@step
def jump(cluster: Any, now_us: int) -> None:
    """Restart the velocity estimation after the cluster was moved by other means than events."""
    cluster.from_x = cluster.x
    cluster.from_y = cluster.y
    cluster.from_us = now_us
    cluster.measured = 0
