# SPDX-License-Identifier: Apache-2.0
"""Classes of tracks against those of a truth, on a table worked out by hand."""

from __future__ import annotations

import numpy as np

from evcot.metrics.classes import class_scores
from evcot.tracks.record import VERDICT, classes_at, no_verdicts


def verdicts(*rows: tuple[int, int, int]) -> np.ndarray:
    """(time, track, class) each."""
    made = np.zeros(len(rows), VERDICT)
    for row, (t_us, track_id, class_id) in enumerate(rows):
        made["t_us"][row], made["track_id"][row], made["class_id"][row] = t_us, track_id, class_id
    return made


def test_the_last_verdict_counts_against_the_object_met_most_often() -> None:
    # Track 1 is a 3 and first said to be a 7; track 2 is a 7, called 3; track 4 is a 7, none of these; track 5 has no verdict.
    said = verdicts((10, 1, 7), (20, 1, 3), (20, 2, 3), (30, 4, -1), (30, 6, 7))
    track_id = np.array([1, 1, 1, 2, 2, 4, 5, 6])
    class_id = np.array([3, 7, 3, 7, 7, 7, 3, -1])
    found = class_scores(said, track_id, class_id)
    assert found is not None
    assert found.class_ids == (3, 7)
    assert found.confusion == ((1, 0, 1), (1, 0, 1))
    assert found.accuracy == 0.25
    assert found.recall == (0.5, 0.0)
    assert found.precision == (0.5, None)


def test_a_truth_without_classes_has_no_scores() -> None:
    assert class_scores(verdicts((1, 1, 1)), np.array([1]), np.array([-1])) is None


def test_a_track_has_the_class_of_its_last_verdict_until_then() -> None:
    said = verdicts((10, 1, 7), (15, 2, 5), (20, 1, 3))
    asked = [(1, 9), (1, 10), (1, 19), (1, 20), (2, 99), (3, 99)]
    track_id, t_us = np.array(asked).T
    assert classes_at(said, track_id, t_us).tolist() == [-1, 7, 7, 3, 5, -1]
    assert classes_at(no_verdicts(), track_id, t_us).tolist() == [-1] * 6
