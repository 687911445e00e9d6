# SPDX-License-Identifier: Apache-2.0
"""What the adaptive tracker says about a scene, against how the scene was made."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from evcot.events import Events, Recording
from evcot.scenes.registry import simulate_scene
from evcot.trackers.adaptive import estimates
from evcot.trackers.adaptive.config import AdaptiveConfig
from evcot.trackers.adaptive.estimates import Estimates, ObservedTracker, Spread, estimate
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


@pytest.fixture(scope="module")
def events() -> Events:
    return blobs(2, 40.0, 6.0, 1.0)


@pytest.fixture(scope="module")
def seen(events: Events) -> Estimates:
    return estimate([events], SENSOR)


def test_size_speed_and_number_are_those_of_the_objects(seen: Estimates) -> None:
    assert seen.objects is not None
    assert seen.alive == 2
    assert seen.objects.long_px.median == pytest.approx(6.0, rel=0.3)
    assert seen.objects.speed_px_s.median == pytest.approx(40.0, rel=0.2)


def test_noise_and_hot_pixels_are_those_of_the_sensor(seen: Estimates) -> None:
    assert seen.noise_hz is not None
    assert 0.5 < seen.noise_hz < 2.0  # what objects leave behind is noise, too
    assert seen.hot_pixels == ((100, 90),)


def test_the_length_of_what_was_seen(events: Events, seen: Estimates) -> None:
    assert (seen.events, seen.seen_us) == (len(events), int(events.t_us[-1] - events.t_us[0]))


def test_the_splitting_into_runs_changes_nothing(events: Events, seen: Estimates) -> None:
    cuts = np.random.default_rng(1).integers(0, len(events), 50)
    edges = [0, *np.sort(cuts).tolist(), len(events)]
    assert estimate((events[a:b] for a, b in pairwise(edges)), SENSOR) == seen


def test_who_is_looked_at_tracks_as_before(events: Events) -> None:
    plain, observed = (
        log_of("adaptive", make(AdaptiveConfig(), *SENSOR), [events]) for make in (AdaptiveTracker, ObservedTracker)
    )
    assert len(plain.records)
    assert np.array_equal(plain.records, observed.records)
    assert np.array_equal(plain.owner, observed.owner)


@pytest.mark.parametrize(("bound", "value"), [("SEEN_US", 500_000), ("SEEN_EVENTS", 9_000)])
def test_what_comes_after_the_bound_is_not_looked_at(
    events: Events, monkeypatch: pytest.MonkeyPatch, bound: str, value: int
) -> None:
    monkeypatch.setattr(estimates, bound, value)
    n = value if bound == "SEEN_EVENTS" else int(np.searchsorted(events.t_us, events.t_us[0] + value))
    assert estimate([events[: n // 2], events[n // 2 :]], SENSOR) == estimate([events[:n]], SENSOR)
    assert estimate([events], SENSOR).events == n


def test_nothing_is_estimated_from_nothing() -> None:
    assert estimate([], SENSOR) == estimate([Events.empty()], SENSOR) == Estimates(SENSOR)


def test_noise_alone_has_no_objects() -> None:
    random = np.random.default_rng(3)
    n = 2 * SENSOR[0] * SENSOR[1]
    t_us = np.sort(random.integers(0, 2_000_000, n)).astype(np.int64)
    x, y = (random.integers(0, size, n).astype(np.uint16) for size in SENSOR)
    seen = estimate([Events(t_us, x, y, (t_us % 2).astype(np.uint8))], SENSOR)
    assert (seen.objects, seen.alive_most, seen.hot_pixels) == (None, 0, ())
    assert seen.noise_hz == pytest.approx(1.0, rel=0.4)


def test_the_line(seen: Estimates) -> None:
    assert seen.objects is not None
    size, speed = Spread(3.0, 5.0, 8.0), Spread(40.0, 80.0, 160.0)
    shown = replace(
        seen,
        sensor=(346, 260),
        seen_us=4_000_000,
        noise_hz=0.4,
        alive_most=3,
        objects=replace(seen.objects, long_px=size, speed_px_s=speed),
    )
    line = "auto: 346x260, 4 s, noise 0.4 Hz/pixel, 1 hot pixel, up to 3 objects of 6 to 16 px, 40 to 160 px/s"
    assert str(shown) == line
    nothing = "auto: 128x96, 0 s, noise unknown, 0 hot pixels, no object seen for long enough"
    assert str(Estimates(SENSOR)) == nothing


def test_discs_of_a_scene() -> None:
    recording: Recording = simulate_scene("discs", 5, {"duration_us": 2_000_000, "ways": "separate"}).recording
    seen = estimate([recording.events], (recording.width, recording.height))
    assert seen.objects is not None
    assert seen.objects.long_px.median == pytest.approx(9.0, rel=0.2)
