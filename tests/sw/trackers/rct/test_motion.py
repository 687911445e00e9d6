# SPDX-License-Identifier: Apache-2.0
"""Between packets clusters advance with their velocity, as long as it is reliable."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from evcot.trackers.rct.config import RctConfig
from evcot.trackers.rct.tracker import RctTracker
from evcot.tracks.log import Kind

from .stories import WIDTH, events_of, object_at, of_kind, still, together, tracked

CARRIED = RctConfig(radius_px=16.0, max_clusters=1, path_points=20, predict=1.0, lifetime_us=10**6)


def after_silence(config: RctConfig, silence_us: int, velocity: float = 200.0) -> tuple[float, np.void]:
    """How far a cluster went on in a silence after 300 ms on a straight way, and the cluster."""
    events = object_at((100, 100), (velocity, 0), us=(0, 300_000))
    last_us = int(events.t_us[-1])
    ends = []
    for pause_us in (1_000, 1_000 + silence_us):
        tracker = RctTracker(config, WIDTH, 1000)
        tracker.feed(events)
        tracker.feed(events_of([(last_us + pause_us, 900, 900)]))  # too far away to matter but for the time
        (cluster,) = tracker.clusters()
        ends.append(cluster)
    return float(ends[1]["x"] - ends[0]["x"]), ends[1]


def test_prediction_takes_away_the_lag() -> None:
    events = object_at((100, 100), (400, 100), half=(5, 5))
    errors = []
    for predict in (0.0, 1.0):
        records = tracked(events, replace(CARRIED, predict=predict))[0][200:]
        off = np.hypot(100 + 400e-6 * records["t_us"] - records["x"], 100 + 100e-6 * records["t_us"] - records["y"])
        errors.append(float(np.median(off)))
    assert errors[0] > 1.5
    assert errors[1] < 0.5


@pytest.mark.parametrize("share", [1.0, 0.5])
def test_a_silent_cluster_goes_on_by_velocity_times_time(share: float) -> None:
    way_px, cluster = after_silence(replace(CARRIED, predict=share), 50_000)
    assert way_px == pytest.approx(share * cluster["velocity_x"] * 0.050, rel=0.02)
    assert way_px == pytest.approx(share * 10, rel=0.2)


def test_a_coasting_cluster_loses_velocity_with_twice_the_coasting_time() -> None:
    """tau = 20 ms: in 400 ms it goes v tau, less the millisecond before."""
    way_px, cluster = after_silence(replace(CARRIED, coast_us=10_000), 400_000)
    assert way_px == pytest.approx(cluster["velocity_x"] * 0.020 * math.exp(-1 / 20), rel=0.1)


@pytest.mark.parametrize(("path_points", "trusted"), [(20, True), (400, True), (700, False)])
def test_a_velocity_is_trusted_from_half_the_path_on(path_points: int, trusted: bool) -> None:
    """300 positions are known."""
    way_px, cluster = after_silence(replace(CARRIED, path_points=path_points), 50_000)
    assert (way_px > 0) == trusted
    assert cluster["velocity_x"] > 100


def test_it_stays_on_the_sensor() -> None:
    way_px, cluster = after_silence(CARRIED, 900_000, velocity=2_000.0)
    assert cluster["x"] == WIDTH - 1
    assert way_px < WIDTH


def test_the_box_reports_the_middle_of_the_extent_where_the_mean_leans_to_the_busy_edge() -> None:
    """Four fifths of the events come from the right edge."""
    even, edge = object_at((200, 200), half=(10, 6), rate_hz=8_000), object_at((209, 200), half=(1, 6), rate_hz=32_000, seed=2)
    events = together(even, edge)
    plain = RctConfig(radius_px=14.0, max_clusters=1)
    (mean,) = tracked(events, plain)[2]
    (box,) = tracked(events, replace(plain, box_quantile=0.01))[2]
    assert mean["x"] > 206
    assert box["x"] == pytest.approx(200, abs=1)
    assert box["y"] == pytest.approx(200, abs=1)


@pytest.mark.parametrize("quantile", [0.05, 0.2, 0.4])
def test_the_sides_of_the_box_are_quantiles(quantile: float) -> None:
    events = object_at((200, 200), half=(10, 5), rate_hz=50_000)
    config = RctConfig(radius_px=14.0, max_clusters=1, box_quantile=quantile)
    records = tracked(events, config)[0]
    assert float(np.mean(records["radius"][-300:])) == pytest.approx(10 * (1 - 2 * quantile), abs=0.5)


def test_the_box_goes_with_the_predicted_motion() -> None:
    """Without prediction the box of a fast object trails; with it, it stays on the object."""
    events = object_at((100, 500), (500, 0), half=(8, 8), rate_hz=20_000)
    base = RctConfig(radius_px=14.0, max_clusters=1, box_quantile=0.05, path_points=10)
    errors = {}
    for predict in (0.0, 1.0):
        records = tracked(events, replace(base, predict=predict))[0][200:]
        errors[predict] = float(np.median(np.abs(100 + 500e-6 * records["t_us"] - records["x"])))
    assert errors[1.0] < 0.6
    assert errors[0.0] > 2 * errors[1.0]


FILTERED = RctConfig(radius_px=16.0, max_clusters=1, alpha=0.02, velocity_alpha=0.01)
REGRESSION = replace(FILTERED, path_points=100)


@pytest.mark.usefixtures("kernels")
@pytest.mark.parametrize(
    "config", [FILTERED, REGRESSION, replace(REGRESSION, predict=1.0)], ids=["filtered", "regression", "predicted"]
)
@pytest.mark.parametrize("direction", range(0, 360, 45))
@pytest.mark.parametrize("speed", [60.0, 1_000.0])
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


def test_without_a_path_or_with_two_places_there_is_no_velocity_yet() -> None:
    tracker = RctTracker(FILTERED)
    tracker.feed(events_of(still(10, 10)))
    assert [len(path) for path in tracker.paths()] == [0]
    rows = [*still(100, 100), *still(110, 100, begin_us=1_000)]
    (cluster,) = tracked(events_of(rows), replace(REGRESSION, alpha=1.0))[2]
    assert (cluster["velocity_x"], cluster["velocity_y"]) == (0, 0)
