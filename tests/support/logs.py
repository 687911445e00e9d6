# SPDX-License-Identifier: Apache-2.0
"""Track logs written by hand, and recordings whose events come in steps, with their exact truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import evcot
from evcot.events import Events, Recording
from evcot.tracks.log import TRACK, VERDICT, Kind, TrackLog

__all__ = ["HEIGHT", "RADIUS", "WIDTH", "Row", "Square", "bursts", "centre_errors_px", "log_of", "verdicts_of"]


Row = tuple[int, Kind, int, float, float] | tuple[int, Kind, int, float, float, int]
RADIUS, WIDTH, HEIGHT = 8.0, 20.0, 12.0


def log_of(rows: Sequence[Row], engine: str = "by hand", unit_us: int = 1) -> TrackLog:
    """A log from (time, kind, track_id, x, y[, other_id]) rows; the event index and the slot are the time and the id."""
    records = np.zeros(len(rows), TRACK)
    for record, row in zip(records, rows, strict=True):
        time, record["kind"], record["track_id"], record["x"], record["y"] = row[:5]
        record["t_us"], record["event_index"], record["slot"] = time * unit_us, time, row[2]
        record["other_id"] = row[5] if len(row) > 5 else -1
    records["radius"], records["width"], records["height"], records["confidence"] = RADIUS, WIDTH, HEIGHT, 0.5
    return TrackLog(engine, records, np.empty(0, np.int16))


def verdicts_of(*rows: tuple[int, int, int]) -> NDArray[np.void]:
    """Verdicts from (time, track, class) rows."""
    made = np.zeros(len(rows), VERDICT)
    for row, (t_us, track_id, class_id) in enumerate(rows):
        made["t_us"][row], made["track_id"][row], made["class_id"][row] = t_us, track_id, class_id
    return made


@dataclass(frozen=True)
class Square:
    """The outline of a square that moves: its corner in pixels at first, its velocity in pixels per second, its side."""

    x: float
    y: float
    vx: float
    vy: float
    side: int = 40

    def corner(self, t_us: int) -> tuple[int, int]:
        """Its top left pixel at this time."""
        return int(self.x + self.vx * t_us / 1e6), int(self.y + self.vy * t_us / 1e6)

    def outline(self, t_us: int) -> NDArray[np.int64]:
        """(4 side, 2): its pixels at this time; each corner stands twice."""
        along, still = np.arange(self.side), np.zeros(self.side, np.int64)
        edges = [(along, still), (along, still + self.side - 1), (still, along), (still + self.side - 1, along)]
        pixels: NDArray[np.int64] = np.concatenate([np.stack(edge, axis=1) for edge in edges]) + np.array(self.corner(t_us))
        return pixels


def bursts(
    step_ms: int, squares: list[Square], sensor: tuple[int, int], noise_hz: float = 0.0, lasts_ms: int = 2_000
) -> Events:
    """All events of a step at one time, in random order; noise, in Hz per pixel, comes with them."""
    rng = np.random.default_rng(step_ms)
    parts, times = [], []
    for t_us in range(0, 1_000 * lasts_ms, 1_000 * step_ms):
        noise = rng.integers(0, sensor, (rng.poisson(noise_hz * sensor[0] * sensor[1] * step_ms / 1e3), 2))
        parts.append(rng.permutation(np.concatenate([*(square.outline(t_us) for square in squares), noise])))
        times.append(np.full(len(parts[-1]), t_us))
    places, t = np.concatenate(parts), np.concatenate(times)
    seen = ((places >= 0) & (places < sensor)).all(axis=1)
    x, y = places[seen].astype(np.uint16).T
    return Events(t[seen], x, y, np.ones(int(seen.sum()), np.uint8))


def centre_errors_px(
    engine: str, step_ms: int, side: int, per_burst: float, slope: float, rows: bool = False
) -> NDArray[np.float64]:
    """Distance of the nearest track from the centre of a square, at each of the bursts 20 to 39; infinite without a track.

    Args:
        per_burst: displacement from burst to burst, in sides.
        slope: vertical displacement, divided by the horizontal one.
        rows: events of a burst come row by row, not in random order.
    """
    vx = side * per_burst / (step_ms * 1e-3) / np.hypot(1, slope)
    square = Square(20.3, 20.7, vx, slope * vx, side)
    sensor = 1280, 720
    events = bursts(step_ms, [square], sensor, lasts_ms=40 * step_ms)
    if rows:
        order = np.lexsort((events.x, events.y, events.t_us))
        events = Events(events.t_us[order], events.x[order], events.y[order], events.p[order])
    records = evcot.track(Recording(events, *sensor, "bursts"), engine).records
    states = records[records["kind"] <= Kind.MOVED]
    errors_px = []
    for t_us in range(20_000 * step_ms, 40_000 * step_ms, 1_000 * step_ms):
        recent = states[(states["t_us"] <= t_us) & (states["t_us"] > t_us - 2_000 * step_ms)]
        x, y = (corner + (side - 1) / 2 for corner in square.corner(t_us))
        newest = [recent[recent["track_id"] == track_id][-1] for track_id in np.unique(recent["track_id"])]
        errors_px.append(min((np.hypot(state["x"] - x, state["y"] - y) for state in newest), default=np.inf))
    return np.array(errors_px)
