# SPDX-License-Identifier: Apache-2.0
"""Points of events and of pixels, and clusters of modes."""

from __future__ import annotations

import numpy as np

from evcot.events import Events
from evcot.trackers.frame_based.kernel import FRAME
from evcot.trackers.mean_shift.clusters import Coordinates, event_points, fuse, group, pixel_points
from evcot.trackers.mean_shift.kernel import Iteration

SCALE = Coordinates(polarity_px=4.0, time_px=8.0, tau_us=1_000.0, fuse_px=5.0, points_min=3)
RULES = Iteration(bandwidth_px=4.0, cutoff=3.0, tolerance_px=0.01, max_iterations=100, fold_px=0.0)


def columns(*events: tuple[int, int, int, int]) -> tuple[np.ndarray, ...]:  # type: ignore[type-arg]
    """t, x, y, p of events, read-only, as the tracker has them."""
    t_us, x, y, p = zip(*events, strict=True)
    seen = Events(np.array(t_us, np.int64), np.array(x, np.uint16), np.array(y, np.uint16), np.array(p, np.uint8)).read_only()
    return seen.t_us, seen.x, seen.y, seen.p


def test_an_event_is_its_place_its_polarity_and_its_fading() -> None:
    points, after_us = event_points(*columns((5_000, 7, 9, 1), (6_000, 7, 9, 0), (7_000, 1, 2, 1)), SCALE)
    np.testing.assert_allclose(points, [[7, 7, 1], [9, 9, 2], [4, 0, 4], [8 * np.exp(-2), 8 * np.exp(-1), 8]], rtol=1e-15)
    assert after_us.tolist() == [0, 1_000, 2_000]


def test_a_pixel_of_a_frame_is_its_place_and_its_mean_polarity() -> None:
    events = columns((5_000, 7, 9, 1), (6_000, 300, 9, 0), (7_000, 7, 9, 0), (9_000, 7, 9, 1))
    points, after_us = pixel_points(*events, SCALE)
    np.testing.assert_allclose(points, [[7, 300], [9, 9], [8 / 3, 0], [0, 0]], rtol=1e-15)
    assert after_us.tolist() == [1_750, 1_750]


def test_the_mode_of_the_most_points_takes_in_those_near_it_in_place() -> None:
    """In a chain of modes 4 apart the middle one takes both neighbours, and not theirs."""
    modes = np.array([[0.0, 4, 8, 12, 16], [0, 0, 0, 0, 0], [9, 0, 9, 0, 9], [0, 9, 0, 9, 0]])
    cluster, n = fuse(np.array([0, 1, 2, 2, 2, 3, 4, 4]), modes, 5.0)
    assert n == 3
    assert cluster.tolist() == [2, 0, 0, 0, 0, 0, 1, 1]


def test_frames_are_clustered_each_on_its_own() -> None:
    square = [(10, 10), (12, 10), (10, 12), (12, 12)]
    first = [(t, x, y, 1) for t, (x, y) in enumerate(square)]
    second = [(100 + t, x + 50, y, t % 2) for t, (x, y) in enumerate(square)]
    noise = [(104, 90, 90, 0), (105, 92, 90, 0)]  # too few
    frames = np.zeros(2, FRAME)
    frames["begin"], frames["end"] = (0, 4), (4, 10)
    found, cost = group(RULES, SCALE, False, *columns(*first, *second, *noise), frames)
    assert found[["x", "y", "after_us", "n"]].tolist() == [(11.0, 11.0, 1.5, 4), (61.0, 11.0, 1.5, 4)]
    np.testing.assert_allclose(found["radius"], 1.5)
    np.testing.assert_allclose([found["width"], found["height"]], 3.0)
    assert frames[["found", "found_end"]].tolist() == [(0, 1), (1, 2)]
    assert cost.points == 10


def test_a_cluster_has_the_sides_of_its_points() -> None:
    """A twentieth of the points lies beyond each side."""
    points = [(x, 20) for x in range(10, 30)]
    frames = np.zeros(1, FRAME)
    frames["end"] = 20
    events = columns(*((t, x, y, 1) for t, (x, y) in enumerate(points)))
    found, _ = group(RULES._replace(bandwidth_px=20.0), SCALE, False, *events, frames)
    assert found["width"].tolist() == [18.0]
    assert found["height"].tolist() == [1.0]
