# SPDX-License-Identifier: Apache-2.0
"""The evidence that a cluster is an object: its events, their rate, or its mass."""

from __future__ import annotations

from typing import Any

from ..._numba_private import step
from .state import choice

__all__ = ["rate_hz", "weight"]

_EVENTS, _RATE = choice("visibility", "events"), choice("visibility", "rate")


@step
def rate_hz(rules: Any, cluster: Any) -> Any:
    """Event rate in events/s: a constant rate gives a mass of rate times time constant."""
    return cluster.mass * 1e6 / rules.mass_tau_us


@step
def weight(rules: Any, cluster: Any) -> Any:
    """The quantity that makes a cluster visible, as a multiple of its threshold."""
    if rules.visibility == _EVENTS:
        return (cluster.before + cluster.packet_events) / rules.visible_events
    if rules.visibility == _RATE:
        return rate_hz(rules, cluster) / max(rules.visible_rate_hz, 1e-9)
    return cluster.mass / max(rules.visible_mass, 1e-9)
