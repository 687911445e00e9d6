# SPDX-License-Identifier: Apache-2.0
"""What the rules work on, as kernels take it: a track as they know it, their limits, normal motion, zones and lines."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .alarm import Anomaly
from .config import AnomalyConfig
from .motion import MOTION

__all__ = ["TRACE", "Field", "Places", "Rules", "rules"]

_KINDS = len(Anomaly)

# What is known of one track.
TRACE = np.dtype(
    [
        *MOTION.descr,
        ("track_id", "<i8"),
        ("birth_us", "<i8"),
        ("ended_us", "<i8"),  # after the first record of the run; -1 while it lives
        ("radius", "<f8"),  # of its window
        ("settled", "?"),  # whether it has a place yet
        ("first_x", "<f8"),
        ("first_y", "<f8"),
        ("farthest_px", "<f8"),  # from its first place
        ("normal", "<f8"),  # speed where it is, px/s; not a number where that is not known
        ("moved_us", "<f8"),  # for how long it has been about as fast as others there
        ("slow_us", "<f8"),  # for how long it has been slow, and since when
        ("slow_t", "<f8"),
        ("braked_t", "<f8"),  # when it was last slow for long enough after it had been in motion, below 0 if never; and where
        ("braked_x", "<f8"),
        ("braked_y", "<f8"),
        ("slow_radius", "<f8"),  # of its window when it became slow
        ("stood", "u1"),  # 1: it stayed where it was first seen, 0: it did not, 2: that is not known yet
        ("first_t", "<f8"),
        ("anchor_t", "<f8"),  # of its stay: since when, and the mean place
        ("anchor_x", "<f8"),
        ("anchor_y", "<f8"),
        ("lingered_t", "<f8"),  # when it was last slow there, and for how long in all
        ("lingered_us", "<f8"),
        ("raised", "u1", _KINDS),
        ("open", "u1", _KINDS),  # whether evidence is being gathered
        ("evidence_us", "<f8", _KINDS),
        ("since_t", "<f8", _KINDS),
        ("travel_px", "<f8", _KINDS),  # while the evidence was gathered
    ]
)


class Rules(NamedTuple):
    """`AnomalyConfig` as the rules take it; angles as cosines."""

    significance: float
    hold_us: float
    evidence_px: float
    longest_us: float
    travel_px: float
    min_support: float
    min_concentration: float
    crossing_cos: float
    wrong_way_cos: float
    fast_ratio: float
    slow_ratio: float
    stop_ratio: float
    speed_deviations: float
    place_support: float
    loiter_us: float
    loiter_radius_px: float
    loiter_factor: float
    loiter_gap_us: float
    stitch_us: float
    line_margin_px: float


class Field(NamedTuple):
    """Normal motion as the rules take it: (rows, columns) arrays over cells of `cell_px`, (0, 0) at pixel (0, 0).

    support: tracks per cell; ends: tracks lost per cell. x, y: unit vector of the mean direction; concentration: length of the
    mean unit vector. log_speed, deviation: mean and standard deviation of log(px/s). near_speed: px/s there or in the nearest
    cells that have a support, not a number far from all.
    """

    cell_px: float
    support: NDArray[np.float64]
    ends: NDArray[np.float64]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    concentration: NDArray[np.float64]
    log_speed: NDArray[np.float64]
    deviation: NDArray[np.float64]
    near_speed: NDArray[np.float64]


class Places(NamedTuple):
    """Zones and lines as the rules take them, and what the (capacity, zones or lines) tracks did there.

    since: us at which a stay began, -1 for none; left: at which it was interrupted, -1 for not; side: of a line, 1 right, -1
    left, 0 not known; x, y: the last place that had a side. counts: (lines, 2) crossings to the right and to the left.
    """

    corners: NDArray[np.float64]
    starts: NDArray[np.int64]
    dwell_us: NDArray[np.float64]
    lines: NDArray[np.float64]
    allowed: NDArray[np.int64]
    counts: NDArray[np.int64]
    since: NDArray[np.float64]
    left: NDArray[np.float64]
    raised: NDArray[np.bool_]
    side: NDArray[np.int64]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    line_raised: NDArray[np.bool_]


def rules(config: AnomalyConfig) -> Rules:
    """The part of the settings that says when an alarm is raised."""
    values: dict[str, Any] = {name: float(getattr(config, name)) for name in Rules._fields if hasattr(config, name)}
    return Rules(
        **values,
        evidence_px=config.travel_px / 2,
        longest_us=float(config.window_us),
        crossing_cos=math.cos(math.radians(config.crossing_deg)),
        wrong_way_cos=math.cos(math.radians(config.wrong_way_deg)),
    )
