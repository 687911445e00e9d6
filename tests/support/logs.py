# SPDX-License-Identifier: Apache-2.0
"""Track logs written by hand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from evcot.tracks.log import TRACK, Kind, TrackLog

__all__ = ["HEIGHT", "RADIUS", "WIDTH", "Row", "log_of"]

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
