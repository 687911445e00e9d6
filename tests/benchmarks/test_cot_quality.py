# SPDX-License-Identifier: Apache-2.0
"""The hardware's quality: parts of a truth, what-ifs on stories with one mistake each, and presets that earn their names."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from evcot.metrics.frames import Frames
from evcot.metrics.truth import OBJECT, GroundTruth

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
N = 10  # instants


@pytest.fixture
def benchmark(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return importlib.import_module


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
def test_a_story_with_one_mistake_is_perfect_once_that_is_mended(benchmark: Any, frames: Frames, mended: str) -> None:
    found = benchmark("what_if").what_if(frames)
    assert list(found) == list(benchmark("what_if").WHAT_IF)
    assert found.pop(mended) == pytest.approx(1)
    assert {round(value, 9) for value in found.values()} == {round(found["as it is"], 9)}
    assert found["as it is"] < 0.9


def test_what_if_finds_pairs_in_any_order_of_numbers(benchmark: Any) -> None:
    nearness = np.array([[0.0, 0.8], [0.6, 0.0]])
    swapped = nearness[:, ::-1].copy()
    frames = Frames(
        (np.array([1, 0]),) * 2, (np.array([7, 3]), np.array([3, 7])), (nearness, swapped), 2, 8
    )  # object 1 has track 3, object 0 has track 7
    found = benchmark("what_if").what_if(frames)
    assert found["every track on its object's centre"] == pytest.approx(1)
    assert found["no switch"] == pytest.approx(found["as it is"])


def test_a_truth_between_two_times(benchmark: Any) -> None:
    objects = np.zeros(4, OBJECT)
    objects["frame"], objects["object"] = (0, 1, 1, 2), (5, 5, 6, 6)
    truth = GroundTruth(np.array([100, 200, 300]), objects, tuple("abcdefg"))
    part = benchmark("cot_quality").between(truth, 200, 300)
    assert part.instants_us.tolist() == [200]
    assert (part.objects["frame"].tolist(), part.objects["object"].tolist()) == ([0, 0], [5, 6])
    assert truth.objects["frame"].tolist() == [0, 1, 1, 2]  # untouched


def test_a_tuned_preset_beats_the_one_for_the_sensor_and_hardware_and_model_agree(benchmark: Any) -> None:
    quality = benchmark("cot_quality")
    case = quality.simulated("discs", "discs", "discs", {"duration_us": 1_000_000}, 21)
    tuned, untuned = (quality.score(case, quality.ENGINES[name]).hota for name in ("hardware", "hardware, untuned"))
    assert tuned > untuned + 0.02
