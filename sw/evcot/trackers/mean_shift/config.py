# SPDX-License-Identifier: Apache-2.0
"""Settings of the clustering by mean shift."""

from __future__ import annotations

from dataclasses import dataclass

from ...ranges import Range, check_ranges
from ..detections.identity import IDENTITY_RANGES, IdentityConfig

__all__ = ["MEAN_SHIFT_RANGES", "PRESETS", "MeanShiftConfig"]

# field -> (lowest, highest, meaning)
MEAN_SHIFT_RANGES: dict[str, Range] = {
    **IDENTITY_RANGES,
    "packet_events": (1, 1_000_000, "maximum number of events in a packet"),
    "bandwidth_px": (0.1, 1000.0, "h, the kernel's standard deviation; modes at most this far apart are one cluster"),
    "points_min": (1, 1_000_000, "minimum number of events of a cluster"),
}


@dataclass(frozen=True)
class MeanShiftConfig(IdentityConfig):
    """Settings of mean shift clustering; limits in `MEAN_SHIFT_RANGES`.

    Raises:
        ConfigError: a value outside its range.
    """

    packet_events: int = 300
    bandwidth_px: float = 6.0
    points_min: int = 8

    def __post_init__(self) -> None:
        check_ranges("mean_shift", self, MEAN_SHIFT_RANGES)


PRESETS: dict[str, MeanShiftConfig] = {
    # A contour of about 20 px: from a bandwidth of 0.7 of its radius on, its centre is a single mode.
    "discs": MeanShiftConfig(visible_hits=5, packet_events=300, bandwidth_px=8.0, points_min=8),
    # Vehicles of 25 to 90 px: the smallest must not be fused, the largest not split.
    "traffic": MeanShiftConfig(
        gate_px=25.0, smoothing_us=30_000, visible_hits=10, packet_events=500, bandwidth_px=18.0, points_min=15
    ),
}
