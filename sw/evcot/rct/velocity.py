# SPDX-License-Identifier: Apache-2.0
"""Velocity, from the places at the ends of packets: event times are too close together to divide by."""

from __future__ import annotations

from typing import Any

from numba import njit

from .state import NEVER_US, Rules

__all__ = ["measure_velocity"]


@njit(cache=True, nogil=True)
def measure_velocity(rules: Rules, cluster: Any, now_us: int) -> None:
    """Displacement since the last packet that brought events, mixed like a location."""
    if cluster.from_us != NEVER_US:
        elapsed_s = 1e-6 * (now_us - cluster.from_us)
        keep = 1.0 - rules.velocity_alpha
        cluster.velocity_x = keep * cluster.velocity_x + rules.velocity_alpha * ((cluster.x - cluster.from_x) / elapsed_s)
        cluster.velocity_y = keep * cluster.velocity_y + rules.velocity_alpha * ((cluster.y - cluster.from_y) / elapsed_s)
    cluster.from_x = cluster.x
    cluster.from_y = cluster.y
    cluster.from_us = now_us
