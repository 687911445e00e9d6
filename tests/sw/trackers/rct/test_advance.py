# SPDX-License-Identifier: Apache-2.0
"""Between packets clusters advance with their velocity, as long as it is reliable."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from evcot.trackers.rct.config import RctConfig
from evcot.trackers.rct.tracker import RctTracker

from .stories import WIDTH, events_of, object_at, tracked

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
