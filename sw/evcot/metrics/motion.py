# SPDX-License-Identifier: Apache-2.0
"""Errors of matched tracks: position, velocity and latency."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..tracks.reading import RecordRuns
from .sampling import positions_around

__all__ = ["Motion", "motion"]

_SPAN_US = 50_000  # interval over which a track's velocity is measured
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
        latency_ms: time shift of the tracks that minimises the median distance, searched over +-100 ms in steps of 1 ms; above
            0 the tracks are late. None if the minimum is at an end of the range, or if nothing moves.
    """

    position_error_px_median: float | None
    position_error_px_p90: float | None
    velocity_error_median: float | None
    stated_velocity_error_median: float | None
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
    return Motion(
        position_error_px_median=_quantile(error_px, 0.5),
        position_error_px_p90=_quantile(error_px, 0.9),
        velocity_error_median=_velocity_error(log, max_age_us, objects, track_ids, instants_us),
        stated_velocity_error_median=_stated_velocity_error(objects, outputs),
        latency_ms=_latency_ms(log, max_age_us, objects, track_ids, instants_us),
    )


def _velocity_error(
    log: RecordRuns, max_age_us: int, objects: NDArray[np.void], track_ids: NDArray[np.int64], instants_us: NDArray[np.int64]
) -> float | None:
    around_us = np.array([-_SPAN_US // 2, _SPAN_US // 2])
    places = np.full((2, len(track_ids), 2), np.nan)
    for some in positions_around(log.record_runs(), max_age_us, track_ids, instants_us, around_us):
        for axis, own in zip(places, (some.x, some.y), strict=True):
            axis[some.rows][some.there] = own[some.there]
    vx, vy = (np.diff(axis)[:, 0] / (_SPAN_US * 1e-6) for axis in places)
    return _quantile(np.hypot(vx - objects["vx"], vy - objects["vy"]), 0.5)


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
