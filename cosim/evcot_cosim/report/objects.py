# SPDX-License-Identifier: Apache-2.0
"""Objects: which tracks of all sides, and which true object, are the same thing. Every view of a report uses these numbers.

Two tracks are near each other while their centres are at most 12 px apart, or 0.35 of the smaller box's longer side.

1. Each true object is an object. A track belongs to the true object that it is near for the longest time, if that is at least
   40 ms and a quarter of the track's lifetime.
2. Other tracks of different sides form an object if they are near each other for at least 40 ms and a quarter of the shorter
   lifetime, the longest time first. Of one side an object has one track at a time: overlaps of up to 40 ms are allowed.
3. Every remaining track is an object of its own.

Objects are numbered from 1 in the order in which they appear.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .paths import Paths

__all__ = ["TRUTH", "objects_of"]

TRUTH = "truth"  # the side whose lives are true objects

_NEAR_PX = 12.0
_NEAR_SIDE = 0.35  # of the smaller box's longer side
_NEAR_US = 40_000
_NEAR_LIFE = 0.25  # of the lifetime: of a track that follows a true object, of the shorter of two tracks
_SHORTEST_PART = 0.1  # of a recording: in a shorter one less than `_NEAR_US` is enough
_STEP_US = 10_000  # between two comparisons
_STEPS_MIN, _STEPS_MAX = 50, 20_000  # of a recording
_PAIRS = 1 << 20  # compared at a time


class _Sampled(NamedTuple):
    """The lives of a side at the times of comparison: (n,) each, in order of time."""

    time: NDArray[np.int64]
    life: NDArray[np.int64]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    width: NDArray[np.float64]
    height: NDArray[np.float64]


class _Near(NamedTuple):
    """For how long a life of one side and a life of another are near each other, longest first."""

    one: list[int]
    other: list[int]
    us: list[int]


def objects_of(paths: Mapping[str, Paths]) -> dict[str, NDArray[np.int64]]:
    """The number of the object of each life, (k,) int64 by side.

    Args:
        paths: those of each side, in the order in which a report names the sides; those of the truth under `TRUTH`.
    """
    spans = [(int(own.lives["birth_us"].min()), int(own.lives["end_us"].max())) for own in paths.values() if len(own.lives)]
    begin_us, end_us = (min(begin for begin, _ in spans), max(end for _, end in spans)) if spans else (0, 0)
    span_us = max(end_us - begin_us, 1)
    step_us = max(1, -(-span_us // _STEPS_MAX), min(_STEP_US, span_us // _STEPS_MIN))
    needed_us = min(_NEAR_US, int(_SHORTEST_PART * span_us))
    times_us = np.arange(begin_us, end_us + 1, step_us)
    sampled = {side: _sample(own, times_us) for side, own in paths.items()}
    groups = {side: np.full(len(own.lives), -1, np.int64) for side, own in paths.items()}
    count = 0
    if TRUTH in paths:
        ids = {name: i for i, name in enumerate(dict.fromkeys(paths[TRUTH].names))}
        groups[TRUTH][:] = [ids[name] for name in paths[TRUTH].names]
        count = len(ids)
    engines = [side for side in paths if side != TRUTH]
    lifetimes_us = {side: (own.lives["end_us"] - own.lives["birth_us"]).tolist() for side, own in paths.items()}
    for side in engines if TRUTH in paths else ():
        for life, true, us in zip(*_near(sampled[side], sampled[TRUTH], step_us), strict=True):
            if groups[side][life] < 0 and us >= max(needed_us, _NEAR_LIFE * lifetimes_us[side][life]):
                groups[side][life] = groups[TRUTH][true]
    together = _Together(paths, {side: np.flatnonzero(groups[side] < 0).tolist() for side in engines}, needed_us)
    candidates = [
        (us, (one, life), (other, partner))
        for one, other in combinations(engines, 2)
        for life, partner, us in zip(*_near(sampled[one], sampled[other], step_us), strict=True)
        if us >= max(needed_us, _NEAR_LIFE * min(lifetimes_us[one][life], lifetimes_us[other][partner]))
        and groups[one][life] < 0
        and groups[other][partner] < 0
    ]
    for _, track, partner_track in sorted(candidates, key=lambda candidate: -candidate[0]):
        together.join(track, partner_track)
    for members in together.groups():
        for side, life in members:
            groups[side][life] = count
        count += 1
    first_us = np.full(count, np.iinfo(np.int64).max)
    for side, own in paths.items():
        np.minimum.at(first_us, groups[side], own.lives["birth_us"])
    number = np.empty(count, np.int64)
    number[np.argsort(first_us, kind="stable")] = 1 + np.arange(count)
    return {side: number[own] for side, own in groups.items()}


class _Together:
    """Tracks, as (side, life), that are grouped step by step; of one side a group has one track at a time."""

    def __init__(self, paths: Mapping[str, Paths], alone: Mapping[str, list[int]], overlap_us: int) -> None:
        self._spans = {side: own.lives[["birth_us", "end_us"]].tolist() for side, own in paths.items()}
        self._overlap_us = overlap_us
        self._members = {(side, life): [(side, life)] for side, lives in alone.items() for life in lives}

    def join(self, one: tuple[str, int], other: tuple[str, int]) -> None:
        """Make one group of those of two tracks, where no two tracks of a side are there at the same time."""
        members, others = self._members[one], self._members[other]
        if members is others or any(self._overlap(a, b) for a in members for b in others):
            return
        members += others
        for track in others:
            self._members[track] = members

    def groups(self) -> list[list[tuple[str, int]]]:
        """All groups."""
        return list({id(members): members for members in self._members.values()}.values())

    def _overlap(self, one: tuple[str, int], other: tuple[str, int]) -> bool:
        if one[0] != other[0]:
            return False
        (begin_us, end_us), (other_begin_us, other_end_us) = (self._spans[side][life] for side, life in (one, other))
        return bool(min(end_us, other_end_us) - max(begin_us, other_begin_us) > self._overlap_us)


def _sample(paths: Paths, times_us: NDArray[np.int64]) -> _Sampled:
    """Where each life is at these (k,) ascending times, from its birth until its end."""
    points, count = paths.points, len(paths.points)
    life = np.repeat(np.arange(len(paths.lives)), paths.counts)
    last = np.append(life[1:] != life[:-1], True) if count else np.empty(0, np.bool_)
    begin = np.searchsorted(times_us, points["t_us"], "left")
    end = np.append(begin[1:], 0)[:count]
    end[last] = np.searchsorted(times_us, paths.lives["end_us"][life[last]], "left")
    repeats = np.maximum(end - begin, 0)
    point = np.repeat(np.arange(count), repeats)
    time = np.arange(len(point)) - np.repeat(np.cumsum(repeats) - repeats, repeats) + begin[point]
    order = np.argsort(time, kind="stable")
    point, time = point[order], time[order]
    x, y = points["x"][point], points["y"][point]
    if paths.moving and count:
        following = np.where(last[point], point, point + 1)
        passed_us = times_us[time] - points["t_us"][point]
        part = passed_us / np.maximum(points["t_us"][following] - points["t_us"][point], 1)
        x, y = (at + part * (points[axis][following] - at) for at, axis in ((x, "x"), (y, "y")))
    return _Sampled(time, life[point], x, y, 2 * points["half_width"][point], 2 * points["half_height"][point])


def _near(one: _Sampled, other: _Sampled, step_us: int) -> _Near:
    """All lives of two sides that are near each other at a time of comparison at least."""
    first, end = np.searchsorted(other.time, one.time, "left"), np.searchsorted(other.time, one.time, "right")
    counts = end - first
    lives = int(other.life.max(initial=0)) + 1
    keys: list[NDArray[np.int64]] = []
    cuts = np.searchsorted(np.cumsum(counts), np.arange(0, int(counts.sum()) + _PAIRS, _PAIRS)) if len(counts) else [0]
    for from_row, to_row in zip(cuts, [*cuts[1:], len(counts)], strict=True):
        rows = np.arange(from_row, to_row)
        a = np.repeat(rows, counts[rows])
        within = np.arange(len(a)) - np.repeat(np.cumsum(counts[rows]) - counts[rows], counts[rows])
        b = first[a] + within
        sides = [np.minimum(getattr(one, axis)[a], getattr(other, axis)[b]) for axis in ("width", "height")]
        reach = np.maximum(_NEAR_PX, _NEAR_SIDE * np.maximum(*sides))
        near = np.hypot(one.x[a] - other.x[b], one.y[a] - other.y[b]) <= reach
        keys.append(one.life[a[near]] * lives + other.life[b[near]])
    found, samples = np.unique(np.concatenate([np.empty(0, np.int64), *keys]), return_counts=True)
    order = np.argsort(-samples, kind="stable")
    pairs, us = found[order], samples[order] * step_us
    return _Near((pairs // lives).tolist(), (pairs % lives).tolist(), us.tolist())
