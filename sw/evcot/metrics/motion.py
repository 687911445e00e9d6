# SPDX-License-Identifier: Apache-2.0
"""Errors of matched tracks: position, velocity and latency."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..tracks.log import Kind
from ..tracks.log_files import RecordRuns
from .sampling import positions_around

__all__ = ["Motion", "motion"]

_SPAN_US = 50_000  # interval over which a track's velocity is measured
_LONG_SPAN_US = 300_000  # interval over which a stated velocity is compared with the displacement
_OLD_US = 500_000  # a track that lives shorter is not compared
_MOVING_PX_PER_S = 15.0  # a displacement below has no certain direction
_WRONG_WAY_DEG = 45.0
_SHIFT_MAX_US = 100_000
_SHIFT_US = 1_000
_FLAT_PX = 1e-6
_PAIRS = 20_000  # more pairs do not improve the estimate of the shift


@dataclass(frozen=True)
class Motion:
    """Errors of matched pairs; None if not measurable.

    Attributes:
        position_error_px_median, position_error_px_p90: distance between object and track.
        velocity_error_median: distance between their velocities, pixels per second; for a track, from its positions 25 ms later
            and earlier. None without velocities in the truth.
        stated_velocity_error_median: the same with the velocity that the track states, which cannot use later events; None
            if no matched track states one.
        stated_angle_error_deg_median: angle between the velocity that the track states and its displacement from 150 ms before
            to 150 ms after, in degrees. Only of tracks that live for 0.5 s at least, where the displacement is faster than
            15 px/s; None if there are none, or none states a velocity. `stated_angle_over_45_deg_fraction`: how often the angle
            is over 45 degrees.
        stated_relative_error_median: the same, for the length of the difference of both, divided by the displacement.
        latency_ms: time shift of the tracks that minimises the median distance, searched over +-100 ms in steps of 1 ms; above
            0 the tracks are late. None if the minimum is at an end of the range, or if nothing moves.
    """

    position_error_px_median: float | None
    position_error_px_p90: float | None
    velocity_error_median: float | None
    stated_velocity_error_median: float | None
    stated_angle_error_deg_median: float | None
    stated_angle_over_45_deg_fraction: float | None
    stated_relative_error_median: float | None
    latency_ms: float | None


def motion(
    log: RecordRuns, max_age_us: int, objects: NDArray[np.void], outputs: NDArray[np.void], instants_us: NDArray[np.int64]
) -> Motion:
    """Errors of (n,) matched pairs.

    Args:
        log: the log, read twice.
        max_age_us: age from which on a state is none.
        objects: (n,) of dtype `truth.OBJECT`.
        outputs: (n,) of dtype `timeline.SAMPLE`, the track matched with each.
        instants_us: (n,) time of each match, ascending.
    """
    track_ids = outputs["track_id"]
    error_px = np.hypot(outputs["x"] - objects["x"], outputs["y"] - objects["y"])
    lives = _Lives()
    short, long = _displacements(lives.noting(log.record_runs()), max_age_us, track_ids, instants_us)
    error = np.hypot(short[0] - objects["vx"], short[1] - objects["vy"])
    old = lives.lengths_us(track_ids, instants_us) >= _OLD_US
    angle_deg, relative = _against_displacement(outputs[old], long[:, old])
    return Motion(
        position_error_px_median=_quantile(error_px, 0.5),
        position_error_px_p90=_quantile(error_px, 0.9),
        velocity_error_median=_quantile(error, 0.5),
        stated_velocity_error_median=_stated_velocity_error(objects, outputs),
        stated_angle_error_deg_median=_quantile(angle_deg, 0.5),
        stated_angle_over_45_deg_fraction=float(np.mean(angle_deg > _WRONG_WAY_DEG)) if len(angle_deg) else None,
        stated_relative_error_median=_quantile(relative, 0.5),
        latency_ms=_latency_ms(log, max_age_us, objects, track_ids, instants_us),
    )


def _displacements(
    runs: Iterable[NDArray[np.void]], max_age_us: int, track_ids: NDArray[np.int64], instants_us: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Velocities of tracks by displacement over the short and over the long span, (2, n) each: vx, vy in px/s, or NaN."""
    around_us = np.array([-_LONG_SPAN_US // 2, -_SPAN_US // 2, _SPAN_US // 2, _LONG_SPAN_US // 2])
    places = np.full((2, len(track_ids), len(around_us)), np.nan)
    for some in positions_around(runs, max_age_us, track_ids, instants_us, around_us):
        for axis, own in zip(places, (some.x, some.y), strict=True):
            axis[some.rows][some.there] = own[some.there]
    from_0, from_1, to_1, to_0 = np.moveaxis(places, 2, 0)
    return (to_1 - from_1) / (_SPAN_US * 1e-6), (to_0 - from_0) / (_LONG_SPAN_US * 1e-6)


def _against_displacement(
    outputs: NDArray[np.void], displacement: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Angle in degrees between stated velocity and displacement, and relative error, wherever both are there."""
    stated = np.stack((outputs["vx"], outputs["vy"]))
    compared = (np.hypot(*displacement) > _MOVING_PX_PER_S) & stated.any(axis=0)  # both are 0 until it is known
    (vx, vy), (dx, dy) = stated[:, compared], displacement[:, compared]
    angle = np.arctan2(dx * vy - dy * vx, dx * vx + dy * vy)
    return np.abs(np.degrees(angle)), np.hypot(vx - dx, vy - dy) / np.hypot(dx, dy)


class _Lives:
    """Births and ends of a log whose records pass by."""

    def __init__(self) -> None:
        self._births: list[NDArray[np.void]] = []
        self._ends: list[NDArray[np.void]] = []
        self._span_us: tuple[int, int] | None = None

    def noting(self, runs: Iterable[NDArray[np.void]]) -> Iterator[NDArray[np.void]]:
        """The same runs."""
        for records in runs:
            if len(records):
                first_us = self._span_us[0] if self._span_us else int(records["t_us"][0])
                self._span_us = first_us, int(records["t_us"][-1])
            of = records[["track_id", "t_us"]]
            self._births.append(of[records["kind"] == Kind.BORN])
            self._ends.append(of[records["kind"] > Kind.MOVED])
            yield records

    def lengths_us(self, track_ids: NDArray[np.int64], instants_us: NDArray[np.int64]) -> NDArray[np.int64]:
        """(n,) how long the track with each id that is there at each instant lives, within the log."""
        if self._span_us is None:
            return np.zeros(len(track_ids), np.int64)
        births, ends = np.concatenate(self._births), np.concatenate(self._ends)
        first_us, last_us = self._span_us
        end_us = -_latest(ends["track_id"], -ends["t_us"], track_ids, -instants_us, -last_us)
        return end_us - _latest(births["track_id"], births["t_us"], track_ids, instants_us, first_us)


def _latest(
    ids: NDArray[np.int64],
    times_us: NDArray[np.int64],
    of_ids: NDArray[np.int64],
    until_us: NDArray[np.int64],
    default_us: int,
) -> NDArray[np.int64]:
    """(n,) the latest of the (k,) times with an id that is not after a time, for (n,) ids and times."""
    every_id, every_us = np.concatenate((ids, of_ids)), np.concatenate((times_us, until_us))
    order = np.lexsort((np.arange(len(every_id)), every_us, every_id))
    newest = np.maximum.accumulate(np.where(order < len(ids), np.arange(len(order)), -1))
    asked = order >= len(ids)
    found = order[newest[asked]]
    known = (newest[asked] >= 0) & (every_id[found] == every_id[order[asked]])
    latest_us = np.empty(len(of_ids), np.int64)
    latest_us[order[asked] - len(ids)] = np.where(known, every_us[found], default_us)
    return latest_us


def _stated_velocity_error(objects: NDArray[np.void], outputs: NDArray[np.void]) -> float | None:
    error = np.hypot(outputs["vx"] - objects["vx"], outputs["vy"] - objects["vy"])
    return _quantile(error[(outputs["vx"] != 0) | (outputs["vy"] != 0)], 0.5)  # both are 0 until it is known


def _latency_ms(
    log: RecordRuns, max_age_us: int, objects: NDArray[np.void], track_ids: NDArray[np.int64], instants_us: NDArray[np.int64]
) -> float | None:
    shifts_us = np.arange(-_SHIFT_MAX_US, _SHIFT_MAX_US + 1, _SHIFT_US)
    shifts_us = shifts_us[np.argsort(np.abs(shifts_us), kind="stable")]  # ties are resolved in favour of the smallest shift
    every = max(1, -(-len(objects) // _PAIRS))
    objects, track_ids, instants_us = objects[::every], track_ids[::every], instants_us[::every]
    x, y = (np.ascontiguousarray(objects[axis]) for axis in "xy")
    errors_px = np.full((len(shifts_us), len(objects)), np.nan)
    for some in positions_around(log.record_runs(), max_age_us, track_ids, instants_us, shifts_us):
        error_px = np.hypot(some.x - x[some.rows, None], some.y - y[some.rows, None])
        np.copyto(errors_px[:, some.rows], error_px.T, where=some.there.T)
    # A shift at which most tracks do not exist is not meaningful.
    medians_px = np.array(
        [
            np.median(there) if 2 * len(there) >= len(objects) and len(there) else np.inf
            for there in (row[~np.isnan(row)] for row in errors_px)
        ]
    )
    known = medians_px[np.isfinite(medians_px)]
    if not len(known) or np.ptp(known) < _FLAT_PX:
        return None
    best_us = int(shifts_us[np.argmin(medians_px)])
    return best_us / 1000 if abs(best_us) < _SHIFT_MAX_US else None


def _quantile(values: NDArray[np.float64], q: float) -> float | None:
    values = values[~np.isnan(values)]
    return float(np.quantile(values, q)) if len(values) else None
