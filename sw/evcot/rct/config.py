# SPDX-License-Identifier: Apache-2.0
"""Settings of the Rectangular Cluster Tracker."""

from __future__ import annotations

from dataclasses import dataclass

from ..ranges import Range, check_ranges

__all__ = ["RCT_RANGES", "RctConfig"]

# field -> (lowest, highest, meaning)
RCT_RANGES: dict[str, Range] = {
    "max_clusters": (1, 1024, "clusters alive at once"),
    "radius_px": (0.5, 1000.0, "half the side of a cluster's square window"),
    "alpha": (1e-6, 1.0, "mixing factor of location"),
    "velocity_alpha": (1e-6, 1.0, "mixing factor of velocity"),
    "visible_events": (1, 1_000_000, "events after which a cluster becomes visible"),
    "lifetime_us": (1, 10**12, "silence after which a cluster is removed"),
    "packet_us": (1, 10**9, "length of a packet"),
}


@dataclass(frozen=True)
class RctConfig:
    """The software Rectangular Cluster Tracker; limits in `RCT_RANGES`.

    Raises:
        ConfigError: a value outside its range.
    """

    max_clusters: int = 32
    radius_px: float = 12.0
    alpha: float = 0.01
    velocity_alpha: float = 0.05
    visible_events: int = 5
    lifetime_us: int = 50_000
    packet_us: int = 1_000

    def __post_init__(self) -> None:
        check_ranges("rct", self, RCT_RANGES)
