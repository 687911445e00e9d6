# SPDX-License-Identifier: Apache-2.0
"""Boxes of tracks: the upright rectangle around them, and their corners."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.tracks.boxes import box_corners, upright_sides
from evcot.tracks.log import TRACK


def boxes(*rows: tuple[float, float, float, float, float]) -> np.ndarray:  # type: ignore[type-arg]
    """(x, y, width, height, angle) of records."""
    made = np.zeros(len(rows), TRACK)
    for name, column in zip(("x", "y", "width", "height", "angle"), zip(*rows, strict=True), strict=True):
        made[name] = column
    return made


def test_an_upright_box_has_its_own_sides_exactly() -> None:
    width, height = upright_sides(boxes((0, 0, 0.1, 7.3, 0)))
    assert (width.tolist(), height.tolist()) == ([0.1], [7.3])


def test_a_turned_box_needs_room_for_its_corners() -> None:
    made = boxes((5, 6, 6, 8, 0), (5, 6, 6, 8, np.pi / 2), (5, 6, 6, 8, -np.pi / 6), (5, 6, 6, 8, np.pi / 3))
    width, height = upright_sides(made)
    np.testing.assert_allclose(width, [6, 8, 3 * 3**0.5 + 4, 3 + 4 * 3**0.5])
    np.testing.assert_allclose(height, [8, 6, 3 + 4 * 3**0.5, 3 * 3**0.5 + 4])
    corners = box_corners(made)
    np.testing.assert_allclose(np.ptp(corners[..., 0], axis=1), width)
    np.testing.assert_allclose(np.ptp(corners[..., 1], axis=1), height)


def test_corners_go_round_from_the_upper_left_and_angles_turn_from_x_towards_y() -> None:
    upright, turned = box_corners(boxes((10, 20, 4, 2, 0), (10, 20, 4, 2, np.pi / 2)))
    assert upright.tolist() == [[8, 19], [12, 19], [12, 21], [8, 21]]
    assert turned.tolist() == [pytest.approx(corner) for corner in ([11, 18], [11, 22], [9, 22], [9, 18])]
