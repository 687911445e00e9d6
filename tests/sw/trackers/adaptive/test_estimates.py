# SPDX-License-Identifier: Apache-2.0
"""What the adaptive tracker says about a scene, against how the scene was made."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from evcot.events import Events, Recording
from evcot.scenes.registry import simulate_scene
from evcot.trackers.adaptive.config import AdaptiveConfig
from evcot.trackers.adaptive.estimates import Estimates, ObservedTracker, Spread
from evcot.trackers.adaptive.tracker import AdaptiveTracker
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
