# SPDX-License-Identifier: Apache-2.0
"""HOTA, CLEAR and ID scores: small cases by hand, and the reference implementation where it is installed.

Classes of tracks against those of a truth, on a table worked out by hand.
"""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import numpy as np
import pytest

from evcot.metrics.frames import Frames
from evcot.metrics.mot import clear, hota, identity
from evcot.metrics.scores import class_hota, class_scores
from evcot.tracks.record import classes_at, labels_at, no_verdicts
from support.logs import verdicts_of


def story(*instants: dict[tuple[int, int], float], truth: list[list[int]], tracks: list[list[int]]) -> Frames:
    """Frames whose similarities are 0 but for the pairs (object, track) named, per instant."""
    similarity = []
    for near, objects, outputs in zip(instants, truth, tracks, strict=True):
        similarity.append(
            np.array([[near.get((o, k), 0.0) for k in outputs] for o in objects]).reshape(len(objects), len(outputs))
        )
    return Frames(
        tuple(np.array(ids, np.int64) for ids in truth),
        tuple(np.array(ids, np.int64) for ids in tracks),
        tuple(similarity),
        len({i for ids in truth for i in ids}),
        len({i for ids in tracks for i in ids}),
    )


@pytest.fixture
def handed_over() -> Frames:
    """One object, at 4 instants; track 0 has it at the first two, track 1 at the others."""
    return story({(0, 0): 1.0}, {(0, 0): 1.0}, {(0, 1): 1.0}, {(0, 1): 1.0}, truth=[[0]] * 4, tracks=[[0], [0], [1], [1]])


def test_a_perfect_tracker_scores_one() -> None:
    frames = story({(0, 0): 1.0, (1, 1): 1.0}, {(0, 0): 1.0}, truth=[[0, 1], [0]], tracks=[[1, 0], [0]])
    assert asdict(hota(frames)) == dict.fromkeys(asdict(hota(frames)), 1.0)
    found = clear(frames)
    assert (found.mota, found.motp, found.tp, found.fp, found.fn) == (1.0, 1.0, 3, 0, 0)
    assert (found.idsw, found.frag, found.mt, found.pt, found.ml) == (0, 0, 2, 0, 0)
    assert asdict(identity(frames)) == {"idf1": 1.0, "idp": 1.0, "idr": 1.0, "idtp": 3, "idfp": 0, "idfn": 0}


def test_a_track_handed_over_costs_association_and_not_detection(handed_over: Frames) -> None:
    found = hota(handed_over)
    # TPA = 2 of 4 instants of the object and of 2 of the track: 2 / 4; precision 2 / 2.
    assert (found.deta, found.assa, found.assre, found.asspr) == (1.0, 0.5, 0.5, 1.0)
    assert found.hota == pytest.approx(math.sqrt(0.5))
    assert (clear(handed_over).idsw, clear(handed_over).mota, clear(handed_over).frag) == (1, 0.75, 0)
    assert identity(handed_over).idf1 == 0.5


def test_a_pair_that_was_matched_goes_on_though_another_is_nearer() -> None:
    frames = story(
        {(0, 0): 0.9}, {(0, 0): 0.6, (0, 1): 0.95}, {(0, 0): 0.4, (0, 1): 0.9}, truth=[[0]] * 3, tracks=[[0], [0, 1], [0, 1]]
    )
    found = clear(frames)
    np.testing.assert_array_equal(found.matches.track, [0, 0, 1])
    assert (found.tp, found.fp, found.fn, found.idsw) == (3, 2, 0, 1)
    assert found.motp == pytest.approx((0.9 + 0.6 + 0.9) / 3)


def test_a_switch_is_counted_across_a_gap_and_so_is_the_interruption() -> None:
    frames = story({(0, 0): 1.0}, {}, {(0, 1): 1.0}, truth=[[0]] * 3, tracks=[[0], [2], [1]])
    found = clear(frames)
    assert (found.tp, found.fp, found.fn, found.idsw, found.frag) == (2, 1, 1, 1, 1)


def test_mostly_is_more_than_four_fifths_and_lost_less_than_one() -> None:
    n = 10
    near = [{(o, o): 1.0 for o, times in enumerate((9, 8, 2, 1)) if t < times} for t in range(n)]
    frames = story(*near, truth=[[0, 1, 2, 3]] * n, tracks=[[0, 1, 2, 3]] * n)
    assert (clear(frames).mt, clear(frames).pt, clear(frames).ml) == (1, 2, 1)


def test_the_threshold_itself_matches() -> None:
    frames = story({(0, 0): 0.5}, truth=[[0]], tracks=[[0]])
    assert (clear(frames, 0.5).tp, identity(frames, 0.5).idtp) == (1, 1)
    assert (clear(frames, 0.51).tp, identity(frames, 0.51).idtp) == (0, 0)
    assert hota(frames).deta == pytest.approx(10 / 19)  # thresholds 0.05 to 0.50


def test_id_scores_give_each_object_one_track_for_all_time() -> None:
    """Object 0 agrees with track 0 at 3 instants and with 1 at 2; object 1 with track 0 at 2: 1 and 0 then agree at 4."""
    near = [{(0, 0): 1.0}] * 3 + [{(0, 1): 1.0, (1, 0): 1.0}] * 2
    frames = story(*near, truth=[[0, 1]] * 5, tracks=[[0, 1]] * 5)
    assert identity(frames).idtp == 4
    assert identity(frames).idf1 == pytest.approx(4 / 10)


def test_hota_matches_for_the_whole_and_not_for_the_moment() -> None:
    """Both tracks are near at one instant, track 1 nearer; but track 0 has the object at all others."""
    near = [{(0, 0): 1.0}] * 4 + [{(0, 0): 0.7, (0, 1): 0.9}]
    frames = story(*near, truth=[[0]] * 5, tracks=[[0]] * 4 + [[0, 1]])
    # At thresholds up to 0.7, 14 of 19, all five pairs are those of track 0; above, four.
    assert hota(frames).assa == pytest.approx((14 * 1 + 5 * 4 / 6) / 19)


@pytest.mark.parametrize(("truth", "tracks"), [([[], []], [[0], [0]]), ([[0], [0]], [[], []]), ([[], []], [[], []])])
def test_nothing_to_find_or_nothing_found_scores_zero(truth: list[list[int]], tracks: list[list[int]]) -> None:
    frames = story({}, {}, truth=truth, tracks=tracks)
    found = hota(frames)
    assert (found.hota, found.deta, found.assa, found.loca) == (0.0, 0.0, 0.0, 1.0)
    assert clear(frames).fp == identity(frames).idfp == sum(map(len, tracks))
    assert clear(frames).fn == identity(frames).idfn == sum(map(len, truth))
    assert identity(frames).idf1 == clear(frames).mota == 0.0


def random_frames(seed: int) -> Frames:
    """Objects and tracks that come and go, tracks that stay with an object for a while, and equal similarities."""
    random = np.random.default_rng(seed)
    n_truth, n_tracks, n = random.integers(1, 9), random.integers(1, 14), random.integers(1, 60)
    with_object = random.integers(n_truth, size=n_tracks)
    truth, tracks, similarity = [], [], []
    for _ in range(n):
        with_object[random.random(n_tracks) < 0.05] = random.integers(n_truth)
        here, there = (np.flatnonzero(random.random(k) < random.choice([0.1, 0.8])) for k in (n_truth, n_tracks))
        near = random.random((len(here), len(there))) ** 3
        near[here[:, None] == with_object[there]] **= 0.1
        steps = random.choice([4, 20, 10**9])
        truth.append(random.permutation(here))
        tracks.append(random.permutation(there))
        similarity.append(np.round(near * steps) / steps)
    present = [np.unique(np.concatenate([np.empty(0, np.int64), *ids])) for ids in (truth, tracks)]
    truth, tracks = ([np.searchsorted(every, own) for own in ids] for every, ids in zip(present, (truth, tracks), strict=True))
    return Frames(tuple(truth), tuple(tracks), tuple(similarity), len(present[0]), len(present[1]))


def reference(frames: Frames) -> dict[str, Any]:
    metrics = pytest.importorskip("trackeval", exc_type=ImportError).metrics
    data = {
        "num_timesteps": len(frames.truth),
        "num_gt_ids": frames.n_truth,
        "num_tracker_ids": frames.n_tracks,
        "num_gt_dets": int(frames.truth_lengths.sum()),
        "num_tracker_dets": int(frames.track_lengths.sum()),
        "gt_ids": list(frames.truth),
        "tracker_ids": list(frames.tracks),
        "similarity_scores": list(frames.similarity),
    }
    quiet = {"PRINT_CONFIG": False}
    every = metrics.HOTA().eval_sequence(data) | metrics.CLEAR(quiet).eval_sequence(data)
    return {name: np.mean(value) for name, value in (every | metrics.Identity(quiet).eval_sequence(data)).items()}


def test_every_score_equals_the_reference() -> None:
    names = {
        "hota": "HOTA", "deta": "DetA", "assa": "AssA", "loca": "LocA", "detre": "DetRe", "detpr": "DetPr", "assre": "AssRe",
        "asspr": "AssPr", "mota": "MOTA", "motp": "MOTP", "tp": "CLR_TP", "fp": "CLR_FP", "fn": "CLR_FN", "idsw": "IDSW",
        "frag": "Frag", "mt": "MT", "pt": "PT", "ml": "ML", "idf1": "IDF1", "idp": "IDP", "idr": "IDR", "idtp": "IDTP",
        "idfp": "IDFP", "idfn": "IDFN",
    }  # fmt: skip
    for seed in range(200):
        frames = random_frames(seed)
        wanted = reference(frames)
        got = asdict(hota(frames)) | asdict(clear(frames)) | asdict(identity(frames))
        for name, theirs in names.items():
            assert got[name] == pytest.approx(wanted[theirs], rel=0, abs=1e-9), f"{name}, seed {seed}"


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
