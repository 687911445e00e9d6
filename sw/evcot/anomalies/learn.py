# SPDX-License-Identifier: Apache-2.0
"""Learn normal motion from logs in which a few tracks may be abnormal.

Each track's passage through a cell is one visit, with its mean velocity there. Visits that deviate from the surrounding field
are removed, and the field is recomputed, a few times: this rejects outliers wherever normal tracks are the majority.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..errors import ConfigError
from ..metrics.sampling import checked
from ..tracks.log import TRACK, Kind, TrackLog
from .config import AnomalyConfig
from .field import FieldConfig, NormalMotion, grid
from .layout import TRACE
from .motion import Steps, add_place, begin, close_step, extent_px, steps

__all__ = ["learn", "smallest_sensor"]

_ANGLE_COS = 0.5  # a visit further from the mean direction is removed, if there is one
_CLEAR = 0.5  # concentration from which on there is a mean direction
_DEVIATIONS = (2.0, 2.0, 2.0, 2.5, 3.0, 3.0)  # per round: strict while outliers still contribute
_LEAST_SPEED = 0.5  # px/s
_SURE = 2.0  # standard errors above which a velocity has a direction

OBSERVED = np.dtype([("track", "<i8"), *((name, "<f8") for name in ("x", "y", "vx", "vy", "error"))])

VISIT = np.dtype(
    [("track", "<i8"), ("row", "<i8"), ("column", "<i8"), ("x", "<f8"), ("y", "<f8"), ("log_speed", "<f8"), ("turns", "?")]
)


def learn(
    logs: Sequence[TrackLog],
    sensor: tuple[int, int] | None = None,
    config: FieldConfig | None = None,
    anomaly_config: AnomalyConfig | None = None,
) -> NormalMotion:
    """Learn the field of normal motion from logs of one camera.

    Args:
        sensor: (width, height) in pixels; None for the smallest that holds all positions.
        anomaly_config: settings for measuring motion; must be the same when the field is used.

    Raises:
        TrackLogError: a log with invalid records.
        ConfigError: no track is long enough to have a velocity.
    """
    config, measured = config or FieldConfig(), steps(anomaly_config or AnomalyConfig())
    sensor = sensor or smallest_sensor(logs)
    observed = _observed(logs, measured)
    visits = _visits(observed, sensor, config)
    ends = _ends(logs, sensor, config)
    if not len(visits):
        raise ConfigError("learning: no track in the logs is long enough to have a velocity on the sensor")
    kept = np.ones(len(visits), bool)
    for deviations in _DEVIATIONS:
        kept = _fits(visits, _summed(visits[kept], ends, sensor, config, measured), deviations)
    return _summed(visits[kept], ends, sensor, config, measured)


def smallest_sensor(logs: Sequence[TrackLog]) -> tuple[int, int]:
    """The smallest (width, height) that holds all positions in the logs."""
    sides = []
    for axis in "xy":
        places = np.concatenate([np.zeros(1), *(log.records[axis] for log in logs)])
        sides.append(int(np.clip(np.ceil(places.max() + 0.5), 1, 65_536)))
    return sides[0], sides[1]


def _observed(logs: Sequence[TrackLog], measured: Steps) -> NDArray[np.void]:
    """Velocities of all tracks, one per step, of dtype `OBSERVED`; tracks numbered over all logs."""
    parts, first = [np.empty(0, OBSERVED)], 0
    for log in logs:
        records = checked(log).records
        records = records[np.argsort(records["track_id"], kind="stable")]
        if not len(records):
            continue
        out = np.zeros(len(records) + 1, OBSERVED)
        track = np.cumsum(np.append(0, np.diff(records["track_id"]) != 0)) + first
        found = _follow(measured, records, track, int(records["t_us"].min()), np.zeros(1, TRACE), out)
        parts.append(out[:found])
        first = int(track[-1]) + 1
    return np.concatenate(parts)


@njit(cache=True, nogil=True)
def _follow(measured: Steps, records: Any, tracks: Any, origin_us: int, motions: Any, out: Any) -> int:
    motion = motions[0]
    found = 0
    last = -1
    for k in range(len(records)):
        record = records[k]
        step = (record.t_us - origin_us) // measured.step_us
        if tracks[k] != last:
            begin(motion, step)
            last = tracks[k]
        ends = record.kind == LOST or record.kind == MERGED
        if motion.n > 0 and (ends or step > motion.step):
            close_step(measured, motion, record.radius, extent_px(record))
            if motion.known:
                row = out[found]
                found += 1
                row.track = last
                row.x = motion.mid_x
                row.y = motion.mid_y
                row.vx = motion.vx
                row.vy = motion.vy
                row.error = motion.error
        if not ends:
            add_place(motion, record.t_us - origin_us, step, measured.step_us, record.x, record.y)
    return found


LOST, MERGED = int(Kind.LOST), int(Kind.MERGED)


def _visits(observed: NDArray[np.void], sensor: tuple[int, int], config: FieldConfig) -> NDArray[np.void]:
    """One row of dtype `VISIT` per track and cell on the sensor."""
    rows, columns = grid(sensor, config)
    row, column = (np.floor((observed[axis] + 0.5) / config.cell_px).astype(np.int64) for axis in "yx")
    inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
    observed, row, column = observed[inside], row[inside], column[inside]
    key = (observed["track"] * rows + row) * columns + column
    _, first, number = np.unique(key, return_index=True, return_inverse=True)
    count = np.maximum(np.bincount(number, minlength=len(first)), 1)
    vx, vy, error = (np.bincount(number, observed[name], len(first)) / count for name in ("vx", "vy", "error"))
    speed = np.hypot(vx, vy)
    visits = np.zeros(len(first), VISIT)
    visits["track"], visits["row"], visits["column"] = observed["track"][first], row[first], column[first]
    visits["x"], visits["y"] = vx / np.maximum(speed, 1e-9), vy / np.maximum(speed, 1e-9)
    visits["log_speed"] = np.log(np.maximum(speed, _LEAST_SPEED))
    visits["turns"] = speed > _SURE * error
    return visits


def _ends(logs: Sequence[TrackLog], sensor: tuple[int, int], config: FieldConfig) -> NDArray[np.float64]:
    """Number of tracks lost in each cell; those off the sensor count for the nearest cell."""
    rows, columns = grid(sensor, config)
    lost = np.concatenate([np.empty(0, TRACK), *(log.of_kind(Kind.LOST) for log in logs)])
    row, column = (
        np.clip((lost[axis] + 0.5) // config.cell_px, 0, cells - 1).astype(np.int64)
        for axis, cells in (("y", rows), ("x", columns))
    )
    return np.bincount(row * columns + column, minlength=rows * columns).reshape(rows, columns).astype(np.float64)


def _summed(
    visits: NDArray[np.void], ends: NDArray[np.float64], sensor: tuple[int, int], config: FieldConfig, measured: Steps
) -> NormalMotion:
    shape = grid(sensor, config)
    cell = visits["row"] * shape[1] + visits["column"]

    def total(weights: NDArray[Any]) -> NDArray[np.float64]:
        return np.asarray(np.bincount(cell, weights, shape[0] * shape[1]).reshape(shape), np.float64)

    turns, log_speed = visits["turns"].astype(np.float64), visits["log_speed"]
    return NormalMotion(
        sensor, config, measured, len(np.unique(visits["track"])), total(np.ones(len(visits))), ends, total(turns),
        total(turns * visits["x"]), total(turns * visits["y"]), total(log_speed), total(log_speed**2),
    )  # fmt: skip


def _fits(visits: NDArray[np.void], normal: NormalMotion, deviations: float) -> NDArray[np.bool_]:
    """Mask of the visits that agree with the field around them."""
    field = normal.smoothed()
    at = visits["row"], visits["column"]
    cosine = visits["x"] * field.x[at] + visits["y"] * field.y[at]
    turned = visits["turns"] & (field.concentration[at] >= _CLEAR) & (cosine < _ANGLE_COS)
    apart = np.abs(visits["log_speed"] - field.log_speed[at]) > deviations * field.deviation[at]
    return np.asarray(~turned & ~apart)
