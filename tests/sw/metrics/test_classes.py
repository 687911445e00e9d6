# SPDX-License-Identifier: Apache-2.0
"""Classes of tracks against those of a truth, on a table worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from evcot.metrics.frames import Frames
from evcot.metrics.scores import class_hota, class_scores
from evcot.tracks.record import classes_at, labels_at, no_verdicts
from support.logs import verdicts_of


def test_the_last_verdict_counts_against_the_object_met_most_often() -> None:
    # Track 1 is a 3 and first said to be a 7; track 2 is a 7, called 3; track 4 is a 7, none of these; track 5 has no verdict.
    said = verdicts_of((10, 1, 7), (20, 1, 3), (20, 2, 3), (30, 4, -1), (30, 6, 7))
    track_id = np.array([1, 1, 1, 2, 2, 4, 5, 6])
    class_id = np.array([3, 7, 3, 7, 7, 7, 3, -1])
    found = class_scores(said, {3: "car"}, track_id, class_id, {3: 0.5, 7: 0.25, 8: 0.0})
    assert found is not None
    assert found.class_ids == (3, 7, 8)
    assert found.labels == ("car", "7", "8")
    assert found.confusion == ((1, 0, 0, 1), (1, 0, 0, 1), (0, 0, 0, 0))
    assert found.accuracy == 0.25
    assert found.recall == (0.5, 0.0, None)
    assert found.precision == (0.5, None, None)
    assert found.hota == (0.5, 0.25, 0.0)
    assert found.hota_mean == 0.25


def two_classes() -> tuple[Frames, np.ndarray, np.ndarray]:
    """Object 0 of class 3 and object 1 of class 7 at four instants, each followed exactly by one track; classes of both.

    Track 0 has no class at first, then 3. Track 1 is called 3 at two instants, then 7.
    """
    frames = Frames((np.arange(2),) * 4, (np.arange(2),) * 4, (np.eye(2),) * 4, 2, 2)
    return frames, np.array([3, 7] * 4), np.array([-1, 3, 3, 3, 3, 7, 3, 7])


def test_hota_of_a_class_has_its_objects_and_the_tracks_while_they_have_it() -> None:
    frames, of_object, of_output = two_classes()
    found = class_hota(frames, of_object, of_output)
    # Class 3: object 0 at 4 instants, track 0 at 3 of them, track 1 at 2. TP = 3, FN = 1, FP = 2; TPA = 3, FNA = 1, FPA = 0.
    # Class 7: object 1 at 4 instants, track 1 at 2 of them. TP = 2, FN = 2; TPA = 2, FNA = 2, FPA = 0.
    assert found == pytest.approx({3: math.sqrt(3 / 6 * 3 / 4), 7: math.sqrt(2 / 4 * 2 / 4)})


def test_a_class_that_no_track_has_scores_nothing_and_one_without_objects_is_left_out() -> None:
    frames, of_object, of_output = two_classes()
    assert class_hota(frames, of_object, np.where(of_output == 7, 5, of_output))[7] == 0
    assert class_hota(frames, np.full(8, -1), of_output) == {}


@pytest.mark.parametrize("seed", range(3))
def test_the_mean_of_classes_is_that_of_the_reference(seed: int) -> None:
    metrics = pytest.importorskip("trackeval", exc_type=ImportError).metrics
    random = np.random.default_rng(seed)
    truth, tracks = ([np.sort(random.permutation(9)[: random.integers(3, 7)]) for _ in range(30)] for _ in range(2))
    similarity = [random.random((len(g), len(k))) for g, k in zip(truth, tracks, strict=True)]
    frames = Frames(tuple(truth), tuple(tracks), tuple(similarity), 9, 9)
    of_object = np.concatenate(truth) % 3
    of_output = random.integers(-1, 3, sum(map(len, tracks)))
    ends = np.cumsum([len(own) for own in tracks])[:-1]
    per_class = {}
    for one in range(3):
        kept = np.split(of_output == one, ends)
        own_truth, own_tracks = ([ids % 3 == one for ids in truth], kept)
        data = {
            "similarity_scores": [s[g][:, k] for s, g, k in zip(similarity, own_truth, own_tracks, strict=True)],
            "num_timesteps": 30,
        }
        for name, ids, own in (("gt", truth, own_truth), ("tracker", tracks, own_tracks)):
            number = np.unique(np.concatenate([i[o] for i, o in zip(ids, own, strict=True)]))
            data[f"{name}_ids"] = [np.searchsorted(number, i[o]) for i, o in zip(ids, own, strict=True)]
            data[f"num_{name}_ids"] = len(number)
            data[f"num_{name}_dets"] = sum(int(o.sum()) for o in own)
        per_class[str(one)] = metrics.HOTA().eval_sequence(data)
    mean = metrics.HOTA().combine_classes_class_averaged(per_class)["HOTA"].mean()
    assert np.mean(list(class_hota(frames, of_object, of_output).values())) == pytest.approx(mean, abs=1e-9)


def test_a_truth_without_classes_has_no_scores() -> None:
    assert class_scores(verdicts_of((1, 1, 1)), {}, np.array([1]), np.array([-1]), {}) is None


def test_a_track_has_the_class_of_its_last_verdict_until_then() -> None:
    said = verdicts_of((10, 1, 7), (15, 2, 5), (20, 1, 3))
    asked = [(1, 9), (1, 10), (1, 19), (1, 20), (2, 99), (3, 99)]
    track_id, t_us = np.array(asked).T
    assert classes_at(said, track_id, t_us).tolist() == [-1, 7, 7, 3, 5, -1]
    assert classes_at(no_verdicts(), track_id, t_us).tolist() == [-1] * 6


def test_a_track_is_shown_by_the_name_of_its_class() -> None:
    said = verdicts_of((10, 1, 7), (15, 2, 5), (20, 1, -1))
    track_id, t_us = np.array([(1, 9), (1, 10), (1, 20), (2, 99)]).T
    assert labels_at(said, {7: "car"}, track_id, t_us) == ["", "car", "?", "5"]
