# SPDX-License-Identifier: Apache-2.0
"""A log against a truth, as a whole: the truth is its own best tracker."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evcot.errors import TrackLogError
from evcot.metrics import GroundTruth, Scores, evaluate, load_rule, read_truth
from evcot.scenes.registry import SCENES, scene_settings
from evcot.tracks.log import Kind, TrackLog
from shared import SHARED

from .stories import following, logged

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
