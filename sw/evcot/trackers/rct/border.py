# SPDX-License-Identifier: Apache-2.0
"""Removal of clusters whose windows leave the sensor, or whose event rate is too low, before their lifetime has passed."""

from __future__ import annotations

from typing import Any

from ..._numba_private import step
from .evidence import rate_hz
from .life import lose
from .state import NEVER_US, State
from .visible import falls_at

__all__ = ["remove_failing"]


@step
def _share_outside(rules: Any, cluster: Any) -> Any:
    """Share of the window outside the sensor, whose first pixel begins at -0.5."""
    left, right = max(cluster.x - cluster.reach_x, -0.5), min(cluster.x + cluster.reach_x, rules.width - 0.5)
    top, bottom = max(cluster.y - cluster.reach_y, -0.5), min(cluster.y + cluster.reach_y, rules.height - 0.5)
    inside = max(0.0, right - left) * max(0.0, bottom - top)
    return 1.0 - inside / (4.0 * cluster.reach_x * cluster.reach_y)


@step
def remove_failing(state: State, begin_us: int, end_us: int) -> None:
    """Remove such clusters in the silence from `begin_us`, the end of a packet, to `end_us`."""
    rules = state.rules[0]
    i = 0
    while i < state.cursor[0].live:
        cluster = state.clusters[state.live[i]]
        at_us = NEVER_US
        coasts = rules.coast_us > 0 and cluster.track_id >= 0
        if rules.support_rate_hz > 0.0 and not coasts and cluster.before >= rules.visible_events:
            at_us = falls_at(rules, rate_hz(rules, cluster), rules.support_rate_hz, begin_us, end_us)
        if rules.border_share < 1.0 and _share_outside(rules, cluster) > rules.border_share:
            at_us = begin_us
        if at_us <= end_us:
            lose(state, i, at_us)
        else:
            i += 1
