# SPDX-License-Identifier: Apache-2.0
"""Windows follow the size and shape of their objects."""

from __future__ import annotations

from dataclasses import replace

import pytest

from evcot.trackers.rct.config import RctConfig
from evcot.trackers.rct.tracker import RctTracker

from .stories import events_of, object_at, tracked

DYNAMIC = RctConfig(radius_px=12.0, max_clusters=1, dynamic_size=True, visible_events=100)
MARGIN = 1.4  # of the window around a filled object


@pytest.mark.parametrize("quantile", [0.0, 0.05, 0.2])
@pytest.mark.parametrize("half", [6.0, 20.0])
def test_a_window_follows_the_size_of_its_object(half: float, quantile: float) -> None:
    (cluster,) = tracked(object_at((200, 200), half=(half, half)), replace(DYNAMIC, box_quantile=quantile))[2]
    assert cluster["half_width"] == cluster["half_height"] == pytest.approx(MARGIN * half, rel=0.15)


def test_the_larger_side_decides_and_the_aspect_stays() -> None:
    (cluster,) = tracked(object_at((200, 200), half=(6, 18)), replace(DYNAMIC, aspect=1.5, radius_px=14.0))[2]
    assert cluster["half_height"] == pytest.approx(MARGIN * 18, rel=0.15)
    assert cluster["half_width"] == pytest.approx(cluster["half_height"] / 1.5)


@pytest.mark.parametrize(("half", "limit"), [(1.0, 4.0), (80.0, 48.0)])
def test_dynamic_sizes_have_limits(half: float, limit: float) -> None:
    (cluster,) = tracked(object_at((200, 200), half=(half, half)), DYNAMIC)[2]
    assert cluster["half_width"] == pytest.approx(limit)


def test_an_invisible_cluster_keeps_its_size() -> None:
    (cluster,) = tracked(object_at((200, 200), half=(4, 4)), replace(DYNAMIC, visible_events=1_000_000))[2]
    assert cluster["half_width"] == 12.0


@pytest.mark.parametrize(("y", "scale"), [(250, 0.5), (450, 1.0), (850, 2.0)])
def test_windows_scale_with_the_distance_from_the_vanishing_row(y: int, scale: float) -> None:
    """The row is y = 50; the radius holds 400 px away."""
    tracker = RctTracker(RctConfig(radius_px=16.0, vanishing_y_px=50.0, reference_y_px=450.0))
    tracker.feed(events_of([(0, 300, y)]))
    (cluster,) = tracker.clusters()
    assert cluster["half_width"] == cluster["half_height"] == pytest.approx(16 * scale)


def test_a_window_shrinks_on_the_way_to_the_vanishing_row() -> None:
    events = object_at((300, 450), (0, -300), half=(4, 4))
    config = RctConfig(
        radius_px=16.0, max_clusters=1, alpha=0.1, vanishing_y_px=50.0, reference_y_px=450.0, predict=1.0, path_points=20
    )
    records = tracked(events, config)[0]
    expected = 16 * (records["y"] - 50) / 400
    assert records["radius"][50:] == pytest.approx(expected[50:], rel=0.05)
    assert records["radius"][-1] < 0.3 * records["radius"][50]
