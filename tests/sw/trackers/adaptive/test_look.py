# SPDX-License-Identifier: Apache-2.0
"""A measurement of an object by the adaptive tracker, step by step: its window, its bins, its parts, its sides."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.trackers.adaptive import bins, boxes, look
from evcot.trackers.adaptive.layout import Rules, World
from support.interpreted import interpret, scene

T_US = 1_000_000


@pytest.fixture(autouse=True)
def _interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    interpret(monkeypatch)


@pytest.mark.parametrize(
    ("given", "pace"),
    [
        ({"vx": 6, "vy": 8, "speed": 33}, 10),
        ({"vx": 6, "vy": 8, "speed": 40}, 12),  # 0.3 of its greatest speed
        ({"speed": 5}, 5),  # half a half side per second
        ({"speed": 5, "hx": 14}, 7),
        ({"speed": 5, "hy": 14}, 7),
    ],
)
def test_the_pace_of_an_object(given: dict[str, Any], pace: float) -> None:
    assert look._pace(scene(given)[1], 0) == pytest.approx(pace)


@pytest.mark.parametrize(
    ("given", "run", "window_s"),
    [
        ({"vx": 20, "usual": 50}, {}, 0.16),  # 4 pixels for each of 40 px, of 50 pixels for each of 20 px per second
        ({"vx": 20, "usual": 50, "hx": 20}, {}, 0.24),
        ({"vx": 20, "usual": 50, "hy": 20}, {}, 0.24),
        ({"vx": 20, "usual": 1}, {}, 0.2),  # 0.4 half sides
        ({"vx": 20, "usual": 1, "unsure": 100}, {}, 1.5 / 20),  # misplaced by 0.15 half sides
        ({"vx": 2, "speed": 2, "usual": 1}, {}, 0.4),
        ({"vx": 20, "usual": 1}, {"noise": 4.0}, 0.05),  # 0.2 events of noise per pixel
        ({"vx": 9_000, "usual": 50}, {}, 2e-3),
    ],
)
def test_how_far_back_a_measurement_reads(given: dict[str, Any], run: dict[str, Any], window_s: float) -> None:
    variances = given.get("unsure", 0)
    rules, world = scene({name: value for name, value in given.items() if name != "unsure"}, memory=0.4, fill=4.0, blur=0.15)
    world.cov[0, :, 1, 1] = variances, 3 * variances
    world.run[0].noise = run.get("noise", -1.0)
    assert look._window_s(rules, world, 0) == pytest.approx(window_s)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize(
    ("half", "off", "of_another"),
    [
        (10, 20, True),
        (10, 18.1, True),  # 11.9 from the other: its half side and gate are 12
        (10, 18, False),
        (30, 10, True),  # 1.0 and 0.67 half sides
        (30, 7.5, False),  # 0.75 of both
        (30, 7, False),
    ],
)
def test_a_place_is_of_the_object_closer_in_half_sides(half: float, off: float, of_another: bool, axis: int) -> None:
    sides = ("x", "hx", "hy") if axis == 0 else ("y", "hy", "hx")
    start, at = {"x": 100, "y": 60}, np.array([100.0, 60.0])
    for sign in (1, -1):
        other = {sides[0]: start[sides[0]] + sign * 30, sides[1]: half, sides[2]: 20}
        _, world = scene({"x": 20, "y": 20}, {}, other)
        world.meeting[:2] = 0, 2
        at[axis] = start[sides[0]] + sign * off
        assert look._of_another(world, 1, 2, *at) == of_another
        assert not look._of_another(world, 1, 1, *at)
        far = at.copy()
        far[1 - axis] += 22  # beyond the other's half side and gate across
        assert not look._of_another(world, 1, 2, *far)


def test_pixels_of_a_row_that_sent_an_event_lately() -> None:
    _, world = scene()
    world.seen[7, [20, 22, 25, 30, 83]] = 500, 499, 501, 600, 700
    assert look._lately(world, 7, 20, 30, 500) == 0b100001
    assert look._lately(world, 7, 20, 84, 500) == (1 << 63) | (1 << 10) | 0b100001
    assert look._lately(world, 6, 20, 84, 500) == 0


def collected(given: dict[str, Any], x: int, y: int, ago_us: int, reach: float = 14.0, bin_px: int = 1) -> set[Any]:
    """The bin of one pixel, (column, row), in a measurement over 0.2 s."""
    rules, world = scene(given)
    world.seen[y, x] = T_US - ago_us
    look._collect(rules, world, 0, T_US, 0.2, bin_px, np.array([reach, reach]), 0)
    return {(int(column), int(row)) for row, column in np.argwhere(world.bins)}


@pytest.mark.parametrize(
    ("given", "pixel", "bin_"),
    [
        ({}, (95, 62, 100_000), (9, 16)),
        ({}, (95, 62, 200_000), (9, 16)),
        ({}, (95, 62, 200_001), None),
        ({"vx": 20}, (95, 62, 100_000), (11, 16)),  # 2 px farther by now
        ({"vx": -20}, (95, 62, 100_000), (7, 16)),
        ({"vy": 20}, (95, 62, 100_000), (9, 18)),
        ({"gx": 10}, (110, 62, 100_000), (25, 16)),  # grown by a tenth
        ({"gy": 10}, (95, 70, 100_000), (9, 25)),
        ({"gx": 300}, (105, 62, 100_000), (24, 16)),  # by two at most
        ({"gy": 300}, (95, 65, 100_000), (9, 24)),
        ({"gx": -100}, (110, 62, 100_000), (19, 16)),  # by a half at least
        ({"gy": -100}, (95, 70, 100_000), (9, 19)),
        ({}, (113, 60, 0), (27, 14)),
        ({}, (114, 60, 0), None),
        ({}, (87, 60, 0), (1, 14)),
        ({}, (86, 60, 0), None),
        ({}, (100, 73, 0), (14, 27)),
        ({}, (100, 74, 0), None),
        ({}, (100, 46, 0), None),
        ({"vx": 20}, (83, 60, 200_000), (1, 14)),  # beyond its reach then
        ({"vx": -20}, (117, 60, 200_000), (27, 14)),
        ({"vy": 20}, (100, 43, 200_000), (14, 1)),
        ({"vy": -20}, (100, 77, 200_000), (14, 27)),
        ({"gx": -50}, (118, 60, 200_000), (23, 14)),
        ({"gx": -50}, (82, 60, 200_000), (5, 14)),
        ({"gy": -50}, (100, 78, 200_000), (14, 23)),
        ({"gy": -50}, (100, 42, 200_000), (14, 5)),
        ({"x": 3, "y": 2}, (0, 0, 0), (11, 12)),  # in the corners of the sensor
        ({"x": 190, "y": 115}, (199, 119, 0), (23, 18)),
    ],
)
def test_a_pixel_counts_where_it_is_now(
    given: dict[str, Any], pixel: tuple[int, int, int], bin_: tuple[int, int] | None
) -> None:
    assert collected(given, *pixel) == ({bin_} if bin_ else set())


def test_bins_have_several_pixels_and_rows_more_than_a_word() -> None:
    large = {"hx": 50, "hy": 40}
    assert [collected(large, x, 61, 0, 60.0, 3) for x in (41, 103, 104, 105, 159)] == [{(i, 20)} for i in (0, 21, 21, 21, 39)]


def test_pixels_of_an_object_that_it_meets_do_not_count() -> None:
    rules, world = scene({}, {"x": 115})
    world.meeting[0] = 1
    world.seen[60, [105, 110]] = T_US
    look._collect(rules, world, 0, T_US, 0.2, 1, np.array([14.0, 14.0]), 1)
    assert np.argwhere(world.bins).tolist() == [[14, 19]]


@pytest.mark.parametrize(("given", "late_us"), [({"vx": 20, "hy": 5}, 100_000), ({"hx": 5, "hy": 10, "speed": 5}, 200_000)])
def test_the_share_of_pixels_in_the_later_part_of_the_window(given: dict[str, Any], late_us: int) -> None:
    """Half of it, or the time of 0.1 half sides: at a pace of 5 px/s that is all."""
    for ago_us, late in ((late_us, 1.0), (late_us + 1, 0.5)):
        rules, world = scene(given | {"vx": 0.0, "speed": 60} if given["hy"] == 5 else given)
        world.seen[60, 100] = T_US
        world.seen[61, 99] = T_US - ago_us
        world.seen[60, 112] = world.seen[72, 100] = T_US  # beside its box
        share = look._collect(rules, world, 0, T_US, 0.2 if late_us == 100_000 else 0.2001, 1, np.array([14.0, 14.0]), 0)
        assert share == pytest.approx(late)


Pixels = list[tuple[int, int]]


def block(left: int, right: int, top: int, bottom: int) -> Pixels:
    return [(x, y) for x in range(left, right + 1) for y in range(top, bottom + 1)]


def parts_of_group(pixels: Pixels, box: tuple[float, ...], noise: float = 0.0, near: tuple[int, int] | None = None) -> Any:
    """Bounds (left, right, top, bottom) and pixels of the parts of a group, whose pixels sent an event 10 ms ago."""
    rules, world = scene({})
    world.run[0].noise = noise
    for x, y in pixels:
        world.seen[y, x] = T_US - 10_000
    if near:
        world.near[near[1], near[0], 0] = 0
    n = look.look_at_group(rules, world, np.array(box), T_US, 0.01)
    return [(*world.parts[k, 0], *world.parts[k, 1], world.parts[k, 2, 0]) for k in range(n)]


@pytest.mark.parametrize(
    ("pixels", "box", "parts"),
    [
        (block(30, 38, 20, 28), (30, 38, 20, 28), [(30, 38, 20, 28, 81)]),
        (block(30, 32, 20, 22) + block(35, 38, 20, 22), (30, 38, 20, 22), [(30, 38, 20, 22, 21)]),  # up to 3 px apart
        (block(30, 32, 20, 22) + block(36, 38, 20, 22), (30, 38, 20, 22), [(30, 32, 20, 22, 9), (36, 38, 20, 22, 9)]),
        (block(30, 32, 20, 22) + block(30, 32, 26, 28), (30, 32, 20, 28), [(30, 32, 20, 22, 9), (30, 32, 26, 28, 9)]),
        (block(30, 38, 20, 28), (32, 36, 22, 25), [(32, 36, 22, 25, 20)]),
        (block(0, 3, 0, 2), (-5, 3, -5, 2), [(0, 3, 0, 2, 12)]),
        (block(197, 199, 116, 119), (197, 206, 116, 127), [(197, 199, 116, 119, 12)]),
        ([(30, 20)], (30, 38, 20, 28), []),
        (block(33, 35, 20, 22), (30, 76, 20, 22), [(33, 35, 20, 22, 9)]),
        (block(33, 35, 20, 22), (30, 77, 20, 22), [(32, 35, 20, 23, 9)]),  # from 48 px on in bins of 2 px
        (block(33, 35, 23, 25), (30, 32, 20, 67), []),
        (block(30, 32, 23, 25), (30, 32, 20, 67), [(30, 33, 22, 25, 9)]),
        (block(33, 35, 20, 22) + block(39, 41, 20, 22), (30, 125, 20, 22), [(33, 41, 20, 22, 18)]),  # of 3 px
    ],
)
def test_a_group_of_cells_falls_into_parts(pixels: Pixels, box: tuple[float, ...], parts: list[tuple[float, ...]]) -> None:
    assert parts_of_group(pixels, box) == parts


def test_old_pixels_and_those_near_objects_are_of_no_part() -> None:
    pixels = block(32, 39, 24, 31) + block(48, 50, 24, 26)
    assert len(parts_of_group(pixels, (32, 50, 24, 31))) == 2
    assert parts_of_group(pixels, (32, 50, 24, 31), near=(4, 3)) == [(48, 50, 24, 26, 9)]
    rules, world = scene({})
    world.seen[24:27, 48:51] = T_US - 10_001
    assert look.look_at_group(rules, world, np.array([48.0, 50, 24, 26]), T_US, 0.01) == 0


def test_noise_is_of_no_part() -> None:
    rate = -100 * np.log(0.9)  # a tenth of the pixels: 0.9 of nine, and three standard deviations are 3.75
    assert len(parts_of_group(block(30, 32, 20, 20), (30, 40, 20, 22), rate)) == 0
    assert len(parts_of_group(block(30, 31, 20, 21), (30, 40, 20, 22), rate)) == 1
    wide = (30, 79, 20, 22)  # bins of four pixels: 3.6 of 36, and 5.7
    assert len(parts_of_group(block(30, 32, 20, 22), wide, rate)) == 0
    assert len(parts_of_group(block(30, 34, 20, 21), wide, rate)) == 1


def filled(bins_: dict[tuple[int, int], float], *, given: dict[str, Any], **config: float) -> tuple[Rules, World]:
    """A world with pixels in bins (column, row)."""
    rules, world = scene(given, **config)
    for (x, y), pixels in bins_.items():
        bins.fill(world, y, x)
        world.bins[y, x] = pixels
    bins.smooth(world, 40, 40)
    return rules, world


@pytest.mark.parametrize(
    ("bins_", "noise", "level"),
    [
        ({}, 0.0, 2.0),
        ({}, 1.0, 18.0),  # 9 and three standard deviations
        ({(14, 14): 30}, 0.0, 12.0),  # 0.4 of the density where pixels lie
        ({(10, 10): 10, (20, 20): 40}, 0.0, 13.6),  # 0.4 of (10 10 + 40 40) / 50
        ({(10, 10): 10, (10, 11): 40}, 0.0, 20.0),  # both lie among 50
        ({(4, 14): 30}, 0.0, 12.0),
        ({(3, 14): 30}, 0.0, 2.0),  # outside the box
        ({(23, 14): 30}, 0.0, 12.0),
        ({(24, 14): 30}, 0.0, 2.0),
        ({(14, 4): 30}, 0.0, 12.0),
        ({(14, 3): 30}, 0.0, 2.0),
        ({(14, 23): 30}, 0.0, 12.0),
        ({(14, 24): 30}, 0.0, 2.0),
        ({(14, 14): 30}, 1.0, 18.0),
    ],
)
def test_the_level_from_which_bins_are_an_objects(bins_: dict[tuple[int, int], float], noise: float, level: float) -> None:
    rules, world = filled(bins_, given={"hx": 9.5, "hy": 9.5}, dense=0.4)
    assert look._level(rules, world, 0, noise, 1, np.array([14.0, 14.0]), 40) == pytest.approx(level)
    world.state[0, :, 2] *= 2
    assert look._level(rules, world, 0, noise, 2, np.array([28.0, 28.0]), 40) == pytest.approx(level)


def test_the_gap_between_two_boxes() -> None:
    one, other = np.array([[0, 5], [0, 2]]), np.array([[12, 3], [3, 4]])
    assert look._between(one, other) == look._between(other, one) == 4
    assert look._between(one[::-1], other[::-1]) == 4
    assert look._between(one, np.array([[1, 3], [3, 4]])) == -3


Part = tuple[float, float, float]  # from, to along one axis; pixels; from 0 to 10 along the other


def divided(*parts: Part, close: float = 0.0, axis: int = 0, gap: float = 0.9) -> tuple[bool, list[float]]:
    """Whether parts are two objects, and the pixels of each afterwards."""
    rules, world = scene({}, gap=gap, elongation=2.2)
    for k, (begin, end, pixels) in enumerate(parts):
        world.parts[k, axis], world.parts[k, 1 - axis], world.parts[k, 2, 0] = (begin, end), (0, 10), pixels
    return look._divide(rules, world, len(parts), close), world.parts[: len(parts), 2, 0].tolist()


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize(
    ("parts", "close", "kept"),
    [
        ([(0, 10, 100), (40, 50, 99)], 0, [100, 0]),
        ([(0, 10, 99), (40, 50, 100)], 0, [0, 100]),
        ([(0, 10, 81), (40, 50, 19)], 0, None),  # 20 % of all would be another object
        ([(0, 10, 80), (40, 50, 20)], 0, [80, 0]),
        ([(0, 10, 100), (11, 21, 99)], 0, None),  # a gap of 1 of 1.25 0.9 (22 - 21)
        ([(0, 10, 100), (11.1, 21.1, 99)], 0, [100, 0]),
        ([(0, 10, 100), (13, 23, 29)], 3, None),  # less than 30 % and close
        ([(0, 10, 100), (13, 23, 30)], 3, [100, 0]),
        ([(0, 10, 100), (13.1, 23.1, 29)], 3, [100, 0]),
        ([(0, 10, 40), (11, 21, 39), (45, 55, 60)], 0, [40, 39, 0]),
        ([(0, 10, 40), (11, 21, 39), (45, 55, 80)], 0, [0, 0, 80]),
        ([(0, 10, 40), (10.5, 11, 0), (40, 50, 80)], 0, [0, 0, 80]),
        ([(0, 10, 100)], 0, None),
    ],
)
def test_parts_are_two_objects_if_they_cannot_be_one(
    parts: list[Part], close: float, kept: list[float] | None, axis: int
) -> None:
    for order in itertools.permutations(range(len(parts))):
        there = [parts[k] for k in order]
        expected = [kept[k] for k in order] if kept else [part[2] for part in there]
        assert divided(*there, close=close, axis=axis) == (kept is not None, expected)


def test_groups_that_are_joined_span_their_parts() -> None:
    # The third is close to the first two together.
    for axis in (0, 1):
        assert divided((0, 10, 100), (10.5, 12, 20), (13, 14, 30), close=1.2, axis=axis, gap=0.0) == (False, [100, 20, 30])
        assert divided((0, 10, 100), (-2, -0.5, 20), (-4, -3, 30), close=1.2, axis=axis, gap=0.0) == (False, [100, 20, 30])
        assert divided((0, 10, 100), (10.5, 12, 20), (13.3, 14, 30), close=1.2, axis=axis, gap=0.0)[0]


def chosen(*parts: tuple[float, float, float, float], **given: float) -> tuple[float, list[float]]:
    """The pixels of an object of 20 px in the middle of 28 bins, and those of each part; a part is thin across."""
    rules, world = scene(given, gap=0.9, elongation=2.2)
    for k, (begin, end, pixels, inside) in enumerate(parts):
        world.parts[k] = (begin, end), (13, 15), (pixels, inside)
    total = look._choose(rules, world, 0, len(parts), 1, np.array([14.0, 14.0]))
    return total, world.parts[: len(parts), 2, 0].tolist()


BODY = (5, 23, 100, 100)


@pytest.mark.parametrize(
    ("part", "kept"),
    [
        ((23, 27, 10, 5), True),  # half of it lies in the box
        ((26, 30, 10, 4.9), False),
        ((25.5, 27.5, 10, 0), True),  # 0.15 half sides beside the box
        ((25.6, 27.6, 10, 0), False),
        ((0.5, 2.5, 10, 0), True),
        ((0.4, 2.4, 10, 0), False),
        ((12, 13, 4, 4), True),
        ((12, 13, 3.9, 3.9), False),  # too few
    ],
)
def test_parts_in_the_box_or_close_to_it_are_the_objects(part: tuple[float, float, float, float], kept: bool) -> None:
    pixels = part[2] if kept else 0.0
    assert chosen(BODY, part) == (100 + pixels, [100, pixels])


def test_parts_beside_the_box_are_the_objects_if_they_may_be_one_with_it() -> None:
    rules, world = scene({}, gap=0.9, elongation=2.2)
    for begin, kept in ((39.9, True), (40.0, False)):  # a gap of 15.9 of 2.5 0.9 (44 - 36.9): an edge
        world.parts[0], world.parts[1] = ((5, 23), (5, 23), (100, 100)), ((begin, begin + 1), (4, 24), (50, 0))
        look._choose(rules, world, 0, 2, 1, np.array([14.0, 14.0]))
        assert (world.parts[1, 2, 0] > 0) == kept
    world.state[0, :, 2] = 20  # the same in bins of 2 px
    world.parts[1] = (39.9, 40.9), (4, 24), (50, 0)
    look._choose(rules, world, 0, 2, 2, np.array([28.0, 28.0]))
    assert world.parts[1, 2, 0] == 50


def test_parts_with_less_than_3_percent_are_noise() -> None:
    assert chosen((5, 23, 194, 194), (12, 13, 6, 6)) == (200, [194, 6])
    assert chosen((5, 23, 200, 200), (12, 13, 6, 6)) == (200, [200, 0])


def test_a_box_that_holds_less_than_20_percent_has_lost_the_object() -> None:
    assert chosen((24, 27, 100, 20))[0] == 100
    assert chosen((24, 27, 100, 19))[0] == 0


@pytest.mark.parametrize(("sign", "most_px"), [(1.0, 8.0), (-1.0, np.sqrt(32))])
def test_a_side_that_jumps_four_standard_deviations_has_not_moved(sign: float, most_px: float) -> None:
    """The variance of the side is 1 + 1 and twice 0.5 or -0.5; that of the measurement 1."""
    p = np.zeros((4, 4))
    p[0, 0] = p[1, 1] = p[2, 2] = p[3, 3] = 1.0
    p[0, 2] = p[2, 0] = 0.5
    p[0, 1] = p[1, 0] = p[2, 3] = p[3, 2] = p[0, 3] = p[3, 0] = p[1, 2] = p[2, 1] = p[1, 3] = p[3, 1] = 0.25
    for off_px in (0.99 * most_px, -0.99 * most_px):
        s, q, expected = np.array([100.0, 7, 10, 8]), p.copy(), (np.array([100.0, 7, 10, 8]), p.copy())
        look._observe_side(s, q, sign, off_px, 1.0)
        boxes.correct(*expected, sign, off_px, 1.0)
        np.testing.assert_allclose(s, expected[0])
        np.testing.assert_allclose(q, expected[1])
    s = np.array([100.0, 7, 10, 8])
    look._observe_side(s, p, sign, 1.01 * most_px, 1.0)
    np.testing.assert_allclose(s, [100 + 0.505 * most_px, 7, 10 + sign * 0.505 * most_px, 8])
    np.testing.assert_allclose(p, [[1.25, 0, 0, 0], [0, 1, 0, 0.25], [0, 0, 1.25, 0], [0, 0.25, 0, 1]])


def measured(bins_: dict[tuple[int, int], float], left_out: tuple[int, int], quantile: float, bin_px: int) -> tuple[float, Any]:
    """The pixels and the sides of what was chosen: all bins but one, which is of a part that was left out."""
    rules, world = filled(bins_, given={}, quantile=quantile)
    world.taken[:] = world.filled
    world.parts[:2, 2, 0] = 1, 0
    world.label[:] = 1
    world.label[left_out[::-1]] = 2
    reach: NDArray[np.float64] = np.array([14.0, 12.0])
    return look._measure_sides(rules, world, 30, 28, bin_px, reach), world.bounds


@pytest.mark.parametrize(
    ("quantile", "sides"), [(0.05, (4.5, 13.5, 7.05, 7.95)), (0.1, (5, 13, 7.1, 7.9)), (0.25, (6.5, 11.5, 7.25, 7.75))]
)
@pytest.mark.parametrize("bin_px", [1, 2])
def test_a_share_of_the_pixels_lies_beyond_each_side(quantile: float, sides: tuple[float, ...], bin_px: int) -> None:
    row = {(x, 7): 10.0 for x in range(4, 14)}
    mass, bounds = measured(row | {(20, 20): 50.0}, (20, 20), quantile, bin_px)
    assert mass == 100
    left, right, top, bottom = (bin_px * side for side in sides)
    np.testing.assert_allclose(bounds, [[left - 14, right - 14], [top - 12, bottom - 12]])


def test_sides_reach_the_first_and_the_last_bin() -> None:
    corners = {(0, 0): 10.0, (27, 0): 10.0, (0, 29): 10.0, (27, 29): 10.0}
    _, bounds = measured(corners, (5, 5), 0.0, 1)
    np.testing.assert_allclose(bounds, [[-14, 14], [-12, 18]])
    _, bounds = measured({(0, 0): 10.0}, (5, 5), 0.4, 1)
    np.testing.assert_allclose(bounds, [[0.4 - 14, 0.6 - 14], [0.4 - 12, 0.6 - 12]])
    _, bounds = measured({(27, 29): 10.0}, (5, 5), 0.4, 1)
    np.testing.assert_allclose(bounds, [[27.4 - 14, 27.6 - 14], [29.4 - 12, 29.6 - 12]])


def slow_contrast(rules: Rules, world: World, rows: int, columns: int, bin_px: int, reach: NDArray[np.float64]) -> float:
    s, bounds, edge = world.state[0], world.bounds, 0.5 * world.objects["gate"][0]
    inner, outer = [], []
    for y, x in np.ndindex(rows, columns):
        dx, dy = (x + 0.5) * bin_px - reach[0], (y + 0.5) * bin_px - reach[1]
        if not (0 <= s[0, 0] + dx <= rules.width - 1 and 0 <= s[1, 0] + dy <= rules.height - 1):
            continue
        if bounds[0, 0] <= dx <= bounds[0, 1] and bounds[1, 0] <= dy <= bounds[1, 1]:
            inner.append(world.bins[y, x])
        elif not (bounds[0, 0] - edge <= dx <= bounds[0, 1] + edge and bounds[1, 0] - edge <= dy <= bounds[1, 1] + edge):
            outer.append(world.bins[y, x])
    return float((sum(inner) / max(len(inner), 1) + 1e-9) / (sum(outer) / max(len(outer), 1) + 1e-9))


def test_contrast_is_that_of_a_count_bin_by_bin() -> None:
    rng, at_an_edge = np.random.default_rng(62), 0
    for _ in range(300):
        (rows, columns), bin_px = rng.integers(1, 13, 2), int(rng.integers(1, 4))
        there = {(int(x), int(y)): float(rng.integers(1, 5)) for y, x in np.argwhere(rng.random((rows, columns)) < 0.2)}
        rules, world = filled(there, given={"x": rng.uniform(0, 200), "y": rng.uniform(0, 120), "gate": rng.uniform(0, 10)})
        reach: Any = 0.5 * bin_px * np.array([columns, rows])
        world.bounds[:] = np.sort(rng.uniform(-reach[:, None], reach[:, None], (2, 2)), axis=1)
        at_an_edge += bool(np.any(world.state[0, :, 0] < reach) or np.any(world.state[0, :, 0] > [200, 120] - reach))
        look._measure_contrast(rules, world, 0, rows, columns, bin_px, reach)
        assert world.objects["contrast"][0] == slow_contrast(rules, world, rows, columns, bin_px, reach)
    assert at_an_edge > 20


# Sides at 90 and 110, 50 and 70. Another with half sides of 4 and 6 px and a gate of 2 px: 6 and 8 px around its middle.
@pytest.mark.parametrize(
    ("other", "hidden"),
    [
        ({"x": 84, "y": 60}, (0, 0)),
        ({"x": 83.9, "y": 60}, None),
        ({"x": 116, "y": 68}, (0, 1)),
        ({"x": 116, "y": 68.1}, None),
        ({"x": 116, "y": 52}, (0, 1)),
        ({"x": 106, "y": 42}, (1, 0)),
        ({"x": 106.1, "y": 42}, None),
        ({"x": 94, "y": 78}, (1, 1)),
        ({"x": 94, "y": 78.1}, None),
    ],
)
def test_a_side_is_hidden_if_its_middle_lies_in_another_object(other: dict[str, Any], hidden: tuple[int, int] | None) -> None:
    _, world = scene({"x": 20, "y": 20}, {}, {"hx": 4, "hy": 6} | other)
    world.meeting[:2] = 0, 2
    sides = [(0, 0), (0, 1), (1, 0), (1, 1)]
    assert [side for side in sides if look._hidden(world, 1, 2, *side)] == ([hidden] if hidden else [])
    assert not any(look._hidden(world, 1, 1, *side) for side in sides)


def outline(world: World, x: int, y: int, half: int, ago_us: int = 10_000) -> int:
    """Events on the outline of a square; returns its pixels."""
    for at in range(-half, half + 1):
        world.seen[[y - half, y + half], x + at] = T_US - ago_us
        world.seen[y + at, [x - half, x + half]] = T_US - ago_us
    return 8 * half


def measure(off: tuple[int, int] = (0, 0), ago_us: int = 10_000, half: int = 10, **given: float) -> tuple[float, World]:
    """What a measurement shows of an outline beside the place of an object of 20 px at 20 px/s; its state is uncertain."""
    rules, world = scene({"vx": 20, "usual": 4.0, "travel": 1.0} | given)
    x, y = world.state[0, :, 0]
    outline(world, round(x) + off[0], round(y) + off[1], half, ago_us)
    world.state[0, 0, 1] = 0
    world.cov[0] = np.diag([4.0, 0.01, 4.0, 0.01])
    return look.look(rules, world, 0, 0, T_US), world


@pytest.mark.parametrize("off", [(2, 0), (-2, 0), (0, 2), (0, -2)])
def test_a_measurement_moves_the_box_to_the_outline(off: tuple[int, int]) -> None:
    mass, world = measure(off)
    assert (mass, world.objects["mass"][0]) == (80, 80)
    np.testing.assert_allclose(world.state[0, :, 0], [100.4 + off[0], 60.4 + off[1]], atol=0.5)  # middles of bins
    np.testing.assert_allclose(world.state[0, :, 2], [10, 10], atol=0.5)
    assert (world.cov[0, :, 0, 0] < 2).all()


def test_a_measurement_changes_the_size() -> None:
    _, smaller = measure(half=8)
    assert (smaller.state[0, :, 2] < 9.2).all()
    rules, larger = scene({"usual": 4.0, "travel": 1.0})
    larger.cov[0] = np.diag([4.0, 0.01, 4.0, 0.01])
    outline(larger, 100, 60, 12)
    outline(larger, 100, 60, 10)
    assert look.look(rules, larger, 0, 0, T_US) > 0
    assert (larger.state[0, :, 2] > 10.8).all()


def test_the_usual_number_of_pixels_follows_what_is_seen() -> None:
    """In 0.4 s an object at rest travels at least 0.2 of its speed of 20 px/s: 80 pixels in 1.6 px."""
    assert measure()[1].objects["usual"][0] == pytest.approx(4 + 0.2 * (50 - 4))


@pytest.mark.parametrize(
    ("given", "seen"),
    [
        ({}, True),
        ({"ago_us": 500_000}, False),  # long ago
        ({"half": 3}, False),  # 24 pixels of 0.6 for each of its sides and pixel
    ],
)
def test_an_object_is_seen_if_enough_of_its_pixels_sent_events(given: dict[str, Any], seen: bool) -> None:
    mass, world = measure(**given)
    assert (mass > 0) == seen
    assert (world.state[0, 0, 0], world.objects["usual"][0] == 4.0) == (pytest.approx(100, abs=0.5), not seen)


def test_an_object_is_seen_if_it_shows_15_percent_of_what_it_usually_sends() -> None:
    """4 px in 0.2 s at 20 px/s: 80 pixels of 533 are 15 %."""
    for usual, seen in ((132.0, True), (135.0, False)):
        rules, world = scene({"vx": 20, "usual": usual, "travel": 1.0}, fill=1000.0, full=0.0)
        world.cov[0] = np.diag([4.0, 0.01, 4.0, 0.01])
        outline(world, 100, 60, 10, 0)
        assert (look.look(rules, world, 0, 0, T_US) > 0) == seen


def test_two_outlines_in_five_measurements_are_two_objects() -> None:
    for apart, moves in ((3, False), (4, True)):
        rules, world = scene({"usual": 4.0, "travel": 1.0, "apart": apart, "hx": 16, "hy": 8, "vx": 1.0})
        world.cov[0] = np.diag([4.0, 0.01, 4.0, 0.01])
        outline(world, 88, 60, 4)
        outline(world, 112, 60, 3)
        assert look.look(rules, world, 0, 0, T_US) > 0
        assert world.objects["apart"][0] == apart + 1
        assert (world.state[0, 0, 0] < 99) == moves, "the box goes with the heavier one"
    measured_once = measure(apart=4)[1]
    assert measured_once.objects["apart"][0] == 0


@pytest.mark.parametrize(("axis", "edge"), [(0, 0), (0, 1), (1, 0), (1, 1)])
def test_a_side_that_the_edge_of_the_sensor_cuts_off_is_not_corrected(axis: int, edge: int) -> None:
    place = [{"x": 5}, {"x": 194}, {"y": 5}, {"y": 114}][2 * axis + edge]
    rules, world = scene({"usual": 4.0, "travel": 1.0} | place)
    world.cov[0] = np.diag([4.0, 0.01, 4.0, 0.01])
    x, y = (round(v) for v in world.state[0, :, 0])
    half = 10
    for at in range(-half, half + 1):
        for px, py in ((x + at, y - half), (x + at, y + half), (x - half, y + at), (x + half, y + at)):
            if 0 <= px < rules.width and 0 <= py < rules.height:
                world.seen[py, px] = T_US - 10_000
    assert look.look(rules, world, 0, 0, T_US) > 0
    assert world.state[0, axis, 0] == pytest.approx([[5, 194], [5, 114]][axis][edge], abs=0.4)
    assert world.state[0, axis, 2] == pytest.approx(10, abs=0.4)
