# SPDX-License-Identifier: Apache-2.0
"""Update of a cluster by an event, with options."""

from __future__ import annotations

from typing import Any

from numba import njit

__all__ = ["EXTENT_QUANTILE", "move", "pull_extent", "pull_size"]

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
