# SPDX-License-Identifier: Apache-2.0
"""The golden model behind filters that follow the noise."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from evcot.events import Events
from evcot.filters.run import filtered
from evcot.hardware.config import MotionConfig
from evcot.hardware.golden import GoldenTracker
from evcot.hardware.motion.model import MotionModel
from evcot.scenes.registry import simulate_scene
from evcot.ticks import TickedEvents
from evcot.trackers.engines import ENGINES
from evcot.trackers.following import FollowingTracker
from evcot.trackers.presets import FOLLOWING, fit
from evcot.tracks.log import DROPPED, TrackLog
from evcot.tracks.tracking import log_of
from support.bursts import Square, bursts

SENSOR = 346, 260


@pytest.fixture(scope="module")
def events() -> Events:
    """Six discs for a second."""
    return simulate_scene("discs", 7, {"duration_us": 1_000_000}).recording.events


def device_config(sensor: tuple[int, int]) -> MotionConfig:
    hardware = fit(FOLLOWING, *sensor).hardware
    assert isinstance(hardware, MotionConfig)
    return hardware


def started() -> FollowingTracker:
    tracker = ENGINES["cot_motion"].start(FOLLOWING, FOLLOWING.filters, SENSOR)
    assert isinstance(tracker, FollowingTracker)
    return tracker


def assert_same(got: TrackLog, wanted: TrackLog) -> None:
    assert np.array_equal(got.records, wanted.records)
    assert np.array_equal(got.owner, wanted.owner)


def test_it_is_the_model_of_cot_motion_on_the_events_that_pass(events: Events) -> None:
    keep = filtered((), FOLLOWING.filters, SENSOR).keep(events)
    model = MotionModel(device_config(SENSOR))
    decided = model.feed(TickedEvents.of(events), keep)
    _, owner = started().feed(events)
    assert np.array_equal(owner, decided.owner)
    assert np.array_equal(owner == DROPPED, ~keep)
    assert np.count_nonzero(owner >= 0) > 0.8 * len(events)


def test_it_does_not_depend_on_how_events_are_split_into_runs(events: Events) -> None:
    whole = log_of("cot_motion", started(), [events])
    assert_same(log_of("cot_motion", started(), [events[begin : begin + 777] for begin in range(0, len(events), 777)]), whole)
    assert len(np.unique(whole.records["track_id"])) == 6


def test_what_it_has_seen_does_not_either(events: Events) -> None:
    one, other = started(), started()
    one.feed(events)
    for begin in range(0, len(events), 777):
        other.feed(events[begin : begin + 777])
    assert str(one) == str(other)


def test_it_goes_on_where_it_was_stored(events: Events) -> None:
    whole, first = log_of("cot_motion", started(), [events]), started()
    head = first.feed(events[:40_000])
    stored = pickle.loads(pickle.dumps(first))
    tail = stored.feed(events[40_000:])
    assert np.array_equal(np.concatenate([head[0], tail[0]]), whole.records)


def test_filters_that_hold_are_those_of_the_hardware() -> None:
    held = replace(FOLLOWING.filters, activity_noise_hz=0.0)
    tracker = ENGINES["cot_motion"].start(FOLLOWING, held, SENSOR)
    assert type(tracker) is GoldenTracker


@pytest.mark.parametrize("sensor", [(240, 180), (346, 260)])
@pytest.mark.parametrize("step_ms", [1, 10, 20, 33, 50, 100])
def test_an_object_whose_events_come_in_bursts_has_one_track_that_follows_it(step_ms: int, sensor: tuple[int, int]) -> None:
    square = Square(70, 110, 20, -20)
    tracker = FollowingTracker(device_config(sensor), FOLLOWING.filters, sensor)
    records, _ = tracker.feed(bursts(step_ms, [square], sensor))
    assert len(np.unique(records["track_id"])) == 1
    assert records["t_us"][0] < 200_000 + 6_000 * step_ms
    truth = np.array([square.corner(int(t) // 1_000 // step_ms * step_ms * 1_000) for t in records["t_us"]]) + 19.5
    assert np.median(np.hypot(records["x"] - truth[:, 0], records["y"] - truth[:, 1])) < 2


@pytest.mark.parametrize("step_ms", [10, 20, 33, 50])
def test_two_objects_whose_events_come_in_bursts_have_two(step_ms: int) -> None:
    squares = [Square(20, 20, 60, 0, side=30), Square(150, 120, -40, 0, side=30)]
    records, _ = FollowingTracker(device_config(SENSOR), FOLLOWING.filters, SENSOR).feed(bursts(step_ms, squares, SENSOR))
    assert len(np.unique(records["track_id"])) == 2
