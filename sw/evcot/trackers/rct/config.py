# SPDX-License-Identifier: Apache-2.0
"""Settings of the Rectangular Cluster Tracker; its presets, the paper's and one per kind of scene, with their filters."""

from __future__ import annotations

from dataclasses import dataclass, fields

from ...errors import ConfigError
from ...filters.config import FilterConfig
from ...ranges import Range, check_ranges, ranges_of, setting

__all__ = ["FILTERS", "PRESETS", "RCT_CHOICES", "RCT_RANGES", "RctConfig"]


# field -> allowed values
RCT_CHOICES: dict[str, tuple[str, ...]] = {"assign": ("nearest", "first")}

_SWITCHES = ("dynamic_size",)
_DEPTH_MIN_PX = 1.0  # from the vanishing row to the reference: one row, since sizes are divided by it


@dataclass(frozen=True)
class RctConfig:
    """Settings of the Rectangular Cluster Tracker; choices in `RCT_CHOICES`.

    All options after `packet_us` are off by default: the defaults are the paper's tracker.

    Raises:
        ConfigError: a value outside its range, or values that contradict each other.
    """

    max_clusters: int = setting(32, 1, 1024, "clusters alive at once")
    radius_px: float = setting(12.0, 0.5, 1000.0, "half the side of a cluster's square window")
    alpha: float = setting(0.01, 1e-6, 1.0, "mixing factor of location")
    velocity_alpha: float = setting(0.05, 1e-6, 1.0, "mixing factor of velocity")
    visible_events: int = setting(5, 1, 1_000_000, "events after which a cluster becomes visible")
    lifetime_us: int = setting(50_000, 1, 10**12, "silence after which a cluster is removed")
    packet_us: int = setting(1_000, 1, 10**9, "length of a packet")
    # Which cluster takes an event.
    assign: str = "nearest"
    surround: float = setting(1.0, 1.0, 10.0, "the surround's size in windows; 1: none")
    # Place and motion.
    box_quantile: float = setting(
        0.0, 0.0, 0.45, "share of events beyond each side of the box whose middle is the centre; 0: the mean"
    )
    path_points: int = setting(0, 0, 1000, "places of each cluster that are kept; from 3 on, velocity is their regression")
    predict: float = setting(0.0, 0.0, 1.0, "share of the velocity that carries clusters between packets; 0: none")
    # Size.
    aspect: float = setting(1.0, 0.05, 20.0, "height of a window, as a multiple of its width")
    dynamic_size: bool = False
    vanishing_y_px: float = setting(0.0, -1e5, 1e5, "row where objects vanish")
    reference_y_px: float = setting(0.0, -1e5, 1e5, "row where radius_px holds; the vanishing row: everywhere")
    # Life.
    visible_rate_hz: float = setting(0.0, 0.0, 1e9, "events per second from which on a cluster is visible; 0: visible_events")
    birth_spread_px: float = setting(0.0, 0.0, 1000.0, "mean deviation of its events below which a cluster stays invisible")
    coast_us: int = setting(0, 0, 10**12, "how long a visible cluster goes on without events beyond its lifetime")
    merge_overlap: float = setting(
        0.0, 0.0, 2.0, "share of the smaller window that two must share to merge; 0: a point; above 1: never"
    )

    def __post_init__(self) -> None:
        check_ranges("rct", self)
        for field, names in RCT_CHOICES.items():
            if getattr(self, field) not in names:
                raise ConfigError(f"rct.{field} = {getattr(self, field)!r}: must be one of {', '.join(names)}")
        for field in _SWITCHES:
            if not isinstance(getattr(self, field), bool):
                raise ConfigError(f"rct.{field} = {getattr(self, field)!r}: must be true or false")
        if self.perspective and abs(self.reference_y_px - self.vanishing_y_px) < _DEPTH_MIN_PX:
            rule = f"must be vanishing_y_px = {self.vanishing_y_px:g} (no perspective), or at least 1 px from it"
            raise ConfigError(f"rct.reference_y_px = {self.reference_y_px:g}: {rule}")

    @property
    def full(self) -> bool:
        """Whether any option beyond the paper's tracker is on."""
        return any(getattr(self, f.name) != f.default for f in fields(self)[_PLAIN_FIELDS:])

    @property
    def perspective(self) -> bool:
        """Whether the size of windows depends on their row."""
        return self.reference_y_px != self.vanishing_y_px


RCT_RANGES: dict[str, Range] = ranges_of(RctConfig)


_PLAIN_FIELDS = [f.name for f in fields(RctConfig)].index("packet_us") + 1


PRESETS: dict[str, RctConfig] = {
    "plain": RctConfig(),
    # A road that leads away from the camera, 346x260: cars shrink towards a row above the image. docs/evaluation.md has the
    # results, and the data used for tuning.
    "traffic": RctConfig(
        radius_px=44.0,
        aspect=1.3,
        vanishing_y_px=-60.0,
        reference_y_px=200.0,
        surround=2.5,
        packet_us=2_000,
        box_quantile=0.045,
        path_points=26,
        predict=0.7,
        visible_rate_hz=450.0,
        birth_spread_px=3.0,
        lifetime_us=20_000,
        coast_us=50_000,
        merge_overlap=0.45,
    ),
    # Round objects of one size, about 20 px wide, with events on the whole contour. Where two cross, the older takes all events
    # within its reach, and the younger coasts with its last velocity.
    "discs": RctConfig(
        radius_px=11.5,
        assign="first",
        surround=3.0,
        box_quantile=0.05,
        path_points=120,
        predict=1.0,
        visible_rate_hz=3_000.0,
        birth_spread_px=4.0,
        lifetime_us=5_000,
        coast_us=50_000,
        merge_overlap=0.85,
    ),
}

# Preset -> filters in front of the tracker.
FILTERS: dict[str, FilterConfig] = {
    "traffic": FilterConfig(activity_us=5_000),
}
