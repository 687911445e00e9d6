# SPDX-License-Identifier: Apache-2.0
"""How a cluster moves: its update by an event, its velocity, and its prediction between packets."""

from __future__ import annotations

import math
from typing import Any

from ..._numba_private import njit, step
from .state import NEVER_US, State

__all__ = ["EXTENT_QUANTILE", "advance", "jump", "measure_velocity", "move", "pull_extent", "pull_size"]


_TRUSTED_MIN = 5  # positions after which a velocity is trusted; with regression over many positions, half of these
# Time constant with which a silent cluster loses its velocity, in `coast_us`: hidden objects turn or stop.
# Tuned on the validation sets of docs/evaluation.md.
_FRICTION_COASTS = 2.0


@step
def _shift(cluster: Any, dx: float, dy: float) -> None:
    """Shift a cluster and its box."""
    cluster.x += dx
    cluster.y += dy
    cluster.left += dx
    cluster.right += dx
    cluster.top += dy
    cluster.bottom += dy


@step
def advance(state: State, begin_us: int, end_us: int) -> None:
    """Advance every cluster with a reliable velocity from `begin_us` to `end_us`, within the sensor.

    Where clusters may coast, the velocity decays, v exp(-silence / tau), from the cluster's last event on.
    """
    rules = state.rules[0]
    if rules.predict == 0.0:
        return
    trusted = max(_TRUSTED_MIN, rules.path_points // 2)
    for i in range(state.cursor[0].live):
        cluster = state.clusters[state.live[i]]
        if cluster.measured < trusted:
            continue
        seconds = 1e-6 * (end_us - begin_us)
        tau_us = _FRICTION_COASTS * rules.coast_us
        if tau_us > 0.0:
            after = math.exp(-max(0, end_us - cluster.last_us) / tau_us)
            before = math.exp(-max(0, begin_us - cluster.last_us) / tau_us)
            seconds = 1e-6 * tau_us * (before - after)
        dx = rules.predict * cluster.velocity_x * seconds
        dy = rules.predict * cluster.velocity_y * seconds
        if rules.width > 0.0:
            dx = min(max(cluster.x + dx, 0.0), rules.width - 1.0) - cluster.x
            dy = min(max(cluster.y + dy, 0.0), rules.height - 1.0) - cluster.y
        _shift(cluster, dx, dy)


# Share of events beyond each side of the extent that is reported without a box: wide enough for outlines, and few stray events
# reach it.
EXTENT_QUANTILE = 0.05


@njit(cache=True, nogil=True, inline="always")
def pull_extent(cluster: Any, u: float, v: float) -> None:
    """Update the extent with an event at distances u, v from the centre: beyond it outwards, else inwards; the steps balance
    where the share `EXTENT_QUANTILE` lies beyond each side."""
    both = 2.0 * EXTENT_QUANTILE
    cluster.extent_x = max(cluster.extent_x + cluster.step_x * ((1.0 if u > cluster.extent_x else 0.0) - both), 0.0)
    cluster.extent_y = max(cluster.extent_y + cluster.step_y * ((1.0 if v > cluster.extent_y else 0.0) - both), 0.0)


@njit(cache=True, nogil=True, inline="always")
def pull_size(options: Any, cluster: Any, x: float, y: float, u: float, v: float) -> None:
    """Update the cluster's spread and size with an event in the window or its surround, at distances u, v from the centre."""
    if options.birth_spread_px > 0.0:
        mix = cluster.mix
        keep = 1.0 - mix
        cluster.deviation_x = keep * cluster.deviation_x + mix * u
        cluster.deviation_y = keep * cluster.deviation_y + mix * v
    if options.box_quantile > 0.0:
        # A side steps outwards for an event beyond it and inwards for any other; the steps balance at its quantile.
        low = options.box_quantile
        high = 1.0 - low
        cluster.left += cluster.step_x * (low - (1.0 if x < cluster.left else 0.0))
        cluster.right += cluster.step_x * (high - (1.0 if x < cluster.right else 0.0))
        cluster.top += cluster.step_y * (low - (1.0 if y < cluster.top else 0.0))
        cluster.bottom += cluster.step_y * (high - (1.0 if y < cluster.bottom else 0.0))
    else:
        pull_extent(cluster, u, v)


@njit(cache=True, nogil=True, inline="always")
def move(options: Any, cluster: Any, x: float, y: float, u: float, v: float) -> None:
    """Move the centre with an event in the window: to the mixed mean, or to the middle of the box."""
    pull_size(options, cluster, x, y, u, v)
    if options.box_quantile > 0.0:
        cluster.x = 0.5 * (cluster.left + cluster.right)
        cluster.y = 0.5 * (cluster.top + cluster.bottom)
    else:
        cluster.x = (1.0 - options.alpha) * cluster.x + options.alpha * x
        cluster.y = (1.0 - options.alpha) * cluster.y + options.alpha * y


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
