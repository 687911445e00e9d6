# SPDX-License-Identifier: Apache-2.0
"""Update of a cluster by an event, with options."""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from .state import ALPHAS, Table, choice

__all__ = ["move", "pull_extent", "pull_size"]

_BOX = choice("centre", "box")


@njit(cache=True, nogil=True, inline="always")
def _mixing(rules: Any, alphas: Table, elapsed_us: Any) -> Any:
    """alpha, or 1 - exp(-dt / tau)."""
    if rules.alpha_tau_us == 0.0:
        return rules.alpha
    if elapsed_us < ALPHAS:
        return alphas[elapsed_us]
    return -math.expm1(-elapsed_us / rules.alpha_tau_us)


@njit(cache=True, nogil=True, inline="always")
def pull_extent(rules: Any, cluster: Any, u: float, v: float) -> None:
    """Update the extent with an event at distances u, v from the centre: beyond it outwards, else inwards; the steps balance
    where the share of `box_quantile` lies beyond each side."""
    both = 2.0 * rules.box_quantile
    cluster.extent_x = max(cluster.extent_x + cluster.step_x * ((1.0 if u > cluster.extent_x else 0.0) - both), 0.0)
    cluster.extent_y = max(cluster.extent_y + cluster.step_y * ((1.0 if v > cluster.extent_y else 0.0) - both), 0.0)


@njit(cache=True, nogil=True, inline="always")
def pull_size(rules: Any, cluster: Any, x: float, y: float, where: Any) -> None:
    """Update the cluster's size, direction and spread with an event in the window or its surround."""
    if rules.shaped > 0:
        dx, dy, u, v = where
        in_middle_x = 1.0 if 2.0 * u < cluster.deviation_x else 0.0
        in_middle_y = 1.0 if 2.0 * v < cluster.deviation_y else 0.0
        mix = cluster.mix
        keep = 1.0 - mix
        cluster.deviation_x = keep * cluster.deviation_x + mix * u
        cluster.deviation_y = keep * cluster.deviation_y + mix * v
        cluster.moment_xx = keep * cluster.moment_xx + mix * (dx * dx)
        cluster.moment_yy = keep * cluster.moment_yy + mix * (dy * dy)
        cluster.middle_x = keep * cluster.middle_x + mix * in_middle_x
        cluster.middle_y = keep * cluster.middle_y + mix * in_middle_y
        cluster.moment_xy = keep * cluster.moment_xy + mix * (dx * dy)
    if rules.boxed > 0:
        # A side steps outwards for an event beyond it and inwards for any other; the steps balance at its quantile.
        low = rules.box_quantile
        high = 1.0 - low
        cluster.left += cluster.step_x * (low - (1.0 if x < cluster.left else 0.0))
        cluster.right += cluster.step_x * (high - (1.0 if x < cluster.right else 0.0))
        cluster.top += cluster.step_y * (low - (1.0 if y < cluster.top else 0.0))
        cluster.bottom += cluster.step_y * (high - (1.0 if y < cluster.bottom else 0.0))
    else:
        pull_extent(rules, cluster, abs(x - cluster.x), abs(y - cluster.y))


@njit(cache=True, nogil=True, inline="always")
def move(rules: Any, alphas: Table, cluster: Any, x: float, y: float, where: Any, elapsed_us: Any) -> None:
    """Move the centre with an event in the window: to the mixed mean, or to the middle of the box."""
    pull_size(rules, cluster, x, y, where)
    if rules.centre == _BOX:
        cluster.x = 0.5 * (cluster.left + cluster.right)
        cluster.y = 0.5 * (cluster.top + cluster.bottom)
    else:
        alpha = _mixing(rules, alphas, elapsed_us)
        cluster.x = (1.0 - alpha) * cluster.x + alpha * x
        cluster.y = (1.0 - alpha) * cluster.y + alpha * y
