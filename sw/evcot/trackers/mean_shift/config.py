# SPDX-License-Identifier: Apache-2.0
"""Settings of the clustering by mean shift."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from ...errors import ConfigError
from ...ranges import Range, check_ranges
from ..frame_based.config import IDENTITY_RANGES, IdentityConfig

__all__ = ["MEAN_SHIFT_RANGES", "MeanShiftConfig", "Source"]

Source = Literal["events", "frames"]

# field -> (lowest, highest, meaning)
MEAN_SHIFT_RANGES: dict[str, Range] = {
    **IDENTITY_RANGES,
    "packet_events": (1, 1_000_000, "maximum number of events in a packet"),
    "packet_us": (1, 10**9, "longest packet"),
    "frame_us": (1, 10**9, "length of a frame"),
    "bandwidth_px": (0.1, 1000.0, "h, the kernel's standard deviation"),
    "polarity_px": (0.0, 10_000.0, "distance of the two polarities, in pixels"),
    "time_px": (0.0, 10_000.0, "distance of a current and a very old event, in pixels"),
    "tau_us": (1.0, 1e12, "time constant with which an event's weight f decays"),
    "cutoff": (1.0, 6.0, "distance in bandwidths beyond which the kernel is 0"),
    "tolerance_px": (0.0, 1000.0, "a point that moves no farther in an iteration has converged"),
    "max_iterations": (1, 10_000, "maximum number of iterations"),
    "fold_px": (0.0, 1000.0, "side of the cells in which points are joined; 0 for never"),
    "fuse_px": (0.0, 10_000.0, "maximum distance of the modes of one cluster"),
    "points_min": (1, 1_000_000, "minimum number of points of a cluster"),
}


@dataclass(frozen=True)
class MeanShiftConfig(IdentityConfig):
    """Settings of mean shift clustering; limits in `MEAN_SHIFT_RANGES`.

    `source` selects what is clustered: "events", packets of `packet_events` events or of `packet_us`, whichever is complete
    first (points of x, y, polarity, time); or "frames", the pixels with events in `frame_us` (points of x, y, mean polarity).

    Raises:
        ConfigError: a value outside its range, or an unknown source.
    """

    source: Source = "events"
    packet_events: int = 300
    packet_us: int = 20_000
    frame_us: int = 20_000
    bandwidth_px: float = 6.0
    polarity_px: float = 2.0
    time_px: float = 2.0
    tau_us: float = 10_000.0
    cutoff: float = 3.0
    tolerance_px: float = 0.1
    max_iterations: int = 50
    fold_px: float = 1.0
    fuse_px: float = 6.0
    points_min: int = 8

    def __post_init__(self) -> None:
        check_ranges("mean_shift", self, MEAN_SHIFT_RANGES)
        if self.source not in get_args(Source):
            raise ConfigError(f"mean_shift.source = {self.source!r}: must be one of {', '.join(get_args(Source))}")
