# SPDX-License-Identifier: Apache-2.0
"""Online detection of anomalies: takes a stream of records and returns alarms.

The compiled loop assigns each record to a track, and closes the track's steps. Rows of its table are live tracks, and some that
ended recently: a track that is born at the predicted position of one of these continues it, so that an interruption by the
tracker neither hides a long stay nor repeats an alarm.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit
from ..errors import ConfigError, TrackLogError
from ..tracks.log import Kind
from ..tracks.log_files import RecordRuns
from ..tracks.record import check_records, upright_sides
from ..tracks.tally import LifeCounter
from .alarm import ALARM
from .config import AnomalyConfig
from .field import NormalMotion
from .judge import ALARMS_PER_STEP, end, judge
from .layout import TRACE, Field, Places, rules
from .motion import Steps, add_place, begin, close_step, extent_px, steps
from .stays import no_stays
from .zones import Zones

__all__ = ["CURSOR", "Monitor", "Verdict", "anomalies", "feed"]

BORN, MERGED, LOST = int(Kind.BORN), int(Kind.MERGED), int(Kind.LOST)

CURSOR = np.dtype(
    [
        ("rows", "<i8"),  # of the table in use
        ("alarms", "<i8"),  # in the buffer
        ("origin_us", "<i8"),  # the first record; -1 << 62 before it
        ("t_us", "<i8"),  # the record in hand
        ("event_index", "<i8"),
    ]
)


@njit(cache=True, nogil=True)
def _clear(table, places, i):  # type: ignore[no-untyped-def]
    trace = table[i]
    trace.ended_us = -1
    trace.settled = False
    trace.farthest_px = 0.0
    trace.moved_us = 0.0
    trace.slow_us = 0.0
    trace.braked_t = -1.0
    trace.jumped = False
    trace.raised[:] = 0
    trace.open[:] = 0
    trace.evidence_us[:] = 0.0
    places.since[i] = -1.0
    places.left[i] = -1.0
    places.raised[i] = False
    places.side[i] = 0
    places.line_raised[i] = False


@njit(cache=True, nogil=True)
def _forget(cur, table, places, stitch_us):  # type: ignore[no-untyped-def]
    """Remove the rows of tracks that ended too long ago; the last row moves into the free place."""
    i = 0
    while i < cur.rows:
        if table[i].ended_us >= 0 and cur.t_us - cur.origin_us - table[i].ended_us > stitch_us:
            cur.rows -= 1
            last = cur.rows
            table[i] = table[last]
            for part in (places.since, places.left, places.x, places.y):
                part[i] = part[last]
            for flags in (places.raised, places.line_raised):
                flags[i] = flags[last]
            places.side[i] = places.side[last]
        else:
            i += 1


@njit(cache=True, nogil=True)
def _ended_near(cur, table, x, y, stitch_px):  # type: ignore[no-untyped-def]
    """The row of the ended track with the nearest predicted position, -1 if none is near."""
    best = -1
    best_px = math.inf
    for i in range(cur.rows):
        trace = table[i]
        if trace.ended_us < 0 or not trace.settled:
            continue
        ahead_s = 1e-6 * (cur.t_us - cur.origin_us - trace.t) if trace.known else 0.0
        away_px = math.hypot(trace.x + trace.vx * ahead_s - x, trace.y + trace.vy * ahead_s - y)
        if away_px <= max(stitch_px, trace.radius) and away_px < best_px:
            best = i
            best_px = away_px
    return best


@njit(cache=True, nogil=True)
def _row(cur, table, places, track_id, born, x, y, stitch_us, stitch_px):  # type: ignore[no-untyped-def]
    """The row of a record's track; adds a row if it has none."""
    if not born:
        for i in range(cur.rows):
            if table[i].track_id == track_id and table[i].ended_us < 0:
                return i
    _forget(cur, table, places, stitch_us)
    i = _ended_near(cur, table, x, y, stitch_px)
    if i >= 0:
        table[i].ended_us = -1
    else:
        i = cur.rows
        cur.rows += 1
        _clear(table, places, i)
        begin(table[i], 0)
        table[i].birth_us = cur.t_us
    table[i].track_id = track_id
    return i


@njit(cache=True, nogil=True)
def feed(steps, rules, field, places, stays, stitch_us, stitch_px, cursor, table, records, first, spare, out):  # type: ignore[no-untyped-def]
    """Process records from `first` on; returns the first not processed: the table or the alarm buffer may be too small."""
    cur = cursor[0]
    for k in range(first, len(records)):
        if cur.rows == len(table) or cur.alarms + spare > len(out):
            return k
        record = records[k]
        if cur.origin_us == -(1 << 62):
            cur.origin_us = record.t_us
        cur.t_us = record.t_us
        cur.event_index = record.event_index
        ends = record.kind == LOST or record.kind == MERGED
        i = _row(cur, table, places, record.track_id, record.kind == BORN, record.x, record.y, stitch_us, stitch_px)
        trace = table[i]
        after_us = record.t_us - cur.origin_us
        step = after_us // steps.step_us
        if trace.n > 0 and (ends or step > trace.step):
            close_step(steps, trace, record.radius, extent_px(record))
            judge(rules, field, places, stays, i, cur, trace, out)
        if ends:
            end(rules, field, stays, cur, trace, out, record.kind == LOST)
            trace.ended_us = after_us
        else:
            trace.radius = record.radius
            trace.extent = extent_px(record)
            add_place(trace, after_us, step, steps.step_us, record.x, record.y)
    return len(records)


_ROWS = 32  # initial size of the table
_BUFFER = 256
_BEFORE = -(1 << 62)


@dataclass(frozen=True, eq=False)
class Verdict:
    """Result of `anomalies`: (n,) alarms of dtype `ALARM` by time, (lines, 2) crossings to the right and to the left, and the
    number of tracks."""

    alarms: NDArray[np.void]
    counts: NDArray[np.int64]
    tracks: int


class Monitor:
    """Streaming evaluation: feed records of a TrackLog in runs of any length; alarms do not depend on how they are split.

    Memory is constant per live track. Without a field of normal motion the rules on direction, speed, stopping and unusual
    places are inactive; without zones, those on zones and lines.

    Attributes:
        counts: (lines, 2) crossings so far, to the right and to the left.

    Raises:
        ConfigError: zones and field have different sensors, or the field was learned with other steps or windows.
    """

    def __init__(
        self, config: AnomalyConfig | None = None, normal: NormalMotion | None = None, zones: Zones | None = None
    ) -> None:
        self.config = config or AnomalyConfig()
        self._zones = zones or Zones()
        self._sensor = _one_sensor(normal, self._zones)
        self._steps, self._rules = steps(self.config), rules(self.config)
        if normal is not None and normal.measured != self._steps:
            raise ConfigError(f"{_listed(self._steps)}: must be as when normal motion was learned, {_listed(normal.measured)}")
        if normal is None:
            self._rules = self._rules._replace(place_support=0.0)
        self._field = normal.smoothed(self.config.min_support) if normal else _nothing_known()
        self._table = np.zeros(_ROWS, TRACE)
        self._places = _places(self._zones, _ROWS)
        self.counts = self._places.counts
        self._stays = no_stays()
        self._cursor = np.zeros(1, CURSOR)
        self._cursor["origin_us"] = self._last_us = _BEFORE
        self._records = 0

    def feed(self, records: NDArray[np.void]) -> NDArray[np.void]:
        """Process (n,) records of dtype `TRACK`, in order; returns the (k,) alarms that they raise, of dtype `ALARM`.

        Raises:
            TrackLogError: a record that is invalid, precedes one fed before, or lies off the sensor.
        """
        self._check(records)
        spare = 1 + ALARMS_PER_STEP + len(self._zones.zones) + len(self._zones.lines)
        out = np.zeros(max(_BUFFER, 2 * spare), ALARM)
        parts: list[NDArray[np.void]] = [out[:0]]
        done = 0
        while done < len(records):
            done = feed(
                self._steps, self._rules, self._field, self._places, self._stays,
                self.config.stitch_us, float(self.config.stitch_px), self._cursor, self._table, records, done, spare, out,
            )  # fmt: skip
            parts.append(out[: int(self._cursor["alarms"][0])].copy())
            self._cursor["alarms"] = 0
            if int(self._cursor["rows"][0]) == len(self._table):
                self._grow()
        self._records += len(records)
        return np.concatenate(parts)

    def _check(self, records: NDArray[np.void]) -> None:
        check_records(records, self._records)
        if not len(records):
            return
        if records["t_us"][0] < self._last_us:
            raise TrackLogError(
                f"record {self._records}: t_us = {records['t_us'][0]} follows {self._last_us}: time must not run back"
            )
        self._last_us = int(records["t_us"][-1])
        if self._sensor is None:
            return
        for axis, side, size in zip("xy", upright_sides(records), self._sensor, strict=True):
            off = (records[axis] + side / 2 < -0.5) | (records[axis] - side / 2 > size - 0.5)
            if off.any():
                row = int(np.argmax(off))
                width, height = self._sensor
                raise TrackLogError(
                    f"record {self._records + row}: {axis} = {records[axis][row]:g}: must lie on the {width}x{height} "
                    "pixels of the normal motion or the zones"
                )

    def _grow(self) -> None:
        more = len(self._table)
        self._table = np.concatenate((self._table, np.zeros(more, TRACE)))
        fresh = _places(self._zones, more)
        per_track = ("since", "left", "raised", "side", "x", "y", "line_raised")
        grown = {name: np.concatenate((getattr(self._places, name), getattr(fresh, name))) for name in per_track}
        self._places = self._places._replace(**grown)


def anomalies(
    log: RecordRuns, config: AnomalyConfig | None = None, normal: NormalMotion | None = None, zones: Zones | None = None
) -> Verdict:
    """All alarms of a log; see `Monitor`. Memory does not depend on the log's length.

    Raises:
        ConfigError, TrackLogError: as for `Monitor`.
    """
    monitor = Monitor(config, normal, zones)
    lives = LifeCounter()
    parts = [np.empty(0, ALARM)]
    for records in log.record_runs():
        parts.append(monitor.feed(records))
        lives.add(records)
    return Verdict(np.concatenate(parts), monitor.counts.copy(), lives.count)


def _one_sensor(normal: NormalMotion | None, zones: Zones) -> tuple[int, int] | None:
    if normal is None or zones.sensor is None:
        return normal.sensor if normal else zones.sensor
    if normal.sensor != zones.sensor:
        sizes = ["x".join(map(str, sensor)) for sensor in (zones.sensor, normal.sensor)]
        raise ConfigError(f"sensor: zones of {sizes[0]} and normal motion of {sizes[1]} pixels: must be of one sensor")
    return normal.sensor


def _listed(measured: Steps) -> str:
    return ", ".join(f"{name} = {value:g}" for name, value in measured._asdict().items())


def _nothing_known() -> Field:
    nothing = np.zeros((1, 1))
    return Field(1e12, *(nothing,) * 7, near_speed=np.full((1, 1), np.nan))


def _places(zones: Zones, tracks: int) -> Places:
    corners, starts = zones.corners()
    n_zones, n_lines = len(zones.zones), len(zones.lines)
    return Places(
        corners=corners,
        starts=starts,
        dwell_us=np.array([zone.dwell_us for zone in zones.zones], np.float64),
        lines=np.array([(*line.begin, *line.end) for line in zones.lines], np.float64).reshape(-1, 4),
        allowed=np.array([line.allowed for line in zones.lines], np.int64),
        counts=np.zeros((n_lines, 2), np.int64),
        since=np.full((tracks, n_zones), -1.0),
        left=np.full((tracks, n_zones), -1.0),
        raised=np.zeros((tracks, n_zones), np.bool_),
        side=np.zeros((tracks, n_lines), np.int64),
        x=np.zeros((tracks, n_lines)),
        y=np.zeros((tracks, n_lines)),
        line_raised=np.zeros((tracks, n_lines), np.bool_),
    )
