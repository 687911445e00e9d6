# SPDX-License-Identifier: Apache-2.0
"""What the adaptive tracker says about a scene, against how the scene was made."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from evcot.events import Events, Recording
from evcot.scenes.registry import simulate_scene
from evcot.trackers.adaptive.config import AdaptiveConfig
from evcot.trackers.adaptive.estimates import SAMPLE_US, Estimates, ObservedTracker, Spread, _Histogram
from evcot.trackers.adaptive.tracker import SIGHTING, AdaptiveTracker
from evcot.tracks.tracking import log_of

SENSOR = (128, 96)


def blobs(objects: int, speed_px_s: float, half_px: float, noise_hz: float, duration_s: float = 2.0) -> Events:
    """Squares that travel to the right and come again from the left, on noise; the pixel (100, 90) never rests."""
    random = np.random.default_rng(7)
    n = int(4_000 * objects * duration_s)
    t_us = random.integers(0, int(1e6 * duration_s), n)
    which = random.integers(0, objects, n)
    travel = SENSOR[0] - 2 * half_px - 4
    centre = half_px + 2 + (1e-6 * t_us * speed_px_s) % travel
    side = np.where(random.random(n) < 0.5, -half_px, half_px)
    x = np.clip(centre + side, 0, SENSOR[0] - 1)
    y = np.clip((which + 0.5) * 80 / objects + random.uniform(-half_px, half_px, n), 0, SENSOR[1] - 1)
    m = int(noise_hz * SENSOR[0] * SENSOR[1] * duration_s)
    hot_us = np.arange(0, int(1e6 * duration_s), 2_000)
    columns = (
        np.concatenate([t_us, random.integers(0, int(1e6 * duration_s), m), hot_us]),
        np.concatenate([x, random.integers(0, SENSOR[0], m), np.full(len(hot_us), 100)]),
        np.concatenate([y, random.integers(0, SENSOR[1], m), np.full(len(hot_us), 90)]),
    )
    order = np.argsort(columns[0], kind="stable")
    t_us, x, y = (column[order] for column in columns)
    return Events(t_us.astype(np.int64), x.astype(np.uint16), y.astype(np.uint16), (t_us % 2).astype(np.uint8))


def estimated(*runs: Events, sensor: tuple[int, int] = SENSOR) -> Estimates:
    observed = ObservedTracker(AdaptiveConfig(), *sensor)
    for run in runs:
        observed.feed(run)
    return observed.estimates()


@pytest.fixture(scope="module")
def events() -> Events:
    return blobs(2, 40.0, 6.0, 1.0)


@pytest.fixture(scope="module")
def seen(events: Events) -> Estimates:
    return estimated(events)


def test_size_speed_and_number_are_those_of_the_objects(seen: Estimates) -> None:
    assert seen.half_px is not None
    assert seen.speed_px_s is not None
    assert seen.alive_most == 2
    assert 0.7 * 6.0 < seen.half_px.low < seen.half_px.high < 1.3 * 6.0
    assert 0.8 * 40.0 < seen.speed_px_s.low < seen.speed_px_s.high < 1.2 * 40.0


def test_noise_hot_pixels_and_length_are_those_of_the_stream(events: Events, seen: Estimates) -> None:
    assert seen.noise_hz is not None
    assert 0.5 < seen.noise_hz < 2.0  # what objects leave behind is noise, too
    assert seen.hot == 1
    assert seen.seen_us == events.t_us[-1] - events.t_us[0]
    assert estimated() == estimated(Events.empty()) == Estimates(SENSOR)


def test_the_splitting_into_runs_changes_nothing(events: Events, seen: Estimates) -> None:
    cuts = np.random.default_rng(1).integers(0, len(events), 50)
    edges = [0, *np.sort(cuts).tolist(), len(events)]
    assert estimated(*(events[a:b] for a, b in pairwise(edges))) == seen


def test_sampling_changes_no_track(events: Events) -> None:
    plain, observed = (
        log_of("adaptive", make(AdaptiveConfig(), *SENSOR), [events]) for make in (AdaptiveTracker, ObservedTracker)
    )
    assert len(plain.records)
    assert np.array_equal(plain.records, observed.records)
    assert np.array_equal(plain.owner, observed.owner)


def test_noise_alone_has_no_objects() -> None:
    random = np.random.default_rng(3)
    n = 2 * SENSOR[0] * SENSOR[1]
    t_us = np.sort(random.integers(0, 2_000_000, n)).astype(np.int64)
    x, y = (random.integers(0, size, n).astype(np.uint16) for size in SENSOR)
    seen = estimated(Events(t_us, x, y, (t_us % 2).astype(np.uint8)))
    assert (seen.half_px, seen.alive_most, seen.hot) == (None, 0, 0)
    assert seen.noise_hz == pytest.approx(1.0, rel=0.4)


def test_the_line() -> None:
    shown = Estimates((346, 260), 4_000_000, 0.4, 1, 3, Spread(3.0, 8.0), Spread(40.0, 160.0))
    line = "adaptive: 346x260, 4 s, noise 0.4 Hz/pixel, 1 hot pixel, up to 3 objects of 6 to 16 px, 40 to 160 px/s"
    assert str(shown) == line
    nothing = "adaptive: 128x96, 0 s, noise unknown, 0 hot pixels, no object seen for long enough"
    assert str(Estimates(SENSOR)) == nothing


def test_discs_of_a_scene() -> None:
    recording: Recording = simulate_scene("discs", 5, {"duration_us": 2_000_000, "ways": "separate"}).recording
    seen = estimated(recording.events, sensor=(recording.width, recording.height))
    assert seen.half_px is not None
    assert 0.8 * 9.0 < seen.half_px.low < seen.half_px.high < 1.2 * 9.0


@pytest.mark.parametrize(("value", "decades"), [(1.0, 2.005), (1.024, 2.015), (1e-3, 0.005), (0.0, 0.005), (1e9, 7.995)])
def test_a_histogram_has_a_hundred_bins_per_decade_from_a_hundredth_on(value: float, decades: float) -> None:
    histogram = _Histogram()
    assert not histogram.any
    histogram.add(np.array([value, value]))
    assert histogram.any
    assert histogram.quantile(0.5) == pytest.approx(0.01 * 10**decades)


def ends_of(spread: Spread | None) -> tuple[float, float]:
    assert spread is not None
    return spread.low, spread.high


def test_a_tenth_of_the_values_lies_below_the_spread_and_a_tenth_above() -> None:
    histogram = _Histogram()
    histogram.add(np.array([1.0, 1e1, 1e2, 1e3, 1e4]))
    histogram.add(np.array([1e1] * 13 + [1e2]))
    assert histogram.spread() is None, "19 tell nothing"
    histogram.add(np.array([1e4]))
    assert ends_of(histogram.spread()) == pytest.approx((10, 1e3), rel=0.02)  # 2 and 18 of 20


class Samples:
    """A tracker that shows so many objects of 3 and 4 px, one sample after the other."""

    def __init__(self, *visible: int) -> None:
        self.visible, self.settled, self.noise_hz = list(visible), 0, 0.5
        self.fed: list[int] = []
        self.sampled_at: list[int] = []

    def feed(self, events: Events) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        self.fed += events.t_us.tolist()
        return np.empty(0), np.zeros(len(events), np.int16)

    def sightings(self) -> np.ndarray[Any, Any]:
        self.sampled_at.append(self.fed[-1])
        seen = np.zeros(self.visible.pop(0), SIGHTING)
        seen["half_x"], seen["half_y"], seen["speed_px_s"] = 3.0, 4.0, 50.0
        return seen

    def restless(self) -> np.ndarray[Any, Any]:
        return np.array([[True, len(self.sampled_at) % 2 == 1]])


def at_times(*t_us: int) -> Events:
    none = np.zeros(len(t_us), np.uint16)
    return Events(np.array(t_us, np.int64), none, none, none.astype(np.uint8))


@pytest.mark.parametrize("runs", [1, 2, 5])
def test_the_state_is_sampled_every_50_ms_before_the_event_at_that_time(runs: int) -> None:
    observed = ObservedTracker(AdaptiveConfig(), 2, 1)
    tracker = observed._tracker = Samples(0, 1, 2, 1)  # type: ignore[assignment]
    t_us = [7, SAMPLE_US + 6, SAMPLE_US + 7, 2 * SAMPLE_US + 6, 4 * SAMPLE_US + 50, 5 * SAMPLE_US + 7]
    for part in np.array_split(np.array(t_us), runs):
        observed.feed(at_times(*part.tolist()))
    assert tracker.fed == t_us
    assert tracker.sampled_at == [SAMPLE_US + 6, 2 * SAMPLE_US + 6, 4 * SAMPLE_US + 50]
    assert observed.estimates().seen_us == 5 * SAMPLE_US


def test_estimates_are_made_of_the_samples() -> None:
    observed = ObservedTracker(AdaptiveConfig(), 2, 1)
    observed._tracker = Samples(*[1] * 98, 3, 2)  # type: ignore[assignment]
    observed.feed(at_times(*range(0, 101 * SAMPLE_US, SAMPLE_US)))
    seen = observed.estimates()
    assert (seen.alive_most, seen.hot, seen.seen_us) == (2, 1, 100 * SAMPLE_US)  # 3 in one sample of a hundred
    assert ends_of(seen.half_px) == pytest.approx((4, 4), rel=0.02)
    assert ends_of(seen.speed_px_s) == pytest.approx((50, 50), rel=0.02)
    assert seen.noise_hz == pytest.approx(0.5, rel=0.02)


@pytest.mark.parametrize(("samples", "hot"), [(19, 0), (20, 1), (22, 1)])
def test_hot_pixels_are_those_ignored_in_most_samples_from_the_first_second_on(samples: int, hot: int) -> None:
    observed = ObservedTracker(AdaptiveConfig(), 2, 1)
    observed._tracker = Samples(*[0] * samples)  # type: ignore[assignment]
    observed.feed(at_times(*range(0, (samples + 1) * SAMPLE_US, SAMPLE_US)))
    assert observed.estimates().hot == hot
