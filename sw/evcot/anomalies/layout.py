# SPDX-License-Identifier: Apache-2.0
"""Data of the rules, in the form used by kernels: state of a track, limits, normal motion, zones and lines."""

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

# The state of one track.
TRACE = np.dtype(
    [
        *MOTION.descr,
        ("track_id", "<i8"),
        ("birth_us", "<i8"),
        ("ended_us", "<i8"),  # after the first record of the run; -1 while it lives
        ("radius", "<f8"),  # half its search window
        ("extent", "<f8"),  # half the longer side of its box
        ("settled", "?"),  # whether it has a position yet
        ("first_x", "<f8"),
        ("first_y", "<f8"),
        ("farthest_px", "<f8"),  # from its first position
        ("normal", "<f8"),  # normal speed at its position, px/s; NaN if unknown
        ("moved_us", "<f8"),  # time for which it has been about as fast as others there
        ("slow_us", "<f8"),  # time for which it has been slow, and since when
        ("slow_t", "<f8"),
        ("braked_t", "<f8"),  # time when it was last slow for long enough after motion, negative if never; and position
        ("braked_x", "<f8"),
        ("braked_y", "<f8"),
        ("slow_extent", "<f8"),  # when it became slow
        ("stood", "u1"),  # 1: it stayed at its first position, 0: it did not, 2: not yet known
        ("first_t", "<f8"),
        ("anchor_t", "<f8"),  # of its stay: start time, and mean position
        ("anchor_x", "<f8"),
        ("anchor_y", "<f8"),
        ("lingered_t", "<f8"),  # time when it was last slow there, and total time
        ("lingered_us", "<f8"),
        ("raised", "u1", _KINDS),
        ("open", "u1", _KINDS),  # whether evidence is being accumulated
        ("evidence_us", "<f8", _KINDS),
        ("since_t", "<f8", _KINDS),
        ("travel_px", "<f8", _KINDS),  # travelled while evidence was accumulated
    ]
)


class Rules(NamedTuple):
    """`AnomalyConfig` in the form used by the rules; angles as cosines."""

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
    """Normal motion in the form used by the rules: (rows, columns) arrays over cells of `cell_px`, (0, 0) at pixel (0, 0).

    support: tracks per cell; ends: tracks lost per cell. x, y: unit vector of the mean direction; concentration: length of the
    mean unit vector. log_speed, deviation: mean and standard deviation of log(px/s). near_speed: px/s there or in the nearest
    supported cells, NaN far from all of them.
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
    """Zones and lines in the form used by the rules, and the state of tracks there, (capacity, zones or lines).

    since: us at which a stay began, -1 for none; left: at which it was interrupted, -1 if it was not; side: of a line, 1 right,
    -1 left, 0 unknown; x, y: the last position with a side. counts: (lines, 2) crossings to the right and to the left.
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
    """The settings for raising alarms."""
    values: dict[str, Any] = {name: float(getattr(config, name)) for name in Rules._fields if hasattr(config, name)}
    return Rules(
        **values,
        evidence_px=config.travel_px / 2,
        longest_us=float(config.window_us),
        crossing_cos=math.cos(math.radians(config.crossing_deg)),
        wrong_way_cos=math.cos(math.radians(config.wrong_way_deg)),
    )
