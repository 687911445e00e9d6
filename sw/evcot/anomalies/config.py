# SPDX-License-Identifier: Apache-2.0
"""Settings of the rules for anomalies."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import ConfigError
from ..ranges import Range, check_ranges

__all__ = ["ANOMALY_RANGES", "RING", "AnomalyConfig"]

RING = 32  # number of positions stored per track

# field -> (lowest, highest, meaning)
ANOMALY_RANGES: dict[str, Range] = {
    "step_us": (1_000, 1_000_000, "places are averaged over so long"),
    "window_us": (10_000, 10_000_000, "a velocity is taken over at most so long"),
    "travel_px": (1.0, 1000.0, "way past which a window need not be longer; half of it against the flow is evidence"),
    "hold_us": (0, 60_000_000, "a rule must be broken for so long"),
    "significance": (0.0, 100.0, "standard errors by which a velocity must differ"),
    "min_support": (0.0, 1e6, "tracks per cell from which on the learned field counts"),
    "min_concentration": (0.0, 1.0, "length of the mean unit vector from which on a cell has a direction"),
    "crossing_deg": (1.0, 179.0, "angle to the normal direction from which on motion is across it"),
    "wrong_way_deg": (1.0, 179.0, "angle to the normal direction from which on motion is against it"),
    "fast_ratio": (1.0, 100.0, "times the normal speed"),
    "slow_ratio": (0.0, 1.0, "part of the normal speed"),
    "stop_ratio": (0.0, 1.0, "part of the normal speed at which something has stopped"),
    "speed_deviations": (0.0, 100.0, "standard deviations by which a speed must differ from the cell's, on a log scale"),
    "place_support": (0.0, 1e6, "tracks per cell below which a place is unusual"),
    "loiter_us": (1_000, 10**12, "longest normal stay within the radius"),
    "loiter_radius_px": (0.5, 1000.0, "how far one may go in that time"),
    "loiter_factor": (
        0.0,
        1000.0,
        "times that normal motion takes to cross the radius: where it is slow, a stay may be longer",
    ),
    "loiter_gap_us": (0, 10**12, "who lingers at a place again before that goes on with the stay"),
    "line_margin_px": (0.0, 1000.0, "a side of a line is taken once a track is so far from it"),
    "stitch_us": (0, 60_000_000, "a track born so soon after another has ended"),
    "stitch_px": (0.0, 1000.0, "and so near to where it would be, or within its window there, goes on for it"),
}


@dataclass(frozen=True)
class AnomalyConfig:
    """When a trajectory is anomalous; limits and meanings in `ANOMALY_RANGES`.

    Raises:
        ConfigError: a value outside its range, or a window longer than the stored positions of a track.
    """

    step_us: int = 25_000
    window_us: int = 500_000
    travel_px: float = 16.0
    hold_us: int = 500_000
    significance: float = 3.0
    min_support: float = 0.5
    min_concentration: float = 0.7
    crossing_deg: float = 50.0
    wrong_way_deg: float = 120.0
    fast_ratio: float = 1.35
    slow_ratio: float = 0.65
    stop_ratio: float = 0.25
    speed_deviations: float = 3.0
    place_support: float = 0.02
    loiter_us: int = 6_000_000
    loiter_radius_px: float = 40.0
    loiter_factor: float = 3.0
    loiter_gap_us: int = 3_000_000
    line_margin_px: float = 2.0
    stitch_us: int = 1_000_000
    stitch_px: float = 12.0

    def __post_init__(self) -> None:
        check_ranges("anomalies", self, ANOMALY_RANGES)
        if not 4 * self.step_us <= self.window_us <= (RING - 1) * self.step_us:
            raise ConfigError(
                f"anomalies.window_us = {self.window_us}: must be from 4 to {RING - 1} times step_us = {self.step_us}"
            )
        if self.wrong_way_deg < self.crossing_deg:
            raise ConfigError(
                f"anomalies.wrong_way_deg = {self.wrong_way_deg:g}: must be at least crossing_deg = {self.crossing_deg:g}"
            )
