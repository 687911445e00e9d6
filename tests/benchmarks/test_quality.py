# SPDX-License-Identifier: Apache-2.0
"""Measures of quality: scores, and hardware against software."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import cot_quality
import quality
from cot_quality import WHAT_IF, Case, what_if
from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.metrics import load_rule
from evcot.metrics.frames import Frames
from evcot.metrics.truth import OBJECT, GroundTruth
from evcot.trackers.adaptive.config import AdaptiveConfig
from evcot.trackers.adaptive.tracker import AdaptiveTracker
from evcot.tracks.log import TRACK, Kind, TrackLog


def case() -> Case:
    """One object that stands at (10, 10) for 2 s, in 20,000 events."""
    t_us = np.arange(20_000) * 100
    x, p = np.full(20_000, 10, np.uint16), np.ones(20_000, np.uint8)
    objects = np.zeros(100, OBJECT)
    objects["frame"], objects["counted"] = np.arange(100), True
    objects["x"], objects["y"], objects["width"], objects["height"] = 10, 10, 8, 8
    truth = GroundTruth(np.arange(100) * 20_000, objects, ("a",))
    return Case("discs crossing, one", "discs", Recording(Events(t_us, x, x, p), 20, 20), truth, load_rule("scene"))


def test_quality_is_a_mean_over_draws(monkeypatch: pytest.MonkeyPatch) -> None:
    lengths, lost = [], set()

    def follow(given: Case, _: str) -> TrackLog:
        """Exact in the first draw, in two tracks in the others."""
        lengths.append(len(given.recording.events))
        lost.add(bytes(given.recording.events.t_us))
        records = np.zeros(100, TRACK)
        records["t_us"], records["kind"] = given.truth.instants_us, Kind.MOVED
        records["x"], records["y"], records["width"], records["height"] = 10, 10, 8, 8
        records["track_id"] = (len(lengths) > 1) & (np.arange(100) >= 50)
        return TrackLog("some", records, np.empty(0, np.int16))

    monkeypatch.setattr(quality, "follow", follow)
    found = quality.quality([case()], "some")
    assert len(lost) == len(lengths) == quality.DRAWS == 5
    assert all(17_800 < length < 18_200 for length in lengths)
    minutes = 99 * 0.02 / 60
    assert found.switches == pytest.approx(0.8 / minutes)  # per minute; 4 switches in 5 draws
    assert found.idf1 == pytest.approx((1 + 4 * 0.5) / 5, abs=0.02)  # the first track is there for 60 ms more
    assert found.hota == pytest.approx((1 + 4 * np.sqrt(0.5)) / 5, abs=0.02)


def test_an_engine_without_a_preset_for_the_scene_has_its_first(monkeypatch: pytest.MonkeyPatch) -> None:
    started = []

    def start(settings: str, filters: FilterConfig, sensor: tuple[int, int]) -> Any:
        started.append((settings, filters, sensor))
        return AdaptiveTracker(AdaptiveConfig(), *sensor)

    filters = FilterConfig(refractory_us=7)
    for presets in ({"auto": "first", "motion": "second"}, {"auto": "first", "discs": "own"}):
        engine = SimpleNamespace(presets=presets, filters={"auto": filters}, start=start)
        monkeypatch.setattr(quality, "ENGINES", {"some": engine})
        quality.follow(case(), "some")
    assert started == [("first", filters, (20, 20)), ("own", FilterConfig(), (20, 20))]


N = 10  # instants


def story(tracks: Sequence[Sequence[int]], similarity: float = 1.0) -> Frames:
    """One object at every instant. Tracks per instant: the first that is not 9 lies on it, number 9 lies nowhere."""
    similarities = [np.array([[0.0 if track == 9 else similarity for track in own]]) for own in tracks]
    return Frames(
        tuple(np.array([0]) for _ in tracks),
        tuple(np.array(own, np.int64) for own in tracks),
        tuple(one.reshape(1, len(own)) for one, own in zip(similarities, tracks, strict=True)),
        1,
        10,
    )


@pytest.mark.parametrize(
    ("frames", "mended"),
    [
        (story([[1]] * N, 0.4), "every track on its object's centre"),
        (story([[1]] * (N // 2) + [[2]] * (N // 2)), "no switch"),
        (story([[1, 9]] * N), "no false track"),
        (story([[1]] * (N - 3) + [[]] * 3), "no object missed"),
    ],
)
def test_a_story_with_one_mistake_is_perfect_once_that_is_mended(frames: Frames, mended: str) -> None:
    found = what_if(frames)
    assert list(found) == list(WHAT_IF)
    assert found.pop(mended) == pytest.approx(1)
    assert {round(value, 9) for value in found.values()} == {round(found["as it is"], 9)}
    assert found["as it is"] < 0.9


def test_what_if_finds_pairs_in_any_order_of_numbers() -> None:
    nearness = np.array([[0.0, 0.8], [0.6, 0.0]])
    swapped = nearness[:, ::-1].copy()
    frames = Frames(
        (np.array([1, 0]),) * 2, (np.array([7, 3]), np.array([3, 7])), (nearness, swapped), 2, 8
    )  # object 1 has track 3, object 0 has track 7
    found = what_if(frames)
    assert found["every track on its object's centre"] == pytest.approx(1)
    assert found["no switch"] == pytest.approx(found["as it is"])


def test_a_truth_between_two_times() -> None:
    objects = np.zeros(4, OBJECT)
    objects["frame"], objects["object"] = (0, 1, 1, 2), (5, 5, 6, 6)
    truth = GroundTruth(np.array([100, 200, 300]), objects, tuple("abcdefg"))
    part = cot_quality.between(truth, 200, 300)
    assert part.instants_us.tolist() == [200]
    assert (part.objects["frame"].tolist(), part.objects["object"].tolist()) == ([0, 0], [5, 6])
    assert truth.objects["frame"].tolist() == [0, 1, 1, 2]  # untouched


def test_a_tuned_preset_beats_the_one_for_the_sensor_and_hardware_and_model_agree() -> None:
    case = cot_quality.simulated("discs", "discs", "discs", {"duration_us": 1_000_000}, 21)
    tuned, untuned = (cot_quality.score(case, cot_quality.ENGINES[name]).hota for name in ("hardware", "hardware, untuned"))
    assert tuned > untuned + 0.02
