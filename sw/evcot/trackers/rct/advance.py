# SPDX-License-Identifier: Apache-2.0
"""Prediction: between packets, clusters advance with their estimated velocity, with or without events."""

from __future__ import annotations

import math
from typing import Any

from ..._numba_private import step
from .state import State

__all__ = ["advance"]

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
