# SPDX-License-Identifier: Apache-2.0
"""A log against a truth, as a whole: the truth is its own best tracker."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError, TrackLogError
from evcot.metrics import GroundTruth, Rule, Scores, evaluate, load_rule, read_truth
from evcot.metrics.frames import Frames, line_up
from evcot.metrics.truth import OBJECT
from evcot.scenes.registry import SCENES, scene_settings
from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot.tracks.timeline import sample
from shared import SHARED

Record = tuple[int, int, Kind, float, float]


def logged(*records: Record, width: float = 10.0, height: float = 10.0, angle: float = 0.0) -> TrackLog:
    """A log of (t_us, track_id, kind, x, y); the search window is larger than the box."""
    rows = np.zeros(len(records), TRACK)
    for name, column in zip(("t_us", "track_id", "kind", "x", "y"), zip(*records, strict=True), strict=False):
        rows[name] = column
    rows["width"], rows["height"], rows["angle"], rows["radius"], rows["other_id"] = width, height, angle, 50.0, -1
    return TrackLog("test", rows, np.empty(0, np.int16))


def following(truth: GroundTruth, late_us: int = 0) -> TrackLog:
    """The truth as its own tracker, with a delay; a track is lost 1 us after the last instant of its object."""
    records = []
    for number in range(len(truth.ids)):
        own = truth.objects[truth.objects["object"] == number]
        t_us = truth.instants_us[own["frame"]] + late_us
        kinds = [Kind.BORN] + [Kind.MOVED] * (len(own) - 1) + [Kind.LOST]
        own, t_us = np.append(own, own[-1:]), np.append(t_us, t_us[-1] + 1)
        records += zip(t_us.tolist(), own["object"].tolist(), kinds, own["x"].tolist(), own["y"].tolist(), strict=True)
    return logged(*sorted(records))


TRAFFIC = SHARED / "traffic_outbound_gt.csv"
ONES = ("hota", "deta", "assa", "loca", "detre", "detpr", "assre", "asspr", "mota", "motp", "idf1", "idp", "idr")
ZEROS = ("idsw", "frag", "fp", "fn", "ml", "position_error_px_median", "position_error_px_p90", "latency_ms")
SCENE = load_rule("scene")


@pytest.fixture(scope="module")
def discs(tmp_path_factory: pytest.TempPathFactory) -> GroundTruth:
    path = tmp_path_factory.mktemp("scene") / "truth.csv"
    SCENES["discs"].simulate(scene_settings("discs", 1, {"duration_us": 1_000_000})).truth.save(path)
    return read_truth(path, SCENE)


@pytest.fixture(scope="module")
def traffic() -> GroundTruth:
    if not TRAFFIC.exists():
        pytest.skip(f"{TRAFFIC} is not here")
    return read_truth(TRAFFIC, load_rule("traffic"))


def assert_perfect(scores: Scores) -> None:
    assert {name: getattr(scores, name) for name in ONES} == pytest.approx(dict.fromkeys(ONES, 1.0), abs=1e-12)
    assert {name: getattr(scores, name) for name in ZEROS} == dict.fromkeys(ZEROS, 0)
    assert scores.mt == scores.truth_ids == scores.track_ids


def test_the_truth_of_a_scene_scores_one(discs: GroundTruth) -> None:
    scores = evaluate(following(discs), discs, SCENE)
    assert_perfect(scores)
    assert scores.frames == len(discs.instants_us)
    assert scores.velocity_error_median is not None
    assert scores.velocity_error_median < 0.1 * np.hypot(discs.objects["vx"], discs.objects["vy"]).mean()


def test_late_tracks_say_how_late(discs: GroundTruth) -> None:
    scores = evaluate(following(discs, late_us=20_000), discs, SCENE)
    assert scores.latency_ms == 20.0
    assert scores.hota < 0.99


def test_a_log_without_tracks_misses_everything(discs: GroundTruth) -> None:
    scores = evaluate(TrackLog.empty("rct"), discs, SCENE)
    assert (scores.hota, scores.mota, scores.idf1, scores.tp, scores.fp, scores.track_ids) == (0.0, 0.0, 0.0, 0, 0, 0)
    assert scores.fn == np.count_nonzero(discs.objects["counted"])
    assert scores.ml == scores.truth_ids
    assert (scores.position_error_px_median, scores.velocity_error_median, scores.latency_ms) == (None, None, None)


def test_a_state_is_an_output_while_it_is_young_enough(discs: GroundTruth) -> None:
    """A track outside all boxes that says something only once, at the first instant."""
    log = logged((0, 1, Kind.BORN, -1_000.0, -1_000.0))
    ages_us = discs.instants_us - discs.instants_us[0]
    assert evaluate(log, discs, SCENE).fp == np.count_nonzero(ages_us <= 60_000)
    assert evaluate(log, discs, replace(SCENE, max_age_us=100_000)).fp == np.count_nonzero(ages_us <= 100_000)


def test_logs_of_another_clock_are_refused(discs: GroundTruth) -> None:
    epoch_us = 1_718_925_184_590_631
    with pytest.raises(TrackLogError, match=rf"^t_us from {epoch_us} to {epoch_us}, .*: must be of one clock \(the rule's"):
        evaluate(logged((epoch_us, 1, Kind.BORN, 1.0, 1.0)), discs, SCENE)
    moved = replace(discs, instants_us=discs.instants_us + epoch_us)
    assert_perfect(evaluate(following(moved), moved, SCENE))


def test_the_traffic_truth_scores_one(traffic: GroundTruth) -> None:
    scores = evaluate(following(traffic), traffic, load_rule("traffic"))
    assert_perfect(scores)
    assert (scores.frames, scores.tp, scores.truth_ids) == (100, 340, 8)
    assert scores.velocity_error_median is None


def test_the_traffic_truth_one_frame_late(traffic: GroundTruth) -> None:
    """What others found: 0.86."""
    scores = evaluate(following(traffic, late_us=39_900), traffic, load_rule("traffic"))
    assert scores.hota == pytest.approx(0.86, abs=0.015)
    assert scores.latency_ms == 40.0


def test_the_traffic_rule_ignores_cars_that_have_no_box(traffic: GroundTruth) -> None:
    """A track at the right, where no box ever is, is false; within 10 px of the edge it does not count."""
    rule, own = load_rule("traffic"), following(traffic)

    def with_another(x: float, y: float) -> Scores:
        places = [(t_us, 99, Kind.MOVED, x, y) for t_us in traffic.instants_us.tolist()]
        return evaluate(
            logged(*sorted([*own.records[["t_us", "track_id", "kind", "x", "y"]].tolist(), *places])), traffic, rule
        )

    assert_perfect(with_another(336.1, 100.0))
    assert with_another(335.9, 100.0).fp == 100


RULE = Rule({"id": "id", "t_us": "t", "left": "l", "top": "t", "width": "w", "height": "h"})


def truth_of(*boxes: tuple[int, int, float, float, float, float, bool]) -> GroundTruth:
    """(frame, object, x, y, width, height, counted) at instants 0, 100, ..."""
    objects = np.zeros(len(boxes), OBJECT)
    for name, column in zip(("frame", "object", "x", "y", "width", "height", "counted"), zip(*boxes, strict=True), strict=True):
        objects[name] = column
    return GroundTruth(100 * np.arange(max(box[0] for box in boxes) + 1), objects, ("a", "b", "c"))


def lined_up(log: TrackLog, truth: GroundTruth, rule: Rule) -> tuple[Frames, NDArray[np.void], NDArray[np.void]]:
    return line_up(sample(log, truth.instants_us), truth, rule)


def frames_of(truth: GroundTruth, places: Sequence[tuple[float, float]], rule: Rule = RULE, **box: float) -> Frames:
    """Tracks 10, 11, ... stand at these places from the first instant on, with boxes of 10 x 10 px or these."""
    log = logged(*((0, 10 + i, Kind.BORN, x, y) for i, (x, y) in enumerate(places)), **box)
    return lined_up(log, truth, rule)[0]


IOU = Rule(RULE.columns, similarity="iou")


def test_similarity_is_overlap_or_falls_from_the_centre_to_half_a_diagonal_away() -> None:
    small, box = truth_of((0, 0, 50.0, 50.0, 6.0, 8.0, True)), truth_of((0, 0, 50.0, 50.0, 10.0, 20.0, True))
    for truth, places, rule, sides, expected in (
        (small, [(50, 50), (52, 50), (50, 55), (90, 50)], RULE, {}, [1.0, 0.6, 0.0, 0.0]),
        (box, [(50, 50), (55, 60), (60, 50)], IOU, {}, [100 / 200, 25 / 275, 0.0]),
        (box, [(50, 50)], IOU, {"width": 10.0, "height": 20.0}, [1.0]),
        (box, [(50, 50)], IOU, {"width": 20.0, "height": 10.0}, [100 / 300]),
    ):
        np.testing.assert_allclose(frames_of(truth, places, rule, **sides).similarity[0], [expected])


def test_of_a_turned_box_the_upright_rectangle_around_it_overlaps() -> None:
    truth = truth_of((0, 0, 50.0, 50.0, 10.0, 20.0, True))
    quarter = frames_of(truth, [(50, 50)], IOU, width=20.0, height=10.0, angle=np.pi / 2)
    np.testing.assert_allclose(quarter.similarity[0], [[1.0]])
    square = frames_of(truth_of((0, 0, 50.0, 50.0, 10.0, 10.0, True)), [(50, 50)], IOU, angle=np.pi / 4)
    np.testing.assert_allclose(square.similarity[0], [[0.5]])


def test_boxes_of_tracks_are_clipped_as_boxes_are() -> None:
    truth = truth_of((0, 0, 2.5, 5.0, 5.0, 10.0, True))
    clipping = Rule(RULE.columns, similarity="iou", clip=True, edge_px=0.0, sensor=(100, 100))
    np.testing.assert_allclose(frames_of(truth, [(0, 5)], clipping).similarity[0], [[1.0]])
    np.testing.assert_allclose(frames_of(truth, [(0, 5)], IOU).similarity[0], [[0.5]])


def test_an_output_in_a_band_counts_only_inside_a_box() -> None:
    rule = Rule(RULE.columns, ignore={"top": 28, "left": 10, "right": 12, "bottom": 14}, edge_px=0.0, sensor=(346, 260))
    truth = truth_of((0, 0, 20.0, 20.0, 10.0, 10.0, True))
    places = {
        "in the box, above": (20, 20), "above": (40, 27.9), "below that": (40, 28), "left": (9.9, 90),
        "right of that": (10, 90),
        "right": (334.1, 90), "left of that": (334, 90), "bottom": (90, 246.1), "above that": (90, 246),
    }  # fmt: skip
    frames, _, outputs = lined_up(logged(*((0, i, Kind.BORN, x, y) for i, (x, y) in enumerate(places.values()))), truth, rule)
    assert [list(places)[i] for i in outputs["track_id"]] == [
        "in the box, above", "below that", "right of that", "left of that", "above that",
    ]  # fmt: skip
    assert frames.n_tracks == 5
    from_half = replace(rule, edge_px=-0.5)
    assert [frames_of(truth, [(x, 90)], from_half).n_tracks for x in (9.4, 9.6, 333.4, 333.6)] == [0, 1, 1, 0]
    with pytest.raises(ConfigError, match=r"^sensor: must be given"):
        frames_of(truth, [(0, 0)], Rule(RULE.columns, ignore={"top": 3}))


def test_a_box_that_does_not_count_excuses_what_is_in_it_alone() -> None:
    truth = truth_of((0, 0, 20.0, 20.0, 10.0, 10.0, True), (0, 1, 26.0, 20.0, 10.0, 10.0, False))
    frames, objects, outputs = lined_up(
        logged((0, 1, Kind.BORN, 28.0, 20.0), (0, 2, Kind.BORN, 23.0, 20.0), (0, 3, Kind.BORN, 40.0, 20.0)), truth, RULE
    )
    np.testing.assert_array_equal(objects["object"], [0])
    np.testing.assert_array_equal(outputs["track_id"], [2, 3])
    assert (frames.n_truth, frames.n_tracks) == (1, 2)


def test_numbers_stay_with_objects_and_tracks_over_time() -> None:
    truth = truth_of((0, 2, 10.0, 10.0, 8.0, 8.0, True), (2, 0, 50.0, 50.0, 8.0, 8.0, True), (2, 2, 20.0, 20.0, 8.0, 8.0, True))
    log = logged(
        (0, 70, Kind.BORN, 10.0, 10.0), (50, 30, Kind.BORN, 50.0, 50.0), (150, 70, Kind.MOVED, 20.0, 20.0),
        (150, 90, Kind.BORN, 0.0, 0.0), (160, 90, Kind.LOST, 0.0, 0.0),
    )  # fmt: skip
    frames, objects, outputs = lined_up(log, truth, RULE)
    assert [ids.tolist() for ids in frames.truth] == [[1], [], [0, 1]]
    assert [ids.tolist() for ids in frames.tracks] == [[1], [0, 1], [0, 1]]
    assert [part.shape for part in frames.similarity] == [(1, 1), (0, 2), (2, 2)]
    np.testing.assert_allclose(frames.similarity[2], np.eye(2))
    np.testing.assert_array_equal(frames.truth_lengths, [1, 2])
    np.testing.assert_array_equal(frames.track_lengths, [2, 3])
    np.testing.assert_array_equal(objects["object"], [2, 0, 2])
    np.testing.assert_array_equal(outputs["track_id"], [70, 30, 70, 30, 70])
    np.testing.assert_array_equal(outputs["x"], [10, 50, 10, 50, 20])
