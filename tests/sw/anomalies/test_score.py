# SPDX-License-Identifier: Apache-2.0
"""Alarms against planted anomalies, by hand and on simulated highways."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.anomalies import ALARM, Anomaly, anomalies, learn
from evcot.anomalies.score import score_alarms, truth_log
from evcot.scenes import highway
from evcot.scenes.registry import scene_settings
from evcot.scenes.truth import TRUTH, Label, Truth, on_sensor
from evcot.tracks.log import Kind


def truth(*, labels: tuple[Label, ...] = ()) -> Truth:
    """Two boxes that stand for 10 s: 0 at (50, 50), 1 at (200, 100); 1 is hidden from 4 to 5 s."""
    samples = np.zeros((1000, 2), TRUTH)
    samples["t_us"] = np.arange(1000)[:, None] * 10_000
    samples["object_id"] = 0, 1
    samples["x"], samples["y"] = (50, 200), (50, 100)
    samples["width"], samples["height"], samples["visible"] = 20, 30, True
    samples["occluded"][400:500, 1] = 0.9
    return Truth(samples.ravel(), (), labels)


def alarm(t_us: int, kind: Anomaly, x: float, y: float) -> NDArray[np.void]:
    row = np.zeros(1, ALARM)
    row["t_us"], row["kind"], row["x"], row["y"] = t_us, kind, x, y
    return row


LABELS = (Label(0, "wrong_way", 2_000_000, 4_000_000), Label(1, "stopping", 6_000_000, 8_000_000))


def scored(*alarms: NDArray[np.void]) -> tuple[dict[str, int], dict[str, int], dict[str, list[float]]]:
    scores = score_alarms(np.concatenate(alarms), truth(labels=LABELS), 30_000_000)
    assert scores.minutes == 0.5
    assert sum(scores.found.values()) + len(scores.missed) == 2
    return scores.found, scores.false_alarms, scores.seconds_to_alarm


def test_an_alarm_of_the_kind_at_the_object_in_time_finds_it() -> None:
    found, false, seconds = scored(alarm(2_700_000, Anomaly.WRONG_WAY, 55, 60), alarm(3_000_000, Anomaly.WRONG_WAY, 55, 60))
    assert (found, false) == ({"stopping": 0, "wrong_way": 1}, {})
    assert seconds["wrong_way"] == [pytest.approx(0.7)]


def test_another_kind_on_it_finds_nothing_and_is_not_false() -> None:
    assert scored(alarm(2_700_000, Anomaly.PLACE, 55, 60))[:2] == ({"stopping": 0, "wrong_way": 0}, {})


@pytest.mark.parametrize(
    ("t_us", "x", "y"),
    [(1_900_000, 50, 50), (5_100_000, 50, 50), (2_500_000, 200, 100), (2_500_000, 75, 50), (2_500_000, 50, 78)],
)
def test_before_after_elsewhere_and_on_another_is_false(t_us: int, x: float, y: float) -> None:
    assert scored(alarm(t_us, Anomaly.WRONG_WAY, x, y))[:2] == ({"stopping": 0, "wrong_way": 0}, {"wrong_way": 1})


def test_shares_and_rates() -> None:
    scores = score_alarms(np.concatenate([alarm(100, Anomaly.FAST, 300, 200)] * 3), truth(labels=LABELS), 30_000_000)
    assert (scores.share_found, scores.false_per_minute, scores.false_rows) == (0.0, 6.0, [0, 1, 2])
    assert score_alarms(np.empty(0, ALARM), truth(), 1_000_000).share_found == 1.0


def test_the_truth_as_a_log_has_a_track_for_each_time_that_an_object_is_seen() -> None:
    records = truth_log(truth()).records
    born, lost = records[records["kind"] == Kind.BORN], records[records["kind"] == Kind.LOST]
    assert born["t_us"].tolist() == [0, 0, 5_000_000]
    assert sorted(lost["t_us"].tolist()) == [4_000_000, 10_000_000, 10_000_000]
    assert len(np.unique(records["track_id"])) == 3
    assert (np.diff(records["t_us"]) >= 0).all()
    assert set(records["radius"]) == {15.0}
    assert set(records[["width", "height"]].tolist()) == {(20.0, 30.0)}


def highway_truth(seed: int, seconds: int, **planted: int) -> Truth:
    """The truth of a highway without its picture, every 20 ms."""
    settings = scene_settings("highway", seed, {"duration_us": seconds * 10**6, "story": 0, "vehicles_per_s": 1.2, **planted})
    stage = highway._Stage(settings)
    moments = []
    for t_us in range(0, settings.duration_us, 20_000):
        objects = stage.objects(t_us)
        objects["t_us"] = t_us
        moments.append(objects)
    samples = np.concatenate(moments)
    samples["visible"] = on_sensor(samples, (settings.width, settings.height))
    return Truth(samples, (), stage.labels(samples))


def test_on_a_simulated_highway_all_planted_are_found_and_nothing_else() -> None:
    """The rules alone: the truth takes the tracker's place. Seeds 100, 101 and 103."""
    normal = learn([truth_log(highway_truth(100, 60))], (346, 260))
    kinds = dict.fromkeys(("wrong_way", "stopping", "crossing", "loitering", "speeding"), 2)
    for seed in (101, 103):
        planted = highway_truth(seed, 45, **kinds)
        alarms = anomalies(truth_log(planted), None, normal).alarms
        scores = score_alarms(alarms, planted, 45_000_000)
        assert scores.missed == []
        assert scores.false_alarms == {}
        assert scores.found == kinds
        assert max(scores.seconds_to_alarm["speeding"]) < 1.0
        assert max(scores.seconds_to_alarm["wrong_way"]) < 4.0
    ordinary = highway_truth(110, 30)
    assert len(anomalies(truth_log(ordinary), None, normal).alarms) == 0
