# SPDX-License-Identifier: Apache-2.0
"""Lifetimes and positions of tracks and true objects, in the common format of a report."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evcot.metrics import GroundTruth
from evcot.tracks.log import Kind, TrackLog
from evcot.tracks.record import class_label
from evcot.tracks.timeline import LIFE, OPEN, by_life, lifetimes

from .pack import LIVES_MAX, RECORDS_MAX, Column, longest_lives, thinned_events, thinned_records

__all__ = ["NO_CLASSES", "Classes", "Paths", "lasting", "log_classes", "log_paths", "truth_paths"]

SUBPIXELS = 16  # places and sizes are kept to a sixteenth of a pixel
_ANGLE_STEPS = 1_000  # to a rad
_ABSORBED_US = 8_000  # a track that merges sooner after its birth is counted, but neither listed nor drawn

POINT = np.dtype(
    [
        ("t_us", "<i8"),
        ("x", "<f8"),
        ("y", "<f8"),
        ("half_width", "<f8"),
        ("half_height", "<f8"),
        ("angle", "<f8"),
    ]
)


@dataclass(frozen=True)
class Classes:
    """When each life got another class.

    Attributes:
        labels: how the classes are shown.
        counts: (k,) number of changes of each life.
        t_us, label: (n,) by life, then by time: the time of a change, and the place of its label in `labels`.
    """

    labels: tuple[str, ...]
    counts: NDArray[np.int64]
    t_us: NDArray[np.int64]
    label: NDArray[np.int64]


_NOTHING = np.empty(0, np.int64)
NO_CLASSES = Classes((), _NOTHING, _NOTHING, _NOTHING)


@dataclass(frozen=True)
class Paths:
    """Lives of tracks or objects, and their points.

    Attributes:
        lives: (k,) of dtype `timeline.LIFE`, in order of birth.
        names: name of each life.
        counts: (k,) number of points of each life.
        points: of dtype `POINT`, sorted by life, then by time.
        moving: whether a position between two points is between their places; else a place holds until the next point.
        absorbed: number of tracks left out because they merged in the moment of their birth.
        all_lives, all_points: numbers before short lives and some moves were left out.
        classes: of a log with verdicts.
    """

    lives: NDArray[np.void]
    names: tuple[str, ...]
    counts: NDArray[np.int64]
    points: NDArray[np.void]
    moving: bool
    absorbed: int
    all_lives: int
    all_points: int
    classes: Classes = NO_CLASSES

    def columns(self, name: str, origin_us: int) -> dict[str, Column]:
        """Columns to pack, with names prefixed by `name`; times relative to `origin_us`."""
        lives, points = self.lives, self.points
        columns = {
            "slot": Column(lives["slot"]),
            "birth": Column(lives["birth_us"] - origin_us, delta=True),
            "end": Column(lives["end_us"] - origin_us, delta=True),
            "ended": Column(lives["ended"]),
            "other": Column(_survivors(lives)),
            "count": Column(self.counts),
            "t": Column(points["t_us"] - origin_us, delta=True),
        }
        for field in ("x", "y", "half_width", "half_height"):
            columns[field] = Column(np.rint(points[field] * SUBPIXELS).astype(np.int64), delta=True, scale=1 / SUBPIXELS)
        if self.classes.labels:
            columns["class_count"] = Column(self.classes.counts)
            columns["class_t"] = Column(self.classes.t_us - origin_us, delta=True)
            columns["class_label"] = Column(self.classes.label)
        angle = np.rint(points["angle"] * _ANGLE_STEPS).astype(np.int64)
        columns["angle"] = Column(angle, delta=True, scale=1 / _ANGLE_STEPS)
        return {f"{name}.{field}": column for field, column in columns.items()}


def log_paths(log: TrackLog, end_us: int, lives_max: int = LIVES_MAX, records_max: int = RECORDS_MAX) -> Paths:
    """A log's tracks; those still alive end at `end_us`."""
    everyone = lifetimes(log, end_us)
    shown = lasting(everyone)
    kept = longest_lives(everyone, lives_max, shown)
    lives = everyone[kept]
    order, first = by_life(log)
    life = np.empty(len(log.records), np.int64)  # of each record, -1 of one that is left out
    life[order] = np.repeat(np.where(kept, np.cumsum(kept) - 1, -1), np.diff(first, append=len(order)))
    kind = log.records["kind"].copy()
    kind[order[first]] = Kind.BORN  # the first record of one that was found again stays, too
    drawn = np.flatnonzero(life >= 0)
    drawn = drawn[thinned_records(kind[drawn], records_max)]
    records = log.records[drawn[np.argsort(life[drawn], kind="stable")]]
    points = np.empty(len(records), POINT)
    for field in ("t_us", "x", "y", "angle"):
        points[field] = records[field]
    points["half_width"], points["half_height"] = records["width"] / 2, records["height"] / 2
    names = tuple(str(track_id) for track_id in lives["track_id"].tolist())
    counts = np.bincount(life[drawn], minlength=len(lives))
    absorbed = int(np.count_nonzero(~shown))
    all_points = int(np.diff(first, append=len(order))[shown].sum())
    classes = log_classes(log, lives)
    return Paths(lives, names, counts, points, False, absorbed, len(everyone) - absorbed, all_points, classes)


def log_classes(log: TrackLog, lives: NDArray[np.void]) -> Classes:
    """The class of each life over time, that of its track's last verdict; at its birth that of an earlier life of the track."""
    if not len(log.verdicts):
        return NO_CLASSES
    class_ids, number = np.unique(log.verdicts["class_id"], return_inverse=True)
    order = np.argsort(log.verdicts["track_id"], kind="stable")
    track_id, t_us = (log.verdicts[name][order] for name in ("track_id", "t_us"))
    begin, end = (np.searchsorted(track_id, lives["track_id"], side) for side in ("left", "right"))
    times_us, labels = [_NOTHING], [_NOTHING]
    for life, first, past in zip(lives, begin.tolist(), end.tolist(), strict=True):
        own_us = t_us[first:past]
        before = max(int(np.searchsorted(own_us, life["birth_us"], "right")) - 1, 0)
        until = int(np.searchsorted(own_us, life["end_us"], "right"))
        own = number[order[first + before : first + until]] if until > before else _NOTHING
        changes = np.flatnonzero(np.diff(own, prepend=-1))
        times_us.append(np.maximum(own_us[before + changes], life["birth_us"]))
        labels.append(own[changes])
    counts = np.array([len(own) for own in labels[1:]], np.int64)
    shown = tuple(class_label(one, log.class_names) for one in class_ids.tolist())
    return Classes(shown, counts, np.concatenate(times_us), np.concatenate(labels))


def lasting(lives: NDArray[np.void]) -> NDArray[np.bool_]:
    """Which rows of dtype `LIFE` did not merge in the moment of their birth, (k,) bool."""
    return np.asarray((lives["ended"] != Kind.MERGED) | (lives["end_us"] - lives["birth_us"] >= _ABSORBED_US), np.bool_)


def truth_paths(truth: GroundTruth, records_max: int = RECORDS_MAX) -> Paths:
    """True objects where they count; one that is absent for an instant or more starts a new life."""
    counted = truth.objects[truth.objects["counted"]]
    objects = counted[np.argsort(counted["object"], kind="stable")]  # within an object by time
    begins = np.diff(objects["object"], prepend=-1) != 0
    begins |= np.diff(objects["frame"], prepend=-2) != 1
    life = np.cumsum(begins) - 1
    first = np.flatnonzero(begins)
    last = np.append(first[1:], len(objects)) - 1 if len(first) else first
    step_us = int(np.median(np.diff(truth.instants_us))) if len(truth.instants_us) > 1 else 1
    lives = np.empty(len(first), LIFE)
    lives["track_id"], lives["slot"] = np.arange(len(first)), 0
    lives["birth_us"] = truth.instants_us[objects["frame"][first]]
    lives["end_us"] = truth.instants_us[objects["frame"][last]] + step_us
    lives["end_us"] = np.minimum(lives["end_us"], truth.instants_us[-1] if len(truth.instants_us) else 0)
    lives["ended"], lives["other_id"] = np.where(objects["frame"][last] == len(truth.instants_us) - 1, OPEN, Kind.LOST), -1
    in_time = np.argsort(lives["birth_us"], kind="stable")[:LIVES_MAX]
    rank = np.full(len(first), -1)
    rank[in_time] = np.arange(len(in_time))
    rows = rank[life]
    chosen = np.flatnonzero(rows >= 0)
    if len(chosen) > records_max:
        chosen = chosen[np.union1d(thinned_events(len(chosen), records_max), np.flatnonzero(begins[chosen]))]
    chosen = chosen[np.argsort(rows[chosen], kind="stable")]
    points = np.zeros(len(chosen), POINT)
    points["t_us"] = truth.instants_us[objects["frame"][chosen]]
    points["x"], points["y"] = objects["x"][chosen], objects["y"][chosen]
    points["half_width"], points["half_height"] = objects["width"][chosen] / 2, objects["height"][chosen] / 2
    kept = lives[in_time]
    names = tuple(truth.ids[i] for i in objects["object"][first][in_time].tolist())
    counts = np.bincount(rows[chosen], minlength=len(kept))
    return Paths(kept, names, counts, points, True, 0, len(first), len(objects))


def _survivors(lives: NDArray[np.void]) -> NDArray[np.int64]:
    """For each life, the row of the one that it merged into, -1 where there is none or it is not drawn."""
    rows: dict[int, list[int]] = {}
    for i, track_id in enumerate(lives["track_id"].tolist()):
        rows.setdefault(track_id, []).append(i)
    births_us = lives["birth_us"].tolist()
    found = np.full(len(lives), -1, np.int64)
    for i, (other, end_us) in enumerate(zip(lives["other_id"].tolist(), lives["end_us"].tolist(), strict=True)):
        found[i] = max((row for row in rows.get(other, ()) if births_us[row] <= end_us), default=-1)
    return found
