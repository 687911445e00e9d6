# SPDX-License-Identifier: Apache-2.0
"""Limits of a tracker: its HOTA if one kind of error were corrected and all others remained.

Pairs are those that CLEAR matches at HOTA's lowest threshold. Each figure bounds what mending that one thing could bring.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from evcot.metrics.frames import Frames
from evcot.metrics.mot import THRESHOLDS, clear, hota

__all__ = ["WHAT_IF", "what_if"]

WHAT_IF = ("as it is", "every track on its object's centre", "no switch", "no false track", "no object missed")

_Pair = tuple[NDArray[np.int64], NDArray[np.int64]]


def what_if(frames: Frames) -> dict[str, float]:
    """HOTA for each of `WHAT_IF`."""
    pairs = list(_pairs(frames))
    variants = (frames, _placed(frames, pairs), _named(frames, pairs), _true(frames, pairs), _complete(frames, pairs))
    return {name: hota(variant).hota for name, variant in zip(WHAT_IF, variants, strict=True)}


def _pairs(frames: Frames) -> Iterator[_Pair]:
    """Per instant, the rows of matched objects and the columns of their tracks."""
    matches = clear(frames, float(THRESHOLDS[0])).matches
    cuts = np.searchsorted(matches.frame, np.arange(1, len(frames.truth)))
    of_frames = zip(np.split(matches.truth, cuts), np.split(matches.track, cuts), strict=True)
    for objects, tracks, (own_objects, own_tracks) in zip(frames.truth, frames.tracks, of_frames, strict=True):
        yield _places(objects, own_objects), _places(tracks, own_tracks)


def _places(numbers: NDArray[np.int64], wanted: NDArray[np.int64]) -> NDArray[np.int64]:
    order = np.argsort(numbers)
    return np.asarray(order[np.searchsorted(numbers, wanted, sorter=order)], np.int64)


def _placed(frames: Frames, pairs: list[_Pair]) -> Frames:
    similarity = tuple(one.copy() for one in frames.similarity)
    for one, pair in zip(similarity, pairs, strict=True):
        one[pair] = 1
    return replace(frames, similarity=similarity)


def _named(frames: Frames, pairs: list[_Pair]) -> Frames:
    """Tracks have their object's number while they are matched, and their own, moved up, while they are not."""
    tracks = tuple(own + frames.n_truth for own in frames.tracks)
    for own, objects, (row, column) in zip(tracks, frames.truth, pairs, strict=True):
        own[column] = objects[row]
    return replace(frames, tracks=tracks, n_tracks=frames.n_tracks + frames.n_truth)


def _true(frames: Frames, pairs: list[_Pair]) -> Frames:
    columns = [np.sort(column) for _, column in pairs]
    return replace(
        frames,
        tracks=tuple(own[column] for own, column in zip(frames.tracks, columns, strict=True)),
        similarity=tuple(one[:, column] for one, column in zip(frames.similarity, columns, strict=True)),
    )


def _complete(frames: Frames, pairs: list[_Pair]) -> Frames:
    """Objects do not count where nobody tracks them."""
    rows = [np.sort(row) for row, _ in pairs]
    return replace(
        frames,
        truth=tuple(own[row] for own, row in zip(frames.truth, rows, strict=True)),
        similarity=tuple(one[row] for one, row in zip(frames.similarity, rows, strict=True)),
    )
