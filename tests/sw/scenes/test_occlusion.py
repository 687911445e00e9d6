# SPDX-License-Identifier: Apache-2.0
"""The occluded part of an object, compared with areas computed by hand."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.scenes._occlusion_kernel import hidden_parts
from evcot.scenes.shapes import discs, quadrangles


def box(number: int, left: float, top: float, width: float, height: float) -> NDArray[np.float64]:
    x = np.array([[left, left + width, left + width, left]])
    y = np.array([[top, top, top + height, top + height]])
    return quadrangles(number, x, y, 1.0)


def hidden(*shapes: NDArray[np.float64], sensor: tuple[int, int] = (100, 80)) -> list[float]:
    rows = np.concatenate(shapes)
    return [float(part) for part in hidden_parts(rows, np.unique(rows[:, 1]).astype(np.int64), *sensor)]


@pytest.mark.parametrize("x", np.arange(-25.0, 26.0, 2.5))
def test_two_boxes_that_cross(x: float) -> None:
    """The nearer, 12 by 30, passes before the farther, 20 by 20."""
    overlap = max(0.0, min(20.0, x + 12) - max(0.0, x))
    assert hidden(box(0, 30, 30, 20, 20), box(1, 30 + x, 25, 12, 30)) == [pytest.approx(overlap / 20, abs=1e-9), 0.0]


@pytest.mark.parametrize("y", np.arange(-25.0, 26.0, 1.7))
def test_two_boxes_that_cross_down_the_picture(y: float) -> None:
    overlap = max(0.0, min(20.0, y + 12) - max(0.0, y))
    parts = hidden(box(0, 30, 30, 20, 20), box(1, 25, 30 + y, 30, 12))
    assert parts == [pytest.approx(overlap / 20, abs=1 / 64), 0.0]


def test_the_order_says_who_is_nearer() -> None:
    assert hidden(box(1, 35, 30, 20, 20), box(0, 30, 30, 20, 20)) == [0.0, pytest.approx(0.75)]


def test_what_hides_twice_counts_once_and_an_object_does_not_hide_itself() -> None:
    parts = hidden(box(0, 30, 30, 20, 20), box(0, 35, 30, 25, 20), box(1, 30, 30, 10, 20), box(2, 35, 30, 10, 20))
    assert parts == [pytest.approx(0.5), pytest.approx(0.5), 0.0]


def test_what_lies_outside_the_sensor_is_hidden() -> None:
    assert hidden(box(0, -10.5, 30, 20, 20)) == [pytest.approx(0.5)]
    assert hidden(box(0, 94.5, 30, 20, 20)) == [pytest.approx(0.75)]
    assert hidden(box(0, 30, 69.5, 20, 20)) == [pytest.approx(0.5, abs=0.008)]
    assert hidden(box(0, 130, 30, 20, 20)) == [1.0]
    # A nearer one that is outside as well hides nothing more.
    assert hidden(box(0, -10.5, 30, 20, 20), box(1, -20.5, 30, 20, 20)) == [pytest.approx(0.5), 1.0]


def test_discs_hide_by_the_area_of_the_lens() -> None:
    radius = 12.0
    for distance in (0.0, 4.0, 12.0, 20.0, 24.0):
        lens = 2 * radius**2 * np.arccos(distance / (2 * radius)) - distance / 2 * np.sqrt(4 * radius**2 - distance**2)
        parts = hidden(discs([0, 1], [40.0, 40.0 + distance * 0.6], [40.0, 40.0 + distance * 0.8], radius, 1.0))
        assert parts == [pytest.approx(lens / (np.pi * radius**2), abs=0.01), 0.0]


def test_an_object_without_shapes_is_hidden() -> None:
    assert hidden_parts(box(0, 30, 30, 20, 20), np.array([0, 5]), 100, 80).tolist() == [0.0, 1.0]
