# SPDX-License-Identifier: Apache-2.0
"""Settings of the Kalman tracker."""

from __future__ import annotations

from dataclasses import dataclass

from ...errors import ConfigError
from ...ranges import Range, check_ranges

__all__ = ["KALMAN_RANGES", "KalmanConfig"]

# field -> (lowest, highest, meaning)
KALMAN_RANGES: dict[str, Range] = {
    "max_objects": (1, 256, "objects alive at once"),
    "packet_us": (100, 1_000_000, "time between two corrections"),
    "refractory_us": (0, 1_000_000, "time after an event for which its pixel is ignored"),
    "quantile": (0.001, 0.4, "share of an object's events that lie beyond each of its sides"),
    "afterglow": (0.0, 0.4, "share of an object's events that pixels send behind it, when it has passed"),
    "gate_px": (0.5, 1000.0, "how far outside a box events still belong to it"),
    "gate_share": (0.0, 10.0, "the same as a part of the mean half side; the greater counts"),
    "events_per_sample": (0.1, 1e6, "events that carry as much information as one independent event"),
    "velocity_walk": (0.001, 1e4, "random walk of a centre's velocity in a second, half sides per second"),
    "growth_walk": (0.0001, 1e4, "random walk of a half side's growth in a second, half sides per second"),
    "meeting_walk": (0.0, 1.0, "factor of both walks while a box touches another"),
    "speed": (0.0, 1e4, "typical speed of a new object, half sides per second"),
    "birth_us": (100, 10_000_000, "time over which events outside all boxes are collected for births"),
    "birth_pixels": (2, 1_000_000, "different pixels in that time that make an object"),
    "coast_us": (0, 10**12, "time without support after which an object is removed"),
    "merge_gap": (0.0, 2.0, "gap between two parts of an object, as a part of its mean half side"),
    "merge_velocity": (0.0, 2.0, "difference of velocities, as a part of the greater, up to which motion is one"),
}


@dataclass(frozen=True)
class KalmanConfig:
    """Settings of the Kalman tracker; limits in `KALMAN_RANGES`, presets in `presets.PRESETS`.

    Attributes:
        walls: whether objects bounce off the sensor's edges, and are predicted accordingly.

    Raises:
        ConfigError: a value outside its range.
    """

    max_objects: int = 32
    packet_us: int = 2_000
    refractory_us: int = 1_000
    quantile: float = 0.03
    afterglow: float = 0.03
    gate_px: float = 3.0
    gate_share: float = 0.35
    events_per_sample: float = 10.0
    velocity_walk: float = 7.0
    growth_walk: float = 5.0
    meeting_walk: float = 1.0
    speed: float = 8.0
    birth_us: int = 10_000
    birth_pixels: int = 30
    coast_us: int = 100_000
    merge_gap: float = 1.0
    merge_velocity: float = 0.6
    walls: bool = False

    def __post_init__(self) -> None:
        check_ranges("kalman", self, KALMAN_RANGES)
        if not isinstance(self.walls, bool):
            raise ConfigError(f"kalman.walls = {self.walls!r}: must be true or false")
