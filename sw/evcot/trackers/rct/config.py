# SPDX-License-Identifier: Apache-2.0
"""Settings of the Rectangular Cluster Tracker. `docs/rct.md` describes each option, its equation and its cost."""

from __future__ import annotations

from dataclasses import dataclass, fields

from ...errors import ConfigError
from ...ranges import Range, check_ranges

__all__ = ["RCT_CHOICES", "RCT_RANGES", "RctConfig"]

# field -> (lowest, highest, meaning)
RCT_RANGES: dict[str, Range] = {
    "max_clusters": (1, 1024, "clusters alive at once"),
    "radius_px": (0.5, 1000.0, "half the side of a cluster's square window"),
    "alpha": (1e-6, 1.0, "mixing factor of location"),
    "velocity_alpha": (1e-6, 1.0, "mixing factor of velocity"),
    "visible_events": (1, 1_000_000, "events after which a cluster becomes visible"),
    "lifetime_us": (1, 10**12, "silence after which a cluster is removed"),
    "packet_us": (1, 10**9, "length of a packet"),
    "surround": (1.0, 10.0, "the surround's size in windows; 1: none"),
    "alpha_tau_us": (0.0, 1e9, "time constant of location; 0: the mixing factor alpha"),
    "path_points": (0, 1000, "places of each cluster that are kept"),
    "predict": (0.0, 1.0, "share of the velocity that carries clusters between packets; 0: none"),
    "predict_points": (1, 1000, "places after which a velocity is trusted"),
    "friction_tau_us": (0.0, 1e9, "silence in which a carried cluster loses 63 % of its velocity; 0: none is lost"),
    "speed_max_px_s": (0.0, 1e7, "limit of speed; 0: none"),
    "aspect": (0.05, 20.0, "height of a new window, as a multiple of its width"),
    "size_alpha": (1e-6, 1.0, "mixing factor of size, angle and spread"),
    "size_ratio": (0.1, 10.0, "half the window's side as a multiple of the events' deviation or half extent"),
    "radius_min_px": (0.5, 1000.0, "lower limit of half a side"),
    "radius_max_px": (0.5, 1000.0, "upper limit of half a side"),
    "box_quantile": (0.001, 0.45, "share of events beyond each side of the box"),
    "box_alpha": (1e-6, 1.0, "step of the box's sides as a multiple of half the window's side"),
    "mass_tau_us": (1.0, 1e9, "time constant of mass"),
    "visible_rate_hz": (0.0, 1e9, "events per second from which on a cluster is visible"),
    "visible_mass": (0.0, 1e9, "mass from which on a cluster is visible"),
    "hidden_share": (0.0, 1.0, "share of the above below which it is no more"),
    "support_rate_hz": (0.0, 1e9, "events per second below which a cluster is removed; 0: none"),
    "border_share": (0.0, 1.0, "share of a window outside the sensor above which its cluster is removed; 1: none"),
    "merge_overlap": (0.0, 1.0, "share of the smaller window that two must share to merge; 0: a point"),
    "merge_angle_deg": (0.0, 180.0, "angle between velocities above which fast clusters do not merge"),
    "merge_speed_px_s": (0.0, 1e7, "speed above which clusters are fast"),
    "split_share": (0.0, 0.2, "share of events in a cluster's middle below which it is two; 0: never"),
    "split_packets": (1, 1_000_000, "packets for which it must be so"),
    "coast_us": (0, 10**12, "how long a visible cluster goes on without events beyond its lifetime"),
    "coast_reach_px": (0.0, 1000.0, "distance at which a new cluster is taken for one that coasts"),
    "birth_spread_px": (0.0, 1000.0, "mean deviation of its events below which a cluster stays invisible"),
    "vanishing_x_px": (-1e5, 1e5, "the vanishing point"),
    "vanishing_y_px": (-1e5, 1e5, "the vanishing point or row"),
    "reference_x_px": (-1e5, 1e5, "where radius_px holds"),
    "reference_y_px": (-1e5, 1e5, "where radius_px holds"),
}

# field -> allowed values
RCT_CHOICES: dict[str, tuple[str, ...]] = {
    "assign": ("nearest", "first"),
    "distance": ("chebyshev", "manhattan", "euclidean"),
    "velocity": ("filtered", "regression"),
    "size": ("fixed", "deviation", "quantile"),
    "centre": ("mean", "box"),
    "visibility": ("events", "rate", "mass"),
    "polarity": ("both", "on", "off", "separate"),
    "merge_into": ("older", "heavier"),
    "perspective": ("none", "row", "point"),
}

_SWITCHES = ("seeding", "free_aspect", "angle", "merging", "merge_grow")


@dataclass(frozen=True)
class RctConfig:
    """Settings of the Rectangular Cluster Tracker; limits in `RCT_RANGES`, choices in `RCT_CHOICES`.

    All options after `packet_us` are off by default: the defaults are the paper's tracker.

    Raises:
        ConfigError: a value outside its range, or values that contradict each other.
    """

    max_clusters: int = 32
    radius_px: float = 12.0
    alpha: float = 0.01
    velocity_alpha: float = 0.05
    visible_events: int = 5
    lifetime_us: int = 50_000
    packet_us: int = 1_000
    # Which cluster takes an event.
    seeding: bool = True
    assign: str = "nearest"
    distance: str = "chebyshev"
    surround: float = 1.0
    polarity: str = "both"
    # Place and motion.
    alpha_tau_us: float = 0.0
    centre: str = "mean"
    box_quantile: float = 0.05
    box_alpha: float = 0.02
    velocity: str = "filtered"
    path_points: int = 0
    predict: float = 0.0
    predict_points: int = 5
    friction_tau_us: float = 0.0
    speed_max_px_s: float = 0.0
    # Size.
    aspect: float = 1.0
    size: str = "fixed"
    free_aspect: bool = False
    angle: bool = False
    size_alpha: float = 0.01
    size_ratio: float = 2.0
    radius_min_px: float = 4.0
    radius_max_px: float = 50.0
    perspective: str = "none"
    vanishing_x_px: float = 0.0
    vanishing_y_px: float = 0.0
    reference_x_px: float = 0.0
    reference_y_px: float = 0.0
    # Life.
    mass_tau_us: float = 10_000.0
    visibility: str = "events"
    visible_rate_hz: float = 1_000.0
    visible_mass: float = 10.0
    hidden_share: float = 0.5
    support_rate_hz: float = 0.0
    birth_spread_px: float = 0.0
    border_share: float = 1.0
    coast_us: int = 0
    coast_reach_px: float = 20.0
    # Several into one, one into several.
    merging: bool = True
    merge_into: str = "older"
    merge_overlap: float = 0.0
    merge_angle_deg: float = 180.0
    merge_speed_px_s: float = 50.0
    merge_grow: bool = False
    split_share: float = 0.0
    split_packets: int = 20

    def __post_init__(self) -> None:
        check_ranges("rct", self, RCT_RANGES)
        for field, names in RCT_CHOICES.items():
            if getattr(self, field) not in names:
                raise ConfigError(f"rct.{field} = {getattr(self, field)!r}: must be one of {', '.join(names)}")
        for field in _SWITCHES:
            if not isinstance(getattr(self, field), bool):
                raise ConfigError(f"rct.{field} = {getattr(self, field)!r}: must be true or false")
        self._check_relations()

    @property
    def whole(self) -> bool:
        """Whether any option beyond the paper's tracker is on."""
        return any(getattr(self, f.name) != f.default for f in fields(self)[_PLAIN_FIELDS:])

    def _check_relations(self) -> None:
        if self.velocity == "regression" and self.path_points < 3:
            raise ConfigError(f"rct.path_points = {self.path_points}: must be at least 3 for velocity 'regression'")
        if self.size != "fixed" and not self.radius_min_px <= self.radius_px <= self.radius_max_px:
            limits = f"radius_min_px = {self.radius_min_px:g} to radius_max_px = {self.radius_max_px:g}"
            raise ConfigError(f"rct.radius_px = {self.radius_px:g}: must lie from {limits} when size is {self.size!r}")
        if self.angle and (self.size == "quantile" or self.centre == "box"):
            raise ConfigError("rct.angle = True: must not be combined with size 'quantile' or centre 'box', which never turn")
        if self.perspective != "none" and self._depth_px() < 1.0:
            raise ConfigError(f"rct.perspective = {self.perspective!r}: reference must lie at least 1 px from vanishing")

    def _depth_px(self) -> float:
        across = self.reference_x_px - self.vanishing_x_px if self.perspective == "point" else 0.0
        return float((across**2 + (self.reference_y_px - self.vanishing_y_px) ** 2) ** 0.5)


_PLAIN_FIELDS = [f.name for f in fields(RctConfig)].index("packet_us") + 1
