# SPDX-License-Identifier: Apache-2.0
"""Track logs for tests."""

from __future__ import annotations

import numpy as np

from evcot.metrics import GroundTruth
from evcot.tracks.log import TRACK, Kind, TrackLog

Record = tuple[int, int, Kind, float, float]


def logged(*records: Record, width: float = 10.0, height: float = 10.0, angle: float = 0.0) -> TrackLog:
    """A log of (t_us, track_id, kind, x, y); the search window is larger than the box."""
    rows = np.zeros(len(records), TRACK)
    for name, column in zip(("t_us", "track_id", "kind", "x", "y"), zip(*records, strict=True), strict=False):
        rows[name] = column
    rows["width"], rows["height"], rows["angle"], rows["radius"], rows["other_id"] = width, height, angle, 50.0, -1
    return TrackLog("test", rows, np.empty(0, np.int16))


def following(truth: GroundTruth, late_us: int = 0) -> TrackLog:
    """The truth as its own tracker, with a delay; a track is lost 1 us after the last instant of its object."""
    records = []
    for number in range(len(truth.ids)):
        own = truth.objects[truth.objects["object"] == number]
        t_us = truth.instants_us[own["frame"]] + late_us
        kinds = [Kind.BORN] + [Kind.MOVED] * (len(own) - 1) + [Kind.LOST]
        own, t_us = np.append(own, own[-1:]), np.append(t_us, t_us[-1] + 1)
        records += zip(t_us.tolist(), own["object"].tolist(), kinds, own["x"].tolist(), own["y"].tolist(), strict=True)
    return logged(*sorted(records))
