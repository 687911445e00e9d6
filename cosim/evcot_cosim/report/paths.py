# SPDX-License-Identifier: Apache-2.0
"""Lifetimes and positions of tracks and true objects, in the common format of a report."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evcot.metrics import GroundTruth
from evcot.tracks.log import Kind, TrackLog
from evcot.tracks.timeline import LIFE, OPEN, by_life, lifetimes

from .pack import Column
from .subsample import LIVES_MAX, RECORDS_MAX, longest_lives, thinned_events, thinned_records

__all__ = ["POINT", "Paths", "log_paths", "truth_paths"]

SUBPIXELS = 16  # places and sizes are kept to a sixteenth of a pixel
_ANGLE_STEPS = 1_000  # to a rad

POINT = np.dtype(
    [
        ("t_us", "<i8"),
        ("x", "<f8"),
        ("y", "<f8"),
        ("half_width", "<f8"),
        ("half_height", "<f8"),
        ("angle", "<f8"),
        ("vx", "<f8"),
        ("vy", "<f8"),
        ("n_ev", "<i8"),
    ]
)


@dataclass(frozen=True)
class Paths:
    """Lives of tracks or objects, and their points.

    Attributes:
        lives: (k,) of dtype `timeline.LIFE`, in order of birth.
        lanes: (k,) lane in which to draw each; lives in one lane do not overlap. The hardware's lanes are its slots.
        names: name of each life.
        counts: (k,) number of points of each life.
        points: of dtype `POINT`, sorted by life, then by time.
        all_lives, all_points: numbers before short lives and some moves were left out.
    """

    lives: NDArray[np.void]
    lanes: NDArray[np.int64]
    names: tuple[str, ...]
    counts: NDArray[np.int64]
    points: NDArray[np.void]
    all_lives: int
    all_points: int

    @property
    def moving(self) -> bool:
        """Whether any point has a velocity, in pixels per second; 0 stands for unknown."""
        return bool(self.points["vx"].any() or self.points["vy"].any())

    def columns(self, name: str, origin_us: int) -> dict[str, Column]:
        """Columns to pack, with names prefixed by `name`; times relative to `origin_us`."""
        lives, points = self.lives, self.points
        columns = {
            "slot": Column(lives["slot"]),
            "lane": Column(self.lanes),
            "birth": Column(lives["birth_us"] - origin_us, delta=True),
            "end": Column(lives["end_us"] - origin_us, delta=True),
            "ended": Column(lives["ended"]),
            "other": Column(_survivors(lives)),
            "count": Column(self.counts),
            "t": Column(points["t_us"] - origin_us, delta=True),
            "n_ev": Column(points["n_ev"], delta=True),
        }
        for field in ("x", "y", "half_width", "half_height"):
            columns[field] = Column(np.rint(points[field] * SUBPIXELS).astype(np.int64), delta=True, scale=1 / SUBPIXELS)
        angle = np.rint(points["angle"] * _ANGLE_STEPS).astype(np.int64)
        columns["angle"] = Column(angle, delta=True, scale=1 / _ANGLE_STEPS)
        if self.moving:
            for field in ("vx", "vy"):
                columns[field] = Column(np.rint(points[field]).astype(np.int64), delta=True)
        return {f"{name}.{field}": column for field, column in columns.items()}


def log_paths(log: TrackLog, end_us: int, lives_max: int = LIVES_MAX, records_max: int = RECORDS_MAX) -> Paths:
    """A log's tracks; those still alive end at `end_us`."""
    everyone = lifetimes(log, end_us)
    kept = longest_lives(everyone, lives_max)
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
    for field in ("t_us", "x", "y", "n_ev", "angle", "vx", "vy"):
        points[field] = records[field]
    points["half_width"], points["half_height"] = records["width"] / 2, records["height"] / 2
    names = tuple(str(track_id) for track_id in lives["track_id"].tolist())
    lanes = _used(lives["slot"]) if log.engine.startswith("cot") else _lanes(lives)
    return Paths(lives, lanes, names, np.bincount(life[drawn], minlength=len(lives)), points, len(everyone), len(log.records))


def truth_paths(truth: GroundTruth, records_max: int = RECORDS_MAX) -> Paths:
    """True objects; one that is absent for an instant or more starts a new life."""
    objects = truth.objects[np.argsort(truth.objects["object"], kind="stable")]  # within an object by time
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
    return Paths(kept, _lanes(kept), names, counts, points, len(first), len(objects))


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


def _used(slots: NDArray[np.int16]) -> NDArray[np.int64]:
    """Slots numbered by rank among those in use."""
    return np.asarray(np.unique(slots, return_inverse=True)[1], np.int64)


def _lanes(lives: NDArray[np.void]) -> NDArray[np.int64]:
    """The lowest lane that is free during each life; lives in order of birth."""
    free_at: list[int] = []
    lanes = np.empty(len(lives), np.int64)
    for i, (birth_us, end_us) in enumerate(zip(lives["birth_us"].tolist(), lives["end_us"].tolist(), strict=True)):
        lane = next((lane for lane, until_us in enumerate(free_at) if until_us < birth_us), len(free_at))
        free_at[lane : lane + 1] = [end_us]
        lanes[i] = lane
    return lanes
