# SPDX-License-Identifier: Apache-2.0
"""Classes of tracks against those of a truth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..tracks.record import classes_at

__all__ = ["ClassScores", "class_scores"]


@dataclass(frozen=True)
class ClassScores:
    """How often tracks have the class of their object.

    Attributes:
        class_ids: classes of truth and verdicts, ascending, without -1.
        confusion: tracks of each true class (row) with each class found (column, in the same order); the last column has
            those without a class: none of these, or without a verdict.
        accuracy: share of all tracks with the right class.
        recall, precision: of each class; None without a track of it, or with it.
    """

    class_ids: tuple[int, ...]
    confusion: tuple[tuple[int, ...], ...]
    accuracy: float
    recall: tuple[float | None, ...]
    precision: tuple[float | None, ...]


def class_scores(verdicts: NDArray[np.void], track_id: NDArray[np.int64], class_id: NDArray[np.int64]) -> ClassScores | None:
    """Compare the last verdict of each track with the class of the object that it met most often.

    Args:
        verdicts: (k,) of dtype `tracks.record.VERDICT`.
        track_id, class_id: (n,), a track and its object's true class, for each instant at which the two met.

    Returns:
        None if no track met an object with a class.
    """
    known = class_id >= 0
    track_id, class_id = track_id[known], class_id[known]
    if not len(track_id):
        return None
    tracks, number = np.unique(track_id, return_inverse=True)
    found = classes_at(verdicts, tracks, np.full(len(tracks), np.iinfo(np.int64).max))
    names = np.unique(np.concatenate((class_id, found[found >= 0])))
    met = np.zeros((len(tracks), len(names)), np.int64)
    np.add.at(met, (number, np.searchsorted(names, class_id)), 1)
    confusion = np.zeros((len(names), len(names) + 1), np.int64)
    np.add.at(confusion, (met.argmax(axis=1), np.where(found >= 0, np.searchsorted(names, found), len(names))), 1)
    right = np.diagonal(confusion)
    return ClassScores(
        tuple(names.tolist()),
        tuple(tuple(row) for row in confusion.tolist()),
        float(right.sum() / len(tracks)),
        _shares(right, confusion.sum(axis=1)),
        _shares(right, confusion.sum(axis=0)[:-1]),
    )


def _shares(part: NDArray[np.int64], whole: NDArray[np.int64]) -> tuple[float | None, ...]:
    return tuple(one / of if of else None for one, of in zip(part.tolist(), whole.tolist(), strict=True))
