# SPDX-License-Identifier: Apache-2.0
"""The oracle: tracks with true identity, whose boxes are the extents of the objects' events. No tracker is told as much.

What it misses is in the truth and not in the events: sides that send none, objects that stand still.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evcot.tracks.log import TRACK, Kind, TrackLog
from field.member import Member

__all__ = ["oracle_log"]

_WITHIN_US = 20_000  # before an instant: like trackers, the oracle knows no later events
_MOST = 300  # events, the latest: those of a fast object lie along its way
_MARGIN_PX = 1.0  # around the truth's box
_LEAST = 8  # events: with fewer an object cannot be seen
_BEYOND = 0.02  # share of the events beyond each side: noise within the truth's box


def oracle_log(member: Member) -> TrackLog:
    """At each instant of the truth, a track for each object that counts."""
    events, truth = member.recording.events, member.truth
    objects = truth.objects[truth.objects["counted"]]
    instants_us = truth.instants_us[objects["frame"]]
    spans = np.searchsorted(events.t_us, [instants_us - _WITHIN_US, instants_us + 1]).T
    records = np.zeros(len(objects), TRACK)
    records["t_us"], records["track_id"], records["kind"], records["other_id"] = instants_us, objects["object"], Kind.MOVED, -1
    seen = np.zeros(len(objects), np.bool_)
    for number, (one, (begin, end)) in enumerate(zip(objects, spans, strict=True)):
        x, y = events.x[begin:end], events.y[begin:end]
        off = np.abs(x - one["x"]) - one["width"] / 2, np.abs(y - one["y"]) - one["height"] / 2
        latest = np.flatnonzero(np.maximum(*off) <= _MARGIN_PX)[-_MOST:]
        seen[number] = len(latest) >= _LEAST
        if seen[number]:
            _extents(records[number : number + 1], x[latest], y[latest])
    return TrackLog("oracle", records[seen], np.empty(0, np.int16))


def _extents(record: NDArray[np.void], x: NDArray[np.uint16], y: NDArray[np.uint16]) -> None:
    for axis, side, column in (("x", "width", x), ("y", "height", y)):
        low, high = np.quantile(column, [_BEYOND, 1 - _BEYOND])
        record[axis], record[side] = (low + high) / 2, high - low + 1
    record["radius"] = max(record["width"][0], record["height"][0]) / 2
