# SPDX-License-Identifier: Apache-2.0
"""Evaluation of alarms against planted anomalies: detection rate, detection delay, and false alarms.

An alarm is attributed to the object whose box, grown by a margin, contains its position at its time; of several, to the one
with the nearest centre. It detects an anomaly if that is the anomaly's object, the time is during it or shortly after, and the
kinds agree. An alarm of another kind on such an object is not counted as false: a car that stops on the shoulder has also left
the road. All others are false.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..scenes.truth import Label, Truth
from ..tracks.log import TRACK, Kind, TrackLog
from .alarm import Anomaly

__all__ = ["FOUND_BY", "AlarmScores", "score_alarms", "truth_log"]

FOUND_BY: dict[str, Anomaly] = {
    "wrong_way": Anomaly.WRONG_WAY,
    "stopping": Anomaly.STOPPING,
    "crossing": Anomaly.CROSSING,
    "loitering": Anomaly.LOITERING,
    "speeding": Anomaly.FAST,
}

_MARGIN_PX = 12.0
_AFTER_US = 1_000_000
_HIDDEN = 0.5  # a box that is occluded by more than this is not tracked


@dataclass(frozen=True)
class AlarmScores:
    """The result of `score_alarms`.

    Attributes:
        minutes: duration of the scored recording.
        planted, found: number of anomalies by kind.
        seconds_to_alarm: by kind, time from the begin of each detected anomaly to its first alarm.
        false_alarms: number by kind of alarm.
        missed: the labels that were not detected; false_rows: indices of the false alarms.
    """

    minutes: float
    planted: dict[str, int]
    found: dict[str, int]
    seconds_to_alarm: dict[str, list[float]]
    false_alarms: dict[str, int]
    missed: list[Label] = field(default_factory=list)
    false_rows: list[int] = field(default_factory=list)

    @property
    def share_found(self) -> float:
        """Share of all anomalies that were detected; 1 if there are none."""
        return sum(self.found.values()) / max(sum(self.planted.values()), 1) if self.planted else 1.0

    @property
    def false_per_minute(self) -> float:
        """False alarms of all kinds per minute."""
        return sum(self.false_alarms.values()) / self.minutes


def score_alarms(alarms: NDArray[np.void], truth: Truth, duration_us: int) -> AlarmScores:
    """Score (n,) alarms of dtype `ALARM` against a truth with labels, on the same clock."""
    owner = [_object_at(truth.samples, int(alarm["t_us"]), alarm["x"], alarm["y"]) for alarm in alarms]
    kinds = sorted({label.kind for label in truth.labels})
    scores = AlarmScores(
        minutes=duration_us / 60e6,
        planted={kind: sum(label.kind == kind for label in truth.labels) for kind in kinds},
        found=dict.fromkeys(kinds, 0),
        seconds_to_alarm={kind: [] for kind in kinds},
        false_alarms={},
    )
    for label in truth.labels:
        hits = [
            int(alarm["t_us"])
            for alarm, object_id in zip(alarms, owner, strict=True)
            if object_id == label.object_id and alarm["kind"] == FOUND_BY[label.kind] and _during(label, int(alarm["t_us"]))
        ]
        if hits:
            scores.found[label.kind] += 1
            scores.seconds_to_alarm[label.kind].append((min(hits) - label.begin_us) * 1e-6)
        else:
            scores.missed.append(label)
    for row, (alarm, object_id) in enumerate(zip(alarms, owner, strict=True)):
        if not any(label.object_id == object_id and _during(label, int(alarm["t_us"])) for label in truth.labels):
            name = Anomaly(int(alarm["kind"])).name.lower()
            scores.false_alarms[name] = scores.false_alarms.get(name, 0) + 1
            scores.false_rows.append(row)
    return scores


def _during(label: Label, t_us: int) -> bool:
    return label.begin_us <= t_us <= label.end_us + _AFTER_US


def _object_at(samples: NDArray[np.void], t_us: int, x: float, y: float) -> int | None:
    """The object at a position, by the last sample of each that is not older than `_AFTER_US`."""
    begin, end = np.searchsorted(samples["t_us"], (t_us - _AFTER_US, t_us), "left")
    latest = samples[begin : end + 1][::-1]
    _, first = np.unique(latest["object_id"], return_index=True)
    boxes = latest[first]
    ahead_s = np.minimum((t_us - boxes["t_us"]) * 1e-6, 0.1)
    dx, dy = (np.abs(boxes[axis] + ahead_s * boxes[f"v{axis}"] - place) for axis, place in (("x", x), ("y", y)))
    held = (dx <= boxes["width"] / 2 + _MARGIN_PX) & (dy <= boxes["height"] / 2 + _MARGIN_PX)
    if not held.any():
        return None
    return int(boxes["object_id"][held][np.argmin(np.hypot(dx, dy)[held])])


def truth_log(truth: Truth) -> TrackLog:
    """The truth as the log of an error-free tracker: one track per object while it is visible and not occluded."""
    samples = truth.samples
    seen = samples[samples["visible"] & (samples["occluded"] <= _HIDDEN)]
    seen = seen[np.argsort(seen["object_id"], kind="stable")]
    step_us = np.diff(np.unique(samples["t_us"])).max(initial=1)
    new = np.ones(len(seen), bool)
    new[1:] = (np.diff(seen["object_id"]) != 0) | (np.diff(seen["t_us"]) > step_us)
    track_id = np.cumsum(new) - 1
    records = _records(seen, track_id, np.where(new, Kind.BORN, Kind.MOVED))
    last = np.append(new[1:], True)[: len(seen)]
    ends = _records(seen[last], track_id[last], Kind.LOST)
    ends["t_us"] += step_us
    both = np.concatenate((records, ends))
    both = both[np.argsort(both["t_us"], kind="stable")]
    both["event_index"] = np.arange(len(both))
    return TrackLog("truth", both, np.empty(0, np.int16))


def _records(seen: NDArray[np.void], track_id: NDArray[np.int64], kind: Any) -> NDArray[np.void]:
    records = np.zeros(len(seen), TRACK)
    for name in ("t_us", "x", "y"):
        records[name] = seen[name]
    records["track_id"], records["kind"], records["other_id"] = track_id, kind, -1
    records["width"], records["height"] = seen["width"], seen["height"]
    records["radius"] = np.maximum(seen["width"], seen["height"]) / 2
    records["confidence"] = 1.0
    return records
