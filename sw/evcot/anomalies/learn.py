# SPDX-License-Identifier: Apache-2.0
"""Learn normal motion from logs in which a few tracks may be abnormal.

Each track's passage through a cell is one visit (`Visits`), with its mean velocity there; memory holds the tracks that are
alive, and visits of tracks that have ended go into a file. Visits that deviate from the surrounding field are removed, and the
field is recomputed, a few times: this rejects outliers wherever normal tracks are the majority.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit
from ..errors import ConfigError
from ..metrics.sampling import checked_runs
from ..tracks.column import PackedColumn
from ..tracks.log import Kind
from ..tracks.log_files import RecordRuns
from .config import AnomalyConfig
from .field import FieldConfig, NormalMotion, grid
from .layout import TRACE, Field
from .motion import Steps, add_place, begin, close_step, extent_px, steps

__all__ = ["learn", "smallest_sensor"]

_LEAST_SPEED = 0.5  # px/s
_SURE = 2.0  # standard errors above which a velocity has a direction
_CHUNK = 1 << 18
_ROWS = 64  # initial size of the table

_OBSERVED = np.dtype([("track", "<i8"), *((name, "<f8") for name in ("x", "y", "vx", "vy", "error"))])
_SUM = np.dtype([("track", "<i8"), ("cell", "<i8"), *((name, "<f8") for name in ("count", "vx", "vy", "error"))])

VISIT = np.dtype(
    [("track", "<i8"), ("row", "<i8"), ("column", "<i8"), ("x", "<f8"), ("y", "<f8"), ("log_speed", "<f8"), ("turns", "?")]
)


class Visits:
    """Collects the visits of any number of logs.

    Args:
        folder: for the file.
        sensor, config: the cells.
        measured: how velocities are measured.

    Attributes:
        tracks: so far.
    """

    def __init__(self, folder: Path, sensor: tuple[int, int], config: FieldConfig, measured: Steps) -> None:
        self._shape, self._cell_px, self._measured = grid(sensor, config), config.cell_px, measured
        self._done = PackedColumn(folder / "visits", VISIT)
        self.tracks = 0

    def add(self, runs: Iterator[NDArray[np.void]]) -> None:
        """Follow the tracks of a log, whose records come in runs."""
        origin_us: int | None = None
        table, free = np.zeros(_ROWS, TRACE), list(range(_ROWS))
        alive: dict[int, tuple[int, int]] = {}  # id -> number of the track, row of the table
        sums = np.empty(0, _SUM)  # of the tracks alive
        for records in runs:
            if not len(records):
                continue
            origin_us = int(records["t_us"][0]) if origin_us is None else origin_us
            records = records[np.argsort(records["track_id"], kind="stable")]
            first, ends = _lives(records)
            tracks, rows = np.empty((2, len(first)), np.int64)
            fresh = np.ones(len(first), np.bool_)
            born = records["kind"][first] == Kind.BORN
            for i, (track_id, is_born) in enumerate(zip(records["track_id"][first].tolist(), born.tolist(), strict=True)):
                if track_id in alive and not is_born:
                    fresh[i] = False
                else:
                    if track_id in alive:
                        free.append(alive[track_id][1])
                    if not free:
                        free = list(range(len(table), 2 * len(table)))
                        table = np.concatenate((table, np.zeros(len(table), TRACE)))
                    alive[track_id] = (self.tracks, free.pop())
                    self.tracks += 1
                tracks[i], rows[i] = alive[track_id]
                if ends[i]:
                    free.append(alive.pop(track_id)[1])
            out = np.zeros(len(records) + 1, _OBSERVED)
            found = _follow(self._measured, records, first, rows, tracks, fresh, origin_us, table, out)
            sums = self._ended(self._summed(sums, out[:found]), np.array([track for track, _ in alive.values()], np.int64))
        self._ended(sums, np.empty(0, np.int64))

    def chunks(self) -> Iterator[NDArray[np.void]]:
        """All visits, of dtype `VISIT`; those of a track follow each other."""
        for start in range(0, len(self._done), _CHUNK):
            yield self._done[start : start + _CHUNK]

    def __len__(self) -> int:
        return len(self._done)

    def close(self) -> None:
        """Close the file."""
        self._done.close()

    def _summed(self, sums: NDArray[np.void], observed: NDArray[np.void]) -> NDArray[np.void]:
        """The sums with further velocities, one row for each track and cell on the sensor."""
        rows, columns = self._shape
        row, column = (np.floor((observed[axis] + 0.5) / self._cell_px).astype(np.int64) for axis in "yx")
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        more = np.empty(int(inside.sum()), _SUM)
        more["track"], more["cell"], more["count"] = observed["track"][inside], (row * columns + column)[inside], 1.0
        for name in ("vx", "vy", "error"):
            more[name] = observed[name][inside]
        every = np.concatenate((sums, more))
        _, first, number = np.unique(every["track"] * (rows * columns) + every["cell"], return_index=True, return_inverse=True)
        total = every[first]
        for name in ("count", "vx", "vy", "error"):
            total[name] = np.bincount(number, every[name], len(first))
        return total

    def _ended(self, sums: NDArray[np.void], alive: NDArray[np.int64]) -> NDArray[np.void]:
        """Keep the visits of all tracks that are not alive; returns the other sums."""
        goes_on = np.isin(sums["track"], alive)
        done = sums[~goes_on]
        vx, vy, error = (done[name] / done["count"] for name in ("vx", "vy", "error"))
        speed = np.hypot(vx, vy)
        visits = np.zeros(len(done), VISIT)
        visits["track"], visits["row"], visits["column"] = done["track"], *divmod(done["cell"], self._shape[1])
        visits["x"], visits["y"] = vx / np.maximum(speed, 1e-9), vy / np.maximum(speed, 1e-9)
        visits["log_speed"] = np.log(np.maximum(speed, _LEAST_SPEED))
        visits["turns"] = speed > _SURE * error
        self._done.append(visits)
        return sums[goes_on]


def _lives(records: NDArray[np.void]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Of records by id, where each life, or its part in this run, begins, and whether it ends in it."""
    kind, track_id = records["kind"], records["track_id"]
    is_end = (kind == Kind.MERGED) | (kind == Kind.LOST)
    begins = kind == Kind.BORN
    begins[:1] = True
    begins[1:] |= (track_id[1:] != track_id[:-1]) | is_end[:-1]
    first = np.flatnonzero(begins)
    return first, is_end[np.append(first[1:], len(records)) - 1]


@njit(cache=True, nogil=True)
def _follow(
    measured: Steps, records: Any, firsts: Any, rows: Any, tracks: Any, fresh: Any, origin_us: int, table: Any, out: Any
) -> int:
    """Velocities of lives, one per step, of dtype `_OBSERVED`; returns how many."""
    found = 0
    for life in range(len(firsts)):
        motion = table[rows[life]]
        past = firsts[life + 1] if life + 1 < len(firsts) else len(records)
        for k in range(firsts[life], past):
            record = records[k]
            step = (record.t_us - origin_us) // measured.step_us
            if fresh[life] and k == firsts[life]:
                begin(motion, step)
            ends = record.kind == LOST or record.kind == MERGED
            if motion.n > 0 and (ends or step > motion.step):
                close_step(measured, motion, record.radius, extent_px(record))
                if motion.known:
                    row = out[found]
                    found += 1
                    row.track = tracks[life]
                    row.x = motion.mid_x
                    row.y = motion.mid_y
                    row.vx = motion.vx
                    row.vy = motion.vy
                    row.error = motion.error
            if not ends:
                add_place(motion, record.t_us - origin_us, step, measured.step_us, record.x, record.y)
    return found


LOST, MERGED = int(Kind.LOST), int(Kind.MERGED)


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
