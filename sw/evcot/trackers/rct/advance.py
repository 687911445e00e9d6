# SPDX-License-Identifier: Apache-2.0
"""Prediction: between packets, clusters advance with their estimated velocity, with or without events."""

from __future__ import annotations

import math
from typing import Any

from ..._numba_private import step
from .state import State

__all__ = ["advance", "shift"]


@step
def shift(cluster: Any, dx: float, dy: float) -> None:
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

    With friction the velocity decays, v exp(-silence / tau), from the cluster's last event on.
    """
    rules = state.rules[0]
    if rules.predict == 0.0:
        return
    for i in range(state.cursor[0].live):
        cluster = state.clusters[state.live[i]]
        if cluster.measured < rules.predict_points:
            continue
        seconds = 1e-6 * (end_us - begin_us)
        tau_us = rules.friction_tau_us
        if tau_us > 0.0:
            after = math.exp(-max(0, end_us - cluster.last_us) / tau_us)
            before = math.exp(-max(0, begin_us - cluster.last_us) / tau_us)
            seconds = 1e-6 * tau_us * (before - after)
        dx = rules.predict * cluster.velocity_x * seconds
        dy = rules.predict * cluster.velocity_y * seconds
        if rules.width > 0.0:
            dx = min(max(cluster.x + dx, 0.0), rules.width - 1.0) - cluster.x
            dy = min(max(cluster.y + dy, 0.0), rules.height - 1.0) - cluster.y
        shift(cluster, dx, dy)
