# SPDX-License-Identifier: Apache-2.0
"""Windows follow the size and shape of their objects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evcot.trackers.rct.config import RctConfig
from evcot.trackers.rct.tracker import RctTracker

from .stories import events_of, object_at, together, tracked

DEVIATION = RctConfig(radius_px=12.0, max_clusters=1, size="deviation", size_ratio=2.5, visible_events=100, radius_min_px=2.0)
QUANTILE = replace(DEVIATION, size="quantile", size_ratio=1.5)


@pytest.mark.parametrize("half", [(6.0, 6.0), (20.0, 20.0), (16.0, 6.0), (5.0, 18.0)])
def test_both_sides_follow_the_deviation_of_full_objects(half: tuple[float, float]) -> None:
    """Evenly full: the mean absolute deviation is half of half a side."""
    (cluster,) = tracked(object_at((200, 200), half=half), replace(DEVIATION, free_aspect=True))[2]
    assert (cluster["half_width"], cluster["half_height"]) == pytest.approx([2.5 * h / 2 for h in half], rel=0.15)


@pytest.mark.parametrize("half", [(6.0, 6.0), (20.0, 20.0), (16.0, 6.0), (5.0, 18.0)])
def test_both_sides_follow_the_quantiles(half: tuple[float, float]) -> None:
    (cluster,) = tracked(object_at((200, 200), half=half), replace(QUANTILE, free_aspect=True))[2]
    assert (cluster["half_width"], cluster["half_height"]) == pytest.approx([1.5 * 0.9 * h for h in half], rel=0.15)


def test_with_a_fixed_aspect_the_larger_side_decides() -> None:
    (cluster,) = tracked(object_at((200, 200), half=(6, 18)), replace(QUANTILE, aspect=1.5, radius_px=14.0))[2]
    assert cluster["half_height"] == pytest.approx(1.5 * 0.9 * 18, rel=0.15)
    assert cluster["half_width"] == pytest.approx(cluster["half_height"] / 1.5)


@pytest.mark.parametrize(("half", "limit"), [(2.0, 8.0), (40.0, 15.0)])
def test_sizes_have_limits(half: float, limit: float) -> None:
    config = replace(QUANTILE, radius_min_px=8.0, radius_max_px=15.0)
    (cluster,) = tracked(object_at((200, 200), half=(half, half)), config)[2]
    assert cluster["half_width"] == limit


def test_the_surround_lets_a_window_grow_that_its_own_events_would_not() -> None:
    """A small object's edges appear outside the window: their events pull the size, not the place."""
    inner, ring = object_at((200, 200), half=(3, 3)), object_at((200, 200), half=(10, 3), seed=2, hollow=True)
    sizes = {}
    for surround in (1.0, 3.0):
        config = replace(DEVIATION, radius_px=6.0, radius_max_px=30.0, surround=surround, size_ratio=2.2, free_aspect=True)
        (cluster,) = tracked(together(inner, ring), config)[2]
        sizes[surround] = cluster["half_width"]
        assert cluster["x"] == pytest.approx(200, abs=1)
    assert sizes[1.0] < 4
    assert sizes[3.0] > 9


@pytest.mark.parametrize("degrees", [0, 30, 90, 150])
def test_the_angle_is_that_of_the_longer_axis(degrees: int) -> None:
    rng = np.random.default_rng(2)
    along, across = rng.uniform(-18, 18, 20_000), rng.uniform(-4, 4, 20_000)
    heading = np.radians(degrees)
    x = 200 + along * np.cos(heading) - across * np.sin(heading)
    y = 200 + along * np.sin(heading) + across * np.cos(heading)
    events = events_of([(20 * i, round(a), round(b)) for i, (a, b) in enumerate(zip(x, y, strict=True))])
    config = replace(DEVIATION, radius_px=20.0, angle=True, free_aspect=True)
    (cluster,) = tracked(events, config)[2]
    off = (cluster["angle"] - heading + np.pi / 2) % np.pi - np.pi / 2
    assert abs(off) < 0.06
    assert cluster["half_width"] == pytest.approx(2.5 * 9, rel=0.15)
    assert cluster["half_height"] == pytest.approx(2.5 * 2, rel=0.25)


@pytest.mark.parametrize(
    ("perspective", "place", "scale"),
    [
        ("row", (300, 250), 0.5),
        ("row", (10, 450), 0.9),
        ("point", (300, 250), 0.5),
        ("point", (300 + 300, 50 + 400), 500 / 400),
    ],
)
def test_windows_scale_with_the_distance_from_where_things_vanish(
    perspective: str, place: tuple[int, int], scale: float
) -> None:
    """The row y = 50, or the point (300, 50); the radius holds 400 px away."""
    at = {"vanishing_x_px": 300.0, "vanishing_y_px": 50.0, "reference_x_px": 300.0, "reference_y_px": 450.0}
    if perspective == "row":
        scale = abs(place[1] - 50) / 400
    tracker = RctTracker(RctConfig(radius_px=16.0, perspective=perspective, **at))  # type: ignore[arg-type]
    tracker.feed(events_of([(0, *place)]))
    (cluster,) = tracker.clusters()
    assert cluster["half_width"] == cluster["half_height"] == pytest.approx(16 * scale)


def test_a_window_shrinks_on_the_way_to_the_vanishing_row() -> None:
    events = object_at((300, 450), (0, -300), half=(4, 4))
    config = RctConfig(
        radius_px=16.0, max_clusters=1, alpha=0.1, perspective="row", vanishing_y_px=50.0, reference_y_px=450.0, predict=1.0,
        velocity="regression", path_points=20,
    )  # fmt: skip
    records = tracked(events, config)[0]
    expected = 16 * (records["y"] - 50) / 400
    assert records["radius"][50:] == pytest.approx(expected[50:], rel=0.05)
    assert records["radius"][-1] < 0.3 * records["radius"][50]
