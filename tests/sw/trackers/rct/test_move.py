# SPDX-License-Identifier: Apache-2.0
"""The effect of events on their cluster's position."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evcot.trackers.rct.config import RctConfig

from .stories import object_at, together, tracked


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
