# SPDX-License-Identifier: Apache-2.0
"""The axis of time that all pictures share, and what they draw over it alike."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from evcot.pictures.over_time import END_MARKERS, TimeAxis, draw_alive, draw_merges
from evcot.tracks.log import Kind
from evcot.tracks.timeline import OPEN


@pytest.mark.parametrize(("length_us", "unit", "position"), [(1_999_999, "ms", 500.0), (2_000_000, "s", 0.5)])
def test_two_seconds_and_more_are_in_seconds(length_us: int, unit: str, position: float) -> None:
    axis = TimeAxis(1_000, length_us)
    assert axis.unit == unit
    assert axis(np.array([1_000, 501_000])).tolist() == [0.0, position]


def test_every_end_of_a_life_has_a_marker_of_its_own() -> None:
    assert set(END_MARKERS) == {Kind.LOST, Kind.MERGED, OPEN}
    assert len(set(END_MARKERS.values())) == 3


def test_the_tallest_line_fits() -> None:
    ax = Figure().add_subplot()
    draw_alive(ax, np.arange(3.0), [(np.array([0, 2, 1]), {"color": "k"}), (np.array([5, 0, 0]), {"color": "r"})], "alive")
    assert ax.get_ylim() == (0, pytest.approx(5.6))
    assert ax.get_ylabel() == "alive"
    assert [line.get_ydata().tolist() for line in ax.get_lines()] == [[0, 2, 1], [5, 0, 0]]  # type: ignore[union-attr]


def test_a_merge_is_a_line_to_its_survivor() -> None:
    ax = Figure().add_subplot()
    draw_merges(ax, [((3.0, 0.0), (3.0, 4.0))], 0.5)
    (lines,) = ax.collections
    assert [path.vertices.tolist() for path in lines.get_paths()] == [[[3.0, 0.0], [3.0, 4.0]]]
