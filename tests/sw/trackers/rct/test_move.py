# SPDX-License-Identifier: Apache-2.0
"""The effect of events on their cluster's position."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from evcot.trackers.rct.config import RctConfig

from .stories import events_of, object_at, together, tracked

PER_RATE = RctConfig(radius_px=20.0, alpha_tau_us=2_000.0, packet_us=10**6)


def test_mixing_per_rate_is_one_minus_exp_of_the_time_since_the_last_event() -> None:
    rows = [(0, 100, 50), (500, 110, 50), (500, 90, 50), (4_500, 105, 55), (4_500 + 6_000, 95, 45)]  # the last beyond the table
    x, y, before = 100.0, 50.0, 0
    for t, ex, ey in rows[1:]:
        alpha = 1 - math.exp(-(t - before) / 2_000.0)
        x, y, before = (1 - alpha) * x + alpha * ex, (1 - alpha) * y + alpha * ey, t
    (cluster,) = tracked(events_of(rows), PER_RATE)[2]
    assert (cluster["x"], cluster["y"]) == pytest.approx((x, y), abs=1e-12)


def test_mixing_per_rate_lags_a_moving_object_by_tau_at_any_rate_and_a_fixed_factor_does_not() -> None:
    lags: dict[str, list[float]] = {"rate": [], "fixed": []}
    for rate_hz in (5_000.0, 40_000.0):
        events = object_at((100, 100), (400, 0), rate_hz=rate_hz, half=(5, 5))
        for name, config in (("rate", PER_RATE), ("fixed", replace(PER_RATE, alpha_tau_us=0.0, alpha=0.05))):
            config = replace(config, packet_us=1_000, max_clusters=1)
            records = tracked(events, config)[0][100:]
            lags[name].append(float(np.mean(100 + 400e-6 * records["t_us"] - records["x"])))
    assert lags["rate"] == pytest.approx([0.8, 0.8], abs=0.15)  # 400 px/s over 2 ms
    assert lags["fixed"][0] > 4 * lags["fixed"][1]


def test_the_box_reports_the_middle_of_the_extent_where_the_mean_leans_to_the_busy_edge() -> None:
    """Four fifths of the events come from the right edge."""
    even, edge = object_at((200, 200), half=(10, 6), rate_hz=8_000), object_at((209, 200), half=(1, 6), rate_hz=32_000, seed=2)
    events = together(even, edge)
    plain = RctConfig(radius_px=14.0, max_clusters=1)
    (mean,) = tracked(events, plain)[2]
    (box,) = tracked(events, replace(plain, centre="box", box_quantile=0.01, box_alpha=0.01))[2]
    assert mean["x"] > 206
    assert box["x"] == pytest.approx(200, abs=1)
    assert box["y"] == pytest.approx(200, abs=1)


@pytest.mark.parametrize("quantile", [0.05, 0.2, 0.4])
def test_the_sides_of_the_box_are_quantiles(quantile: float) -> None:
    events = object_at((200, 200), half=(10, 5), rate_hz=50_000)
    config = RctConfig(radius_px=14.0, max_clusters=1, centre="box", box_quantile=quantile, box_alpha=0.002)
    records = tracked(events, config)[0]
    assert float(np.mean(records["radius"][-300:])) == pytest.approx(10 * (1 - 2 * quantile), abs=0.5)


def test_the_box_goes_with_the_predicted_motion() -> None:
    """Without prediction the box of a fast object trails; with it, it stays on the object."""
    events = object_at((100, 500), (500, 0), half=(8, 8), rate_hz=20_000)
    base = RctConfig(radius_px=14.0, max_clusters=1, centre="box", velocity="regression", path_points=10)
    errors = {}
    for predict in (0.0, 1.0):
        records = tracked(events, replace(base, predict=predict))[0][200:]
        errors[predict] = float(np.median(np.abs(100 + 500e-6 * records["t_us"] - records["x"])))
    assert errors[1.0] < 0.6
    assert errors[0.0] > 2 * errors[1.0]
