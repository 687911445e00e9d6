# SPDX-License-Identifier: Apache-2.0
"""Learn normal motion from logs in which a few tracks may be abnormal.

Each track's passage through a cell is one visit (`visits`), with its mean velocity there. Visits that deviate from the
surrounding field are removed, and the field is recomputed, a few times: this rejects outliers wherever normal tracks are the
majority.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError
from ..metrics.sampling import checked_runs
from ..tracks.log import Kind
from ..tracks.log_files import RecordRuns
from .config import AnomalyConfig
from .field import FieldConfig, NormalMotion, grid
from .layout import Field
from .motion import Steps, steps
from .visits import Visits

__all__ = ["learn", "smallest_sensor"]

_ANGLE_COS = 0.5  # a visit further from the mean direction is removed, if there is one
_CLEAR = 0.5  # concentration from which on there is a mean direction
_DEVIATIONS = (2.0, 2.0, 2.0, 2.5, 3.0, 3.0)  # per round: strict while outliers still contribute


def learn(
    logs: Sequence[RecordRuns],
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
    ends = np.zeros(grid(sensor, config))
    with TemporaryDirectory(prefix="evcot-") as folder, closing(Visits(Path(folder), sensor, config, measured)) as visits:
        for log in logs:
            visits.add(_counting_ends(checked_runs(log.record_runs()), ends, config))
        if not len(visits):
            raise ConfigError("learning: no track in the logs is long enough to have a velocity on the sensor")
        normal = _summed(visits.chunks(), ends, sensor, config, measured)
        for deviations in _DEVIATIONS:
            normal = _summed(_fitting(visits.chunks(), normal.smoothed(), deviations), ends, sensor, config, measured)
    return normal


def smallest_sensor(logs: Sequence[RecordRuns]) -> tuple[int, int]:
    """The smallest (width, height) that holds all positions in the logs.

    Raises:
        TrackLogError: a log with invalid records.
    """
    farthest = dict.fromkeys("xy", 0.0)
    for log in logs:
        for records in checked_runs(log.record_runs()):
            farthest = {axis: max(most, float(records[axis].max(initial=0.0))) for axis, most in farthest.items()}
    width, height = (int(np.clip(np.ceil(most + 0.5), 1, 65_536)) for most in farthest.values())
    return width, height


def _counting_ends(
    runs: Iterator[NDArray[np.void]], ends: NDArray[np.float64], config: FieldConfig
) -> Iterator[NDArray[np.void]]:
    """The same runs; `ends` counts the tracks lost in each cell; those off the sensor count for the nearest cell."""
    for records in runs:
        lost = records[records["kind"] == Kind.LOST]
        row, column = (
            np.clip((lost[axis] + 0.5) // config.cell_px, 0, cells - 1).astype(np.int64)
            for axis, cells in zip("yx", ends.shape, strict=True)
        )
        np.add.at(ends, (row, column), 1.0)
        yield records


def _summed(
    chunks: Iterator[NDArray[np.void]], ends: NDArray[np.float64], sensor: tuple[int, int], config: FieldConfig, measured: Steps
) -> NormalMotion:
    shape = grid(sensor, config)
    totals = np.zeros((6, *shape))
    tracks, last = 0, -1
    for visits in chunks:
        cell = visits["row"] * shape[1] + visits["column"]
        turns, log_speed = visits["turns"].astype(np.float64), visits["log_speed"]
        columns = (np.ones(len(visits)), turns, turns * visits["x"], turns * visits["y"], log_speed, log_speed**2)
        for total, weights in zip(totals, columns, strict=True):
            total += np.bincount(cell, weights, shape[0] * shape[1]).reshape(shape)
        tracks += int(np.count_nonzero(np.diff(visits["track"], prepend=last)))
        last = int(visits["track"][-1]) if len(visits) else last
    count, *others = totals
    return NormalMotion(sensor, config, measured, tracks, count, ends, *others)


def _fitting(chunks: Iterator[NDArray[np.void]], field: Field, deviations: float) -> Iterator[NDArray[np.void]]:
    """The visits that agree with the field around them."""
    for visits in chunks:
        at = visits["row"], visits["column"]
        cosine = visits["x"] * field.x[at] + visits["y"] * field.y[at]
        turned = visits["turns"] & (field.concentration[at] >= _CLEAR) & (cosine < _ANGLE_COS)
        apart = np.abs(visits["log_speed"] - field.log_speed[at]) > deviations * field.deviation[at]
        yield visits[~turned & ~apart]
