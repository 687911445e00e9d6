# SPDX-License-Identifier: Apache-2.0
"""Classes of tracks against those of a truth: how often they are right, and HOTA of each class."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..tracks.record import ClassNames, class_label, classes_at
from .frames import Frames
from .mot import hota

__all__ = ["ClassScores", "class_hota", "class_scores"]


@dataclass(frozen=True)
class ClassScores:
    """How often tracks have the class of their object.

    Attributes:
        class_ids: classes of truth and verdicts, ascending, without -1.
        labels: how each is shown: by its name, if the log has it.
        confusion: tracks of each true class (row) with each class found (column, in the same order); the last column has
            those without a class: none of these, or without a verdict.
        accuracy: share of all tracks with the right class.
        recall, precision: of each class; None without a track of it, or with it.
        hota: of each class, of its objects and of the tracks while they have this class; None without an object of it.
        hota_mean: over the classes with objects.
    """

    class_ids: tuple[int, ...]
    labels: tuple[str, ...]
    confusion: tuple[tuple[int, ...], ...]
    accuracy: float
    recall: tuple[float | None, ...]
    precision: tuple[float | None, ...]
    hota: tuple[float | None, ...]
    hota_mean: float


def class_hota(frames: Frames, of_object: NDArray[np.int64], of_output: NDArray[np.int64]) -> dict[int, float]:
    """HOTA of each class of objects: of these objects, and of the outputs with this class.

    Args:
        of_object, of_output: the class of each object and each output, by frame, within a frame in the order of `frames`.
    """
    classes = np.unique(of_object[of_object >= 0]).tolist()
    return {one: hota(frames.restricted(of_object == one, of_output == one)).hota for one in classes}


def class_scores(
    verdicts: NDArray[np.void], names: ClassNames, track_id: NDArray[np.int64], class_id: NDArray[np.int64],
    by_class: Mapping[int, float],
) -> ClassScores | None:  # fmt: skip
    """Compare the last verdict of each track with the class of the object that it met most often.

    Args:
        verdicts: (k,) of dtype `tracks.record.VERDICT`.
        names: of the classes.
        track_id, class_id: (n,), a track and its object's true class, for each instant at which the two met.
        by_class: as of `class_hota`.

    Returns:
        None if no track met an object with a class.
    """
    known = class_id >= 0
    track_id, class_id = track_id[known], class_id[known]
    if not len(track_id):
        return None
    tracks, number = np.unique(track_id, return_inverse=True)
    found = classes_at(verdicts, tracks, np.full(len(tracks), np.iinfo(np.int64).max))
    class_ids = np.unique(np.concatenate((class_id, found[found >= 0], np.array(list(by_class), np.int64))))
    met = np.zeros((len(tracks), len(class_ids)), np.int64)
    np.add.at(met, (number, np.searchsorted(class_ids, class_id)), 1)
    confusion = np.zeros((len(class_ids), len(class_ids) + 1), np.int64)
    np.add.at(confusion, (met.argmax(axis=1), np.where(found >= 0, np.searchsorted(class_ids, found), len(class_ids))), 1)
    right = np.diagonal(confusion)
    return ClassScores(
        tuple(class_ids.tolist()),
        tuple(class_label(one, names) for one in class_ids.tolist()),
        tuple(tuple(row) for row in confusion.tolist()),
        float(right.sum() / len(tracks)),
        _shares(right, confusion.sum(axis=1)),
        _shares(right, confusion.sum(axis=0)[:-1]),
        tuple(by_class.get(one) for one in class_ids.tolist()),
        float(np.mean(list(by_class.values()))),
    )


def _shares(part: NDArray[np.int64], whole: NDArray[np.int64]) -> tuple[float | None, ...]:
    return tuple(one / of if of else None for one, of in zip(part.tolist(), whole.tolist(), strict=True))
