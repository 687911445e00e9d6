# SPDX-License-Identifier: Apache-2.0
"""Settings of the rules for anomalies."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import ConfigError
from ..ranges import check_ranges, setting

__all__ = ["RING", "AnomalyConfig"]

RING = 32  # number of positions stored per track


@dataclass(frozen=True)
class AnomalyConfig:
    """When a trajectory is anomalous.

    Raises:
        ConfigError: a value outside its range, or a window longer than the stored positions of a track.
    """

    step_us: int = setting(25_000, 1_000, 1_000_000, "places are averaged over so long")
    window_us: int = setting(500_000, 10_000, 10_000_000, "a velocity is taken over at most so long")
    travel_px: float = setting(
        16.0, 1.0, 1000.0, "way past which a window need not be longer; half of it against the flow is evidence"
    )
    hold_us: int = setting(500_000, 0, 60_000_000, "a rule must be broken for so long")
    significance: float = setting(3.0, 0.0, 100.0, "standard errors by which a velocity must differ")
    min_support: float = setting(0.5, 0.0, 1e6, "tracks per cell from which on the learned field counts")
    min_concentration: float = setting(0.7, 0.0, 1.0, "length of the mean unit vector from which on a cell has a direction")
    crossing_deg: float = setting(50.0, 1.0, 179.0, "angle to the normal direction from which on motion is across it")
    wrong_way_deg: float = setting(120.0, 1.0, 179.0, "angle to the normal direction from which on motion is against it")
    fast_ratio: float = setting(1.35, 1.0, 100.0, "times the normal speed")
    slow_ratio: float = setting(0.65, 0.0, 1.0, "part of the normal speed")
    stop_ratio: float = setting(0.25, 0.0, 1.0, "part of the normal speed at which something has stopped")
    speed_deviations: float = setting(
        3.0, 0.0, 100.0, "standard deviations by which a speed must differ from the cell's, on a log scale"
    )
    place_support: float = setting(0.02, 0.0, 1e6, "tracks per cell below which a place is unusual")
    loiter_us: int = setting(6_000_000, 1_000, 10**12, "longest normal stay within the radius")
    loiter_radius_px: float = setting(40.0, 0.5, 1000.0, "how far one may go in that time")
    loiter_factor: float = setting(
        3.0, 0.0, 1000.0, "times that normal motion takes to cross the radius: where it is slow, a stay may be longer"
    )
    loiter_gap_us: int = setting(3_000_000, 0, 10**12, "who lingers at a place again before that goes on with the stay")
    line_margin_px: float = setting(2.0, 0.0, 1000.0, "a side of a line is taken once a track is so far from it")
    stitch_us: int = setting(1_000_000, 0, 60_000_000, "a track born so soon after another has ended")
    stitch_px: float = setting(
        12.0, 0.0, 1000.0, "and so near to where it would be, or within its window there, goes on for it"
    )

    def __post_init__(self) -> None:
        check_ranges("anomalies", self)
        if not 4 * self.step_us <= self.window_us <= (RING - 1) * self.step_us:
            raise ConfigError(
                f"anomalies.window_us = {self.window_us}: must be from 4 to {RING - 1} times step_us = {self.step_us}"
            )
        if self.wrong_way_deg < self.crossing_deg:
            raise ConfigError(
                f"anomalies.wrong_way_deg = {self.wrong_way_deg:g}: must be at least crossing_deg = {self.crossing_deg:g}"
            )
