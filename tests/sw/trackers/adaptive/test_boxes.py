# SPDX-License-Identifier: Apache-2.0
"""Boxes of the adaptive tracker: their Kalman filter against its matrices, and which two boxes are one object."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.trackers.adaptive import boxes
from support.interpreted import interpret, scene


@pytest.fixture(autouse=True)
def _interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    interpret(monkeypatch)


def box(x: float, half_x: float, y: float = 0.0, half_y: float = 10.0, axis: int = 0) -> NDArray[np.float64]:
    """A box by its place along an axis and across."""
    return np.array([(x, half_x), (y, half_y)][:: 1 - 2 * axis])


def covariance(rng: np.random.Generator) -> NDArray[np.float64]:
    root = rng.normal(0, 1, (4, 4))
    return root @ root.T


@pytest.mark.parametrize("dt", [0.25, 2.0])
def test_prediction_is_that_of_a_kalman_filter(dt: float) -> None:
    rng = np.random.default_rng(1)
    s, p = rng.normal(0, 1, 4), covariance(rng)
    f = np.array([[1, dt, 0, 0], [0, 1, 0, 0], [0, 0, 1, dt], [0, 0, 0, 1]])
    q = np.zeros((4, 4))
    for at, walk in ((0, 2.0), (2, 3.0)):  # a random walk of the derivative: its integral over dt
        q[at : at + 2, at : at + 2] = walk**2 * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])
    expected = f @ s, f @ p @ f.T + q
    boxes.predict(s, p, dt, 2.0, 3.0)
    np.testing.assert_allclose(s, expected[0])
    np.testing.assert_allclose(p, expected[1])


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_correction_by_a_side_is_that_of_a_kalman_filter(sign: float) -> None:
    rng = np.random.default_rng(2)
    s, p = rng.normal(0, 1, 4), covariance(rng)
    h = np.array([1, 0, sign, 0])
    gain = p @ h / (h @ p @ h + 0.5)
    expected = s + gain * 3.0, p - np.outer(gain, h @ p)
    boxes.correct(s, p, sign, 3.0, 0.5)
    np.testing.assert_allclose(s, expected[0])
    np.testing.assert_allclose(p, expected[1])


def test_overlap_and_length_of_two_boxes() -> None:
    a, b = np.array([[10.0, 4.0], [0.0, 2.0]]), np.array([[20.0, 3.0], [1.0, 5.0]])  # 6 to 14, -2 to 2; 17 to 23, -4 to 6
    for one, other in ((a, b), (b, a)):
        assert [boxes.overlap(one, other, axis) for axis in (0, 1)] == [-3.0, 4.0]
        assert [boxes.together(one, other, axis) for axis in (0, 1)] == [17.0, 10.0]


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize(("half", "apart", "within"), [(10, 6, True), (10, 6.1, False), (5, 8, True), (5, 8.1, False)])
def test_most_of_a_box_lies_in_another_if_they_share_70_percent_of_the_smaller(
    half: float, apart: float, within: bool, axis: int
) -> None:
    for at in (apart, -apart):
        assert boxes.mostly_within(box(0, 10, axis=axis), box(at, half, half_y=half, axis=axis)) == within
        assert boxes.mostly_within(box(at, half, half_y=half, axis=axis), box(0, 10, axis=axis)) == within


# Gap 0.9, elongation 2.2. A box at 0 with half sides of 10, and another at x: (its half sides along and across, x, y).
PARTS = [
    pytest.param((10, 10), (10, 10), 21.8, 0, True, id="gap 1.8 of 0.9 (2.2 20 - 41.8)"),
    pytest.param((10, 10), (10, 10), 22.0, 0, False, id="gap 2 of 1.8"),
    pytest.param((10, 10), (3, 10), 25.4, 0, True, id="beside an edge 2.5 times: gap 12.4 of 12.6"),
    pytest.param((10, 10), (3, 10), 25.6, 0, False, id="gap 12.6 of 12.15"),
    pytest.param((10, 10), (4, 10), 23.0, 0, False, id="40 percent is no edge"),
    pytest.param((9, 10), (9, 10), 18.0, 8, True, id="60 percent abreast"),
    pytest.param((9, 10), (9, 10), 18.0, 8.1, False, id="less than 60 percent abreast"),
    pytest.param((9, 10), (9, 15), 18.0, 7.0, True, id="60 percent of the wider abreast"),
    pytest.param((9, 10), (9, 15), 18.0, 7.1, False, id="less than 60 percent of the wider abreast"),
    pytest.param((5, 10), (5, 10), 34.0, 0, True, id="flat bands as far as 2.2 times the width"),
    pytest.param((5, 10), (5, 10), 34.1, 0, False, id="flat bands farther apart"),
    pytest.param((7.9, 10), (7.9, 10), 28.0, 0, True, id="just flat"),
    pytest.param((8, 10), (8, 10), 28.0, 0, False, id="not flat"),
    pytest.param((7.9, 10), (8, 10), 28.0, 0, False, id="one of them not flat"),
    pytest.param((5, 9), (5, 9), 30.0, 2.0, True, id="flat bands that share 80 percent of the width"),
    pytest.param((5, 10), (5, 10), 30.0, 2.3, False, id="flat bands that share less"),
]


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize(("one", "other", "x", "y", "parts"), PARTS)
def test_boxes_behind_one_another_are_parts(
    one: tuple[float, float], other: tuple[float, float], x: float, y: float, parts: bool, axis: int
) -> None:
    for sign in (1, -1):
        a, b = box(0, one[0], 0, one[1], axis), box(sign * x, other[0], sign * y, other[1], axis)
        assert boxes.are_parts(a, b, 0.9, 2.2) == boxes.are_parts(b, a, 0.9, 2.2) == parts


def test_a_box_inside_another_is_a_part() -> None:
    assert boxes.are_parts(box(0, 10), box(2, 3, 2, 3), 0.0, 1.0)


ENTERING = {"edge": 0, "travel": 0.9, "vx": 50, "vy": 50}


def one(first: dict[str, Any], second: dict[str, Any], unsure: float = 0.0) -> bool:
    """Whether two objects are one, whichever comes first."""
    said = []
    for pair in ((first, second), (second, first)):
        rules, world = scene(*pair, merge_velocity=0.5)
        world.cov[:, :, 1, 1] = unsure
        said.append(boxes.are_one(rules, world, 0, 1))
    assert said[0] == said[1]
    return said[0]


@pytest.mark.parametrize("at", ["x", "y"])
@pytest.mark.parametrize(
    ("gap_px", "given", "expected"),
    [(10, {}, True), (10.1, {}, False), (10, {"travel": 1.0}, False), (10, {"edge": 1}, False), (10, {"edge": -1}, False)],
)
def test_what_enters_side_by_side_over_one_edge_is_one_up_to_a_gap_of_the_longest_half_side(
    gap_px: float, given: dict[str, Any], expected: bool, at: str
) -> None:
    other = ENTERING | {"vx": -50, "vy": -50, "hx": 5, "hy": 5}
    other |= {at: {"x": 100, "y": 60}[at] + 15 + gap_px} | given
    assert one(ENTERING, other) == expected


def test_objects_on_the_sensor_are_not_one_because_they_are_new_and_close() -> None:
    assert not one(ENTERING | {"edge": -1}, ENTERING | {"edge": -1, "x": 122, "vx": -50, "vy": -50})


@pytest.mark.parametrize(("within", "expected"), [(2.0, False), (2.1, True)])
def test_one_that_has_travelled_in_the_other_for_two_half_sides_is_one_with_it(within: float, expected: bool) -> None:
    assert one({"vx": 50, "within": 2.1}, {"vx": -50, "x": 106, "within": within}) == expected
    rules, world = scene({"vx": 50}, {"vx": -50, "x": 106}, {"vx": 50, "y": 80})
    boxes.are_one(rules, world, 0, 1)
    assert world.objects["inside"].tolist() == [1, 0, -1]


@pytest.mark.parametrize("v", [("vx", "vy"), ("vy", "vx")])
@pytest.mark.parametrize(
    ("slower", "unsure", "far", "expected"),
    [
        (20, 0.0, 3.0, True),  # a difference of 20, half of 40
        (19, 0.0, 3.0, False),
        (19, 1.0, 3.0, False),  # known: what is uncertain (4 variances: 2 px/s) counts against it
        (20, 1.0, 3.0, False),
        (21, 1.0, 3.0, True),  # 19 of 0.5 (40 - 2)
        (19, 1.0, 2.9, True),  # not known: 21 of 0.5 (40 + 2)
        (18, 1.0, 2.9, False),
    ],
)
def test_parts_are_one_if_they_move_alike(slower: float, unsure: float, far: float, expected: bool, v: tuple[str, str]) -> None:
    first, second = {v[0]: 40, "travel": 3.0}, {v[0]: slower, "travel": far, "x": 106}
    assert one(first, second, unsure) == expected
    assert not one({v[0]: 40, "travel": 3.0}, {v[1]: 40, "travel": far, "x": 106}), "at right angles"
    if far == 3.0 and unsure and slower == 20:
        assert not one(first, second | {"track_id": 0}, unsure)
        assert one(first, second | {"track_id": -1}, unsure), "of what is not visible it need only be possible"


@pytest.mark.parametrize(
    ("half", "apart", "expected"),
    [
        (5.9, 1.9, True),  # less than 60 % of the larger's sides, closer than a tenth of these: 2 px
        (5.5, 2.0, False),
        (6.0, 1.9, False),
    ],
)
def test_a_small_object_close_to_another_may_be_a_part_wherever_it_lies(half: float, apart: float, expected: bool) -> None:
    for x in (1, -1):
        for y in (1, -1):  # at the corners: beside each other along neither axis
            at = {"x": 100 + x * (10 + half + apart), "y": 60 + y * (10 + half + apart), "hx": half, "hy": half}
            assert one({"vx": 40}, {"vx": 40} | at) == expected


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({}, False),  # a gap of 5, the gates are 4
        ({"gate": 5.0}, True),
        ({"track_id": -1}, True),
        ({"track_id": 0}, False),
        ({"hx": 3.9, "x": 116.9}, True),  # an edge, thinner than 40 %
        ({"hx": 4.0, "x": 117}, False),
    ],
)
def test_visible_bodies_beyond_their_gates_are_no_parts(given: dict[str, Any], expected: bool) -> None:
    body = {"vx": 40, "hx": 8, "gate": 4.0}
    assert one(body, body | {"x": 121} | given) == expected


@pytest.mark.parametrize(("half_x", "half_y", "body"), [(10, 4, True), (4, 10, True), (10, 3.9, False), (3.9, 10, False)])
def test_a_body_is_at_least_40_percent_as_thick_as_long(half_x: float, half_y: float, body: bool) -> None:
    _, world = scene({"hx": half_x, "hy": half_y})
    assert boxes._is_body(world.state[0]) == body
