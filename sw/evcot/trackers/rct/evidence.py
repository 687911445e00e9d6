# SPDX-License-Identifier: Apache-2.0
"""The evidence that a cluster is an object: its events, or their rate."""

from __future__ import annotations

from typing import Any

from ..._numba_private import step

__all__ = ["MASS_TAU_US", "weight"]

# Time constant of mass, the number of events that are not yet forgotten: ten packets of the paper. Shorter ones hide slow
# objects, longer ones show noise; tuned on the validation sets of docs/evaluation.md.
MASS_TAU_US = 10_000.0


@step
def weight(rules: Any, cluster: Any) -> Any:
    """The quantity that makes a cluster visible, as a multiple of its threshold.

    A constant event rate gives a mass of rate times time constant.
    """
    if rules.visible_rate_hz > 0.0:
        return cluster.mass * 1e6 / MASS_TAU_US / rules.visible_rate_hz
    return (cluster.before + cluster.packet_events) / rules.visible_events
