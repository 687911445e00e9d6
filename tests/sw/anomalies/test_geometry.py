# SPDX-License-Identifier: Apache-2.0
"""Points in polygons and crossings of lines, exactly."""

from __future__ import annotations

import numpy as np

from evcot.anomalies.geometry import crossings, inside

SQUARE = [[2, 2], [6, 2], [6, 6], [2, 6]]
DART = [[0, 0], [8, 0], [4, 2], [8, 8]]  # not convex


def test_a_polygon_holds_its_inside_and_its_border_and_nothing_else() -> None:
    y, x = (axis.ravel() for axis in np.mgrid[0:9, 0:9])
    held = inside(SQUARE, x, y)
    np.testing.assert_array_equal(held, (x >= 2) & (x <= 6) & (y >= 2) & (y <= 6))
    np.testing.assert_array_equal(inside(SQUARE[::-1], x, y), held)  # either way round


def test_a_polygon_that_is_not_convex() -> None:
    assert inside(DART, [4, 4, 5, 7, 6, 4, 8], [1, 2, 2, 1, 1, 3, 8]).tolist() == [True, True, False, False, True, True, True]


def test_a_ray_through_a_corner_counts_once() -> None:
    """Points level with the left and right corners of a diamond."""
    diamond = [[4, 0], [8, 4], [4, 8], [0, 4]]
    assert inside(diamond, [-1, 0, 1, 4, 8, 9], [4] * 6).tolist() == [False, True, True, True, True, False]


def test_half_pixels_next_to_a_slanted_border_are_told_apart() -> None:
    wedge = [[0, 0], [8, 4], [0, 8]]
    assert inside(wedge, [4, 4.5, 4], [2, 2, 1.5]).tolist() == [True, False, False]


def test_polygons_against_a_count_of_windings() -> None:
    """Random triangles and points on a grid: inside where the point is on the same side of all edges, or on one."""
    random = np.random.default_rng(2)
    y, x = (axis.ravel() for axis in np.mgrid[0:12, 0:12])
    compared = 0
    for _ in range(200):
        corners = random.integers(0, 12, (3, 2)).astype(float)
        (ax, ay), (bx, by), (cx, cy) = corners
        sides = np.array(
            [(qx - px) * (y - py) - (qy - py) * (x - px) for px, py, qx, qy in
             ((ax, ay, bx, by), (bx, by, cx, cy), (cx, cy, ax, ay))]
        )  # fmt: skip
        if (bx - ax) * (cy - ay) == (by - ay) * (cx - ax):
            continue
        np.testing.assert_array_equal(inside(corners, x, y), (sides >= 0).all(axis=0) | (sides <= 0).all(axis=0))
        compared += 1
    assert compared > 150


def test_crossings_have_a_direction_and_the_line_itself_is_on_its_left() -> None:
    """A line that points to the right of the picture has the lower part of the picture on its right side."""
    line = [0, 5, 10, 5]
    assert crossings(line, [3, 3], [4, 6]).tolist() == [1]
    assert crossings(line, [3, 3], [6, 4]).tolist() == [-1]
    assert crossings(line, [3, 3, 3], [4, 5, 6]).tolist() == [0, 1]
    assert crossings(line, [3, 3, 3], [6, 5, 4]).tolist() == [-1, 0]
    assert crossings(line, [3, 3, 3], [4, 5, 4]).tolist() == [0, 0]
    assert crossings(line, [12, 12], [4, 6]).tolist() == [0]
    assert crossings(line, [1, 8], [4, 4]).tolist() == [0]


def test_a_step_through_the_joint_of_two_lines_crosses_one_of_them() -> None:
    for joint in ([[0, 5, 4, 5], [4, 5, 9, 5]], [[0, 3, 4, 5], [4, 5, 9, 3]]):
        for x, y in (([4, 4], [0, 9]), ([2, 6], [0, 10]), ([6, 2], [0, 10])):
            assert sum(crossings(line, x, y)[0] for line in joint) == 1
            assert sum(crossings(line, x[::-1], y[::-1])[0] for line in joint) == -1


def test_nothing_is_in_nothing() -> None:
    assert inside(SQUARE, [], []).shape == (0,)
    assert crossings([0, 0, 1, 1], [], []).shape == (0,)
