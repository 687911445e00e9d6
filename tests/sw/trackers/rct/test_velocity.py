# SPDX-License-Identifier: Apache-2.0
"""Velocity is the true one, in px/s, whatever its direction and size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evcot.trackers.rct.config import RctConfig
from evcot.trackers.rct.tracker import RctTracker
from evcot.tracks.log import Kind

from .stories import events_of, object_at, of_kind, still, tracked

FILTERED = RctConfig(radius_px=16.0, max_clusters=1, alpha=0.02, velocity_alpha=0.01)
REGRESSION = replace(FILTERED, path_points=100)


@pytest.mark.usefixtures("kernels")
@pytest.mark.parametrize(
    "config", [FILTERED, REGRESSION, replace(REGRESSION, predict=1.0)], ids=["filtered", "regression", "predicted"]
)
@pytest.mark.parametrize("direction", range(0, 360, 45))
@pytest.mark.parametrize("speed", [60.0, 300.0, 1_000.0])
def test_it_is_the_true_velocity(speed: float, direction: int, config: RctConfig) -> None:
    heading = np.radians(direction)
    velocity = speed * np.cos(heading), speed * np.sin(heading)
    until_us = 400_000 if speed > 500 else 800_000
    middle = 500 - 0.5e-6 * until_us * velocity[0], 500 - 0.5e-6 * until_us * velocity[1]
    events = object_at(middle, velocity, half=(6, 6), us=(0, until_us), rate_hz=40_000)
    (cluster,) = tracked(events, config)[2]
    error = np.hypot(cluster["velocity_x"] - velocity[0], cluster["velocity_y"] - velocity[1])
    assert error < max(0.05 * speed, 8.0)


def test_regression_is_the_slope_of_the_best_line_through_the_last_places() -> None:
    events = object_at((100, 100), (150, -40), us=(0, 30_000))
    config = replace(REGRESSION, path_points=7)
    tracker = RctTracker(config)
    tracker.feed(events)
    tracker.finish()
    (path,), (cluster,) = tracker.paths(), tracker.clusters()
    assert len(path) == 7
    seconds = 1e-6 * (path["t_us"] - path["t_us"][0])
    assert cluster["velocity_x"] == pytest.approx(np.polyfit(seconds, path["x"], 1)[0])
    assert cluster["velocity_y"] == pytest.approx(np.polyfit(seconds, path["y"], 1)[0])


def test_a_path_is_the_last_moves_oldest_first() -> None:
    events = object_at((100, 100), (150, 0), us=(0, 40_000))
    config = replace(FILTERED, path_points=12)
    tracker = RctTracker(config)
    records, _ = tracker.feed(events)
    records = np.concatenate([records, tracker.finish()])
    (path,) = tracker.paths()
    moved = of_kind(records, Kind.MOVED)[-12:]
    for name in ("t_us", "x", "y"):
        assert path[name].tolist() == moved[name].tolist()


def test_without_path_points_there_is_no_path() -> None:
    tracker = RctTracker(FILTERED)
    tracker.feed(events_of(still(10, 10)))
    assert [len(path) for path in tracker.paths()] == [0]


def test_two_places_say_nothing_about_velocity() -> None:
    rows = [*still(100, 100), *still(110, 100, begin_us=1_000)]
    (cluster,) = tracked(events_of(rows), replace(REGRESSION, alpha=1.0))[2]
    assert (cluster["velocity_x"], cluster["velocity_y"]) == (0, 0)
