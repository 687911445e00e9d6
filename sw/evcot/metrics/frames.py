# SPDX-License-Identifier: Apache-2.0
"""Alignment of truth and tracks: for each instant the objects, the outputs, and the similarity of every pair.

All scores are computed from this data.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..tracks.record import upright_sides
from .rule import Rule
from .truth import GroundTruth

__all__ = ["Frames", "Matches", "Pairs", "line_up"]

Ids = tuple[NDArray[np.int64], ...]


@dataclass(frozen=True, eq=False)
class Frames:
    """f instants; objects and tracks are numbered from 0, with each number at most once per instant.

    Attributes:
        truth, tracks: per instant, the numbers of the g objects and the k tracks.
        similarity: per instant, (g, k) from 0 to 1.
        n_truth, n_tracks: total number of objects and of tracks.
    """

    truth: Ids
    tracks: Ids
    similarity: tuple[NDArray[np.float64], ...]
    n_truth: int
    n_tracks: int

    @cached_property
    def truth_lengths(self) -> NDArray[np.int64]:
        """(n_truth,) number of instants at which each object is present."""
        return _lengths(self.truth, self.n_truth)

    @cached_property
    def track_lengths(self) -> NDArray[np.int64]:
        """(n_tracks,) number of instants at which each track is present."""
        return _lengths(self.tracks, self.n_tracks)

    def restricted(self, objects: NDArray[np.bool_], outputs: NDArray[np.bool_]) -> Frames:
        """Some objects and outputs alone, numbered anew.

        Args:
            objects, outputs: which of all, by frame, within a frame in the order of `truth` and `tracks`.
        """
        rows, columns = _parted(objects, self.truth), _parted(outputs, self.tracks)
        truth, n_truth = _renumbered([ids[kept] for ids, kept in zip(self.truth, rows, strict=True)])
        tracks, n_tracks = _renumbered([ids[kept] for ids, kept in zip(self.tracks, columns, strict=True)])
        parts = zip(self.similarity, rows, columns, strict=True)
        return Frames(truth, tracks, tuple(similarity[row][:, column] for similarity, row, column in parts), n_truth, n_tracks)


@dataclass(frozen=True, eq=False)
class Matches:
    """Matched pairs by instant: (n,) arrays of frame, object, track and similarity."""

    frame: NDArray[np.int64]
    truth: NDArray[np.int64]
    track: NDArray[np.int64]
    similarity: NDArray[np.float64]

    @classmethod
    def joined(cls, parts: list[tuple[int, NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]]) -> Matches:
        """Join parts of (frame, objects, tracks, similarities), one per instant."""
        frame = np.repeat([part[0] for part in parts], [len(part[1]) for part in parts]).astype(np.int64)
        whole = [np.empty(0, np.int64)]
        return cls(
            frame,
            np.concatenate(whole + [part[1] for part in parts]),
            np.concatenate(whole + [part[2] for part in parts]),
            np.concatenate([np.empty(0), *(part[3] for part in parts)]),
        )


@dataclass(frozen=True, eq=False)
class Pairs:
    """The distinct pairs among (n,) pairs of object and track, by object, then by track.

    Attributes:
        truth, track: of each distinct pair.
        of_each: (n,) index of the distinct pair that each is.
    """

    truth: NDArray[np.int64]
    track: NDArray[np.int64]
    of_each: NDArray[np.int64]

    @classmethod
    def of(cls, truth: NDArray[np.int64], track: NDArray[np.int64], n_tracks: int) -> Pairs:
        """Those among pairs of an object and a track below `n_tracks`."""
        keys, of_each = np.unique(truth * n_tracks + track, return_inverse=True)
        return cls(*np.divmod(keys, max(n_tracks, 1)), of_each.astype(np.int64))


def line_up(outputs: NDArray[np.void], truth: GroundTruth, rule: Rule) -> tuple[Frames, NDArray[np.void], NDArray[np.void]]:
    """Remove objects and outputs that are not evaluated, and find the similarity of the others.

    Args:
        outputs: rows of dtype `timeline.SAMPLE`, the tracks at the truth's instants (`windows.sampled`).

    Returns:
        The frames, and the objects (dtype `OBJECT`) and outputs (dtype `timeline.SAMPLE`) in them, by frame; within a frame
        in the order of `Frames.truth` and `Frames.tracks`.
    """
    counts = truth.objects["counted"]
    objects, excused = truth.objects[counts], truth.objects[~counts]
    n = len(truth.instants_us)
    objects_in, outputs_in = _split(objects, "frame", n), _split(outputs, "sample", n)
    if len(excused) or rule.ignore:
        ignored = [
            _ignored(states, own, others, rule)
            for states, own, others in zip(outputs_in, objects_in, _split(excused, "frame", n), strict=True)
        ]
        outputs = outputs[~np.concatenate(ignored)]
        outputs_in = _split(outputs, "sample", n)
    similarities = [
        _overlap(boxes, states, rule) if rule.similarity == "iou" else _nearness(boxes, states)
        for boxes, states in zip(objects_in, outputs_in, strict=True)
    ]
    truth_ids, truth_number = np.unique(objects["object"], return_inverse=True)
    track_ids, track_number = np.unique(outputs["track_id"], return_inverse=True)
    frames = Frames(
        _cut(truth_number, objects_in),
        _cut(track_number, outputs_in),
        tuple(similarities),
        len(truth_ids),
        len(track_ids),
    )
    return frames, objects, outputs


def _parted(mask: NDArray[np.bool_], ids: Ids) -> list[NDArray[np.bool_]]:
    """A mask over all frames, by frame."""
    return np.split(mask, np.cumsum([len(own) for own in ids])[:-1])


def _renumbered(ids: Sequence[NDArray[np.int64]]) -> tuple[Ids, int]:
    found, number = np.unique(np.concatenate([np.empty(0, np.int64), *ids]), return_inverse=True)
    return _cut(number, ids), len(found)


def _lengths(ids: Ids, n: int) -> NDArray[np.int64]:
    return np.bincount(np.concatenate([np.empty(0, np.int64), *ids]), minlength=n).astype(np.int64)


def _split(rows: NDArray[np.void], name: str, n: int) -> list[NDArray[np.void]]:
    return np.split(rows, np.searchsorted(rows[name], np.arange(1, n)))


def _cut(numbers: NDArray[np.int64], parts: Sequence[NDArray[Any]]) -> Ids:
    return tuple(np.split(numbers.astype(np.int64), np.cumsum([len(part) for part in parts])[:-1]))


def _ignored(states: NDArray[np.void], counted: NDArray[np.void], excused: NDArray[np.void], rule: Rule) -> NDArray[np.bool_]:
    """Mask of the ignored outputs: outside every counted box, and inside an uncounted box or an ignored band."""
    return ~_within(states, counted) & (_within(states, excused) | _in_bands(states, rule))


def _within(states: NDArray[np.void], boxes: NDArray[np.void]) -> NDArray[np.bool_]:
    """Whether the centre of each output lies in any of the boxes."""
    dx, dy = (np.abs(states[axis] - boxes[axis][:, None]) for axis in "xy")
    within: NDArray[np.bool_] = ((dx <= boxes["width"][:, None] / 2) & (dy <= boxes["height"][:, None] / 2)).any(axis=0)
    return within


def _in_bands(states: NDArray[np.void], rule: Rule) -> NDArray[np.bool_]:
    inside = np.zeros(len(states), bool)
    if rule.ignore:
        for axis, low, high, size in zip("xy", ("left", "top"), ("right", "bottom"), rule.size(), strict=True):
            from_edge = states[axis] - rule.edge_px
            inside |= (from_edge < rule.ignore.get(low, -np.inf)) | (size - from_edge < rule.ignore.get(high, -np.inf))
    return inside


def _nearness(boxes: NDArray[np.void], states: NDArray[np.void]) -> NDArray[np.float64]:
    """1 - d / (half the diagonal), at least 0; (boxes, states)."""
    distance = np.hypot(*(states[axis] - boxes[axis][:, None] for axis in "xy"))
    reach = np.hypot(boxes["width"], boxes["height"])[:, None] / 2
    return np.asarray(np.maximum(1 - distance / reach, 0), np.float64)


def _overlap(boxes: NDArray[np.void], states: NDArray[np.void], rule: Rule) -> NDArray[np.float64]:
    """Intersection over union of the truth's boxes and the tracks', turned ones upright; (boxes, states)."""
    shared, box_area, own_area = np.ones((len(boxes), len(states))), np.ones((len(boxes), 1)), np.ones(len(states))
    limits = [(rule.edge_px, rule.edge_px + size) for size in rule.size()] if rule.clip else [(-np.inf, np.inf)] * 2
    sides = upright_sides(states)
    for axis, name, own, (lowest, highest) in zip("xy", ("width", "height"), sides, limits, strict=True):
        box_low, box_high = (boxes[axis] + sign * boxes[name] / 2 for sign in (-1, 1))
        low, high = (np.clip(states[axis] + sign * own / 2, lowest, highest) for sign in (-1, 1))
        shared *= np.maximum(np.minimum(box_high[:, None], high) - np.maximum(box_low[:, None], low), 0)
        box_area *= boxes[name][:, None]
        own_area *= np.maximum(high - low, 0)
    return shared / (box_area + own_area - shared)
