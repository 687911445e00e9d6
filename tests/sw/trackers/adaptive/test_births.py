# SPDX-License-Identifier: Apache-2.0
"""How new objects of the adaptive tracker are found: groups of cells, noise, the start of an object and its return."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.trackers.adaptive import births, restless
from evcot.trackers.adaptive.layout import INSIDE, LEVELS, World
from support.interpreted import HEIGHT, WIDTH, interpret, scene

GONE = {"missed": 1.0}


@pytest.fixture(autouse=True)
def _interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    interpret(monkeypatch)


def box(left: float, right: float, top: float, bottom: float) -> NDArray[np.float64]:
    return np.array([left, right, top, bottom], float)


def set_pixels(world: World, level: int, *places: tuple[int, int]) -> None:
    """Note events outside objects at (x, y)."""
    for x, y in places:
        world.pixels[level, y >> 3, x >> 3] |= world.bits[y & 7, x & 7]


def image(words: NDArray[np.uint64]) -> NDArray[np.bool_]:
    """The pixels of all cells, (height, width)."""
    rows, columns = words.shape
    bits = (words[:, :, None] >> np.arange(64, dtype=np.uint64)) & np.uint64(1)
    return bits.reshape(rows, columns, 8, 8).transpose(0, 2, 1, 3).reshape(8 * rows, 8 * columns).astype(bool)


def test_slots_are_free_where_no_object_lives() -> None:
    _, world = scene({}, {"alive": False}, {})
    assert births._free_slot(world) == 1
    births.list_living(world)
    assert (world.run[0].live, world.slots[:2].tolist()) == (2, [0, 2])
    world.objects["alive"] = True
    assert births._free_slot(world) == -1


def test_a_group_is_what_touches_at_sides_and_corners_and_has_enough_pixels() -> None:
    _, world = scene()
    first, corner, beyond = [(32, 25), (39, 24)], [(40, 33), (41, 38), (47, 39)], [(48, 25), (50, 30)]
    few, elsewhere, before = [(30, 28)], [(80, 80), (81, 81)], [(23, 20), (22, 21)]
    set_pixels(world, 1, *first, *corner, *beyond, *few, *elsewhere, *before)
    bounds = box(0, 0, 0, 0)
    assert births._gather(world, 1, 3, 4, bounds, 2.0) == (7, 3)
    assert bounds.tolist() == [32, 50, 24, 39]
    assert sorted(world.queue[:3].tolist()) == [3 * 25 + 4, 3 * 25 + 6, 4 * 25 + 5]
    left = {(int(x), int(y)) for y, x in np.argwhere(image(world.pixels[1]))}
    assert left == {*few, *elsewhere, *before}


@pytest.mark.parametrize(("x", "y"), [(48, 24), (16, 24), (32, 40), (32, 8)])
def test_cells_with_a_cell_between_them_are_two_groups(x: int, y: int) -> None:
    _, world = scene()
    set_pixels(world, 0, (32, 24), (x, y))
    assert births._gather(world, 0, 3, 4, box(0, 0, 0, 0), 1.0) == (1, 1)


@pytest.mark.parametrize(("row", "column"), [(0, 0), (14, 24)])
def test_a_group_may_lie_in_the_corner_of_the_sensor(row: int, column: int) -> None:
    _, world = scene()
    world.pixels[0] = world.bits[2, 3]
    bounds = box(0, 0, 0, 0)
    assert births._gather(world, 0, row, column, bounds, 1.0) == (375, 375)
    assert bounds.tolist() == [3, 195, 2, 114]


@pytest.mark.parametrize(
    ("given", "seen"),
    [
        ({"missed": 0.14}, True),
        ({"missed": 0.15}, False),
        ({"missed": 5.0, "track_id": -1}, True),
        ({"missed": 0.9, "away": 0}, True),  # over an edge: the rest follows
        ({"missed": 1.0, "away": 0}, False),
        ({"missed": 0.9, "away": INSIDE}, False),
    ],
)
def test_what_is_close_to_an_object_seen_lately_is_its_own(given: dict[str, Any], seen: bool) -> None:
    _, world = scene(given)
    assert births._is_seen(world.objects[0]) == seen
    assert births._touches(world, box(95, 99, 50, 70), 0.1) == seen


# Half sides of 10 px and a gate of 2 px around (100, 60): 88 to 112, 48 to 72. Half a second, in which 20 px/s are 10 px.
@pytest.mark.parametrize(
    ("given", "reach"),
    [
        ({}, (88, 112, 48, 72)),
        ({"vx": 20}, (68, 112, 48, 72)),  # and a half side behind
        ({"vx": -20}, (88, 132, 48, 72)),
        ({"vy": 10}, (88, 112, 38, 72)),  # at half its greatest speed half of that
        ({"vx": 20, "track_id": -1}, (78, 112, 48, 72)),
        ({"vx": 20, "speed": 0.0}, (78, 112, 48, 72)),
        ({"track_id": 0, "vy": -10}, (88, 112, 48, 82)),
    ],
)
def test_an_object_reaches_as_far_as_its_gate_and_back_where_it_was(
    given: dict[str, Any], reach: tuple[float, float, float, float]
) -> None:
    _, world = scene(given, {"x": 20, "y": 20})
    left, right, top, bottom = reach
    inside = [
        box(left - 9, left, 60, 61),
        box(right, right + 9, 60, 61),
        box(100, 101, top - 9, top),
        box(100, 101, bottom, 99),
    ]
    assert [births._touches(world, one, 0.5) for one in inside] == [True] * 4
    outside = [inside[k] + 0.1 * (2 * (k % 2) - 1) for k in range(4)]
    assert [births._touches(world, one, 0.5) for one in outside] == [False] * 4


@pytest.mark.parametrize(
    ("bounds", "edge"),
    [
        ((7.9, 50, 20, 30), 0),
        ((8, 50, 20, 30), -1),
        ((50, 192, 20, 30), 1),
        ((50, 191.9, 20, 30), -1),
        ((50, 60, 7.9, 30), 2),
        ((50, 60, 8, 30), -1),
        ((50, 60, 20, 112), 3),
        ((50, 60, 20, 111.9), -1),
        ((0, 10, 0, 11), 0),
        ((0, 10, 0, 9), 2),
        ((190, 199, 100, 119), 1),
        ((170, 199, 100, 119), 3),
        ((0, 10, 0, 10), 0),
        ((0, 0, 20, 20), 0),
    ],
)
def test_the_edge_of_a_group_is_the_one_along_which_it_is_longest(bounds: tuple[float, ...], edge: int) -> None:
    assert births._edge(scene()[0], box(*bounds)) == edge


def test_drift_is_that_of_a_line_through_the_pixels_if_it_exceeds_three_standard_deviations() -> None:
    rng, moving = np.random.default_rng(3), 0
    for case in range(200):
        _, world = scene()
        n = int(rng.integers(3, 16))
        at = rng.permutation(30)[:n]
        x, y = 50 + at % 10, 30 + at // 10
        ago_us = rng.integers(0, 300, n) + 150 * (x - 50) * (case % 2)
        world.seen[y, x] = 1_000_000 - ago_us
        world.seen[30, 60] = 1_000_000 - 2_001  # before the window
        t_s = -1e-6 * ago_us
        fits = [np.polyfit(t_s, places, 1) for places in (x, y)]
        rest = sum(np.sum((places - np.polyval(fit, t_s)) ** 2) for places, fit in zip((x, y), fits, strict=True))
        drift, spread = np.hypot(fits[0][0], fits[1][0]), np.sum((t_s - t_s.mean()) ** 2)
        expected = drift if drift > 3 * np.sqrt(rest / ((n - 2) * spread)) else 0.0
        moving += expected > 0
        assert births._drift(world, box(50, 60, 30, 41), 1_000_000, 2_000) == pytest.approx(expected)
    assert 20 < moving < 180


@pytest.mark.parametrize(("ago_us", "speed"), [([0, 0, 0], 0.0), ([0, 1000], 0.0), ([0, 1000, 2000], 1000.0)])
def test_drift_needs_three_pixels_at_different_times(ago_us: list[int], speed: float) -> None:
    _, world = scene()
    world.seen[30, 50 : 50 + len(ago_us)] = 1_000_000 - np.array(ago_us[::-1])
    assert births._drift(world, box(50, 60, 30, 30), 1_000_000, 2_000) == pytest.approx(speed)


# A box from 40 to 60 and from 30 to 42 has a mean half side of 8 px; 0.08 of it in 20 ms are 32 px/s.
BOX = box(40, 60, 30, 42)


def started(t_us: int, bounds: NDArray[np.float64] = BOX, drift_px_s: float = 0.0) -> World:
    rules, world = scene({"x": 20, "away": 3, "inside": 1, "meets": True, "missed": 1.0, "apart": 2})
    world.run[0].first_us = 500
    for x in range(40, 61) if drift_px_s else []:
        world.seen[36, x] = t_us - int(1e6 * (60 - x) / drift_px_s)
    births._start(rules, world, 0, bounds, 50, t_us, 20_000)
    return world


def test_a_new_object_has_the_box_of_its_group_and_an_unknown_velocity() -> None:
    world = started(40_501)
    np.testing.assert_allclose(world.state[0], [[50, 0, 10, 0], [36, 0, 6, 0]])
    for axis in range(2):  # 0.3 half sides; the speed; 0.3 of the speed
        np.testing.assert_allclose(world.cov[0, axis], np.diag([2.4**2, 32**2, 2.4**2, 9.6**2]))
    o: Any = world.objects[0]
    assert (o.speed, o.usual, o.gate) == pytest.approx((32, 50 / 0.02 / 32, 0.35 * 8))
    assert (o.track_id, o.name, o.inside, o.away, o.edge) == (-1, -1, -1, -1, -1)
    assert (o.mass, o.support, o.packet_events, o.born_us, o.contrast) == (50, 50, 50, 40_501, np.inf)
    assert (o.travel, o.within, o.path, o.still, o.missed) == (0, 0, 0, 0, 0)
    assert (o.alive, o.meets, o.apart, o.unseen_us, o.lost_us, o.packets) == (True, False, 0, 0, 0, 0)


def test_half_sides_of_a_new_object_are_at_least_a_pixel() -> None:
    world = started(40_501, box(50, 51, 30, 30))
    assert (world.state[0, :, 2].tolist(), world.objects["speed"][0]) == ([1, 1], pytest.approx(4.0))


def test_what_is_there_in_the_first_40_ms_has_not_entered() -> None:
    assert [started(t_us, box(0, 20, 30, 42)).objects["edge"][0] for t_us in (40_500, 40_501)] == [-1, 0]


@pytest.mark.parametrize(
    ("t_us", "drift", "speed"),
    [(40_500, 2000, 2000), (40_500, 321, 321), (40_500, 319, 32), (40_501, 2000, 32)],  # 0.8 of 8 px in 20 ms: 320 px/s
)
def test_at_the_beginning_the_drift_of_pixels_is_the_speed(t_us: int, drift: float, speed: float) -> None:
    assert started(t_us, BOX, drift).objects["speed"][0] == pytest.approx(speed, rel=1e-3)


# An object of 20 x 20 px at (100, 60) was lost, and a group found. It is looked for up to 3 half sides and what it missed.
@pytest.mark.parametrize(
    ("given", "centre", "size", "found"),
    [
        ({"missed": 1.0}, (139.9, 60), 20, True),
        ({"missed": 1.0}, (140, 60), 20, False),
        ({"missed": 1.0}, (100, 20.1), 20, True),
        ({"missed": 1.0}, (100, 20), 20, False),
        ({"missed": 0.1}, (100, 60), 20, False),  # it was seen
        ({"missed": 1.0, "away": INSIDE}, (129.9, 60), 20, True),
        ({"missed": 1.0, "away": INSIDE}, (130, 60), 20, False),
        ({"missed": 1.0, "travel": 5.0, "lost_us": 1_000_000}, (169.9, 60), 20, True),  # 1.5 times 20 px more
        ({"missed": 1.0, "travel": 5.0, "lost_us": 1_000_000}, (170, 60), 20, False),
        ({"missed": 1.0, "travel": 4.9, "lost_us": 1_000_000}, (140, 60), 20, False),
        ({"missed": 1.0, "travel": 5.0, "lost_us": 10**9, "x": 20, "speed": 9}, (179.9, 60), 20, True),  # 12 half sides more
        ({"missed": 1.0, "travel": 5.0, "lost_us": 10**9, "x": 20, "speed": 9}, (180, 60), 20, False),
        ({"missed": 1.0}, (100, 60), 5.8, True),  # by 3.5 smaller or larger
        ({"missed": 1.0}, (100, 60), 5.7, False),
        ({"missed": 1.0}, (100, 60), 69.9, True),
        ({"missed": 1.0}, (100, 60), 70, False),
        ({"missed": 1.0, "away": 0, "x": 10}, (10, 60), 20, True),
        ({"missed": 1.0, "away": 0, "x": 10}, (4, 60), 4, True),  # as far as its edge cuts it off, it may be small
        ({"missed": 1.0, "away": 0, "x": 10}, (10, 89.9), 20, True),
        ({"missed": 1.0, "away": 0, "x": 10}, (10, 90), 20, False),
        ({"missed": 1.0, "away": 1, "x": 10}, (10, 60), 20, False),  # it has left over another edge
        ({"missed": 0.9, "away": 0, "x": 10}, (10, 60), 20, False),
    ],
)
def test_a_lost_object_is_found_again_close_by_if_it_is_as_large(
    given: dict[str, Any], centre: tuple[float, float], size: float, found: bool
) -> None:
    rules, world = scene({"missed": 0.0}, given)
    (x, y), half = centre, 0.5 * (size - 1)
    assert births._find_again(rules, world, box(x - half, x + half, y - half, y + half)) == (1 if found else -1)


def test_of_several_lost_objects_the_closest_for_its_size_is_found_again() -> None:
    rules, world = scene(GONE | {"x": 90, "hx": 5, "hy": 5}, GONE | {"x": 118}, GONE | {"x": 120})
    assert births._find_again(rules, world, box(95, 105, 55, 65)) == 1


def resumed(**given: float) -> World:
    lost = {"missed": 1.0, "still": 2.0, "unseen_us": 3, "lost_us": 4, "apart": 5, "travel": 6.0, "within": 7.0, "packets": 8}
    _, world = scene(lost | {"path": 9.0, "track_id": 7, "vx": 5, "gy": 6, "hy": 4} | given)
    births._resume(world, 0, BOX)
    return world


def test_a_found_object_goes_on_with_its_track() -> None:
    world = resumed()
    np.testing.assert_allclose(world.state[0], [[50, 0, 10, 0], [36, 0, 6, 0]])
    for axis in range(2):  # 0.3 of its half side of 10 px before; its speed; 0.3 of the speed
        np.testing.assert_allclose(world.cov[0, axis], np.diag([9, 400, 9, 36]))
    o: Any = world.objects[0]
    assert (o.missed, o.still, o.unseen_us, o.lost_us, o.apart, o.away) == (0, 0, 0, 0, 0, -1)
    assert (o.track_id, o.name, o.travel, o.within, o.packets, o.path, o.edge) == (7, -1, 6, 7, 8, 9, -1)


def test_what_returns_over_an_edge_enters_there_with_its_track() -> None:
    o: Any = resumed(away=0).objects[0]
    assert (o.track_id, o.name, o.travel, o.within, o.packets, o.path, o.edge) == (7, -1, 0, 0, 8, 9, 0)
    assert resumed(away=3).objects[0].edge == 3


def test_what_was_lost_on_the_sensor_must_become_visible_before_it_has_its_name() -> None:
    o: Any = resumed(away=INSIDE).objects[0]
    assert (o.track_id, o.name, o.travel, o.within, o.packets, o.path, o.edge) == (-1, 7, 0, 0, 0, 0, -1)


def test_half_sides_of_a_found_object_are_at_least_a_pixel() -> None:
    _, world = scene(GONE)
    births._resume(world, 0, box(50, 51, 30, 30))
    assert world.state[0, :, 2].tolist() == [1, 1]


@pytest.mark.parametrize("centre", [(100, 60), (103, 62), (4, 3), (-5, 40), (197, 118), (96, 56)])
@pytest.mark.parametrize("half", [3, 10, 16])
def test_pixels_in_the_gates_of_objects_are_removed(centre: tuple[int, int], half: int) -> None:
    (x, y) = centre
    _, world = scene(GONE | {"x": 150, "y": 30}, {"x": x, "y": y, "hx": half, "hy": half + 2, "gate": 2.5})
    world.pixels[:] = np.uint64(2**64 - 1)
    births._sweep(world)
    expected = np.ones((HEIGHT, WIDTH), bool)
    left, right, top, bottom = (int(v) for v in (x - half - 2.5, x + half + 2.5, y - half - 4.5, y + half + 4.5))
    expected[max(top, 0) : bottom + 1, max(left, 0) : right + 1] = False
    for level in range(LEVELS):
        np.testing.assert_array_equal(image(world.pixels[level]), expected)


def test_noise_follows_from_the_empty_cells_far_from_objects() -> None:
    _, world = scene()  # 15 x 25 cells
    world.pixels[2, :4] = np.uint64(3)  # 100 with two pixels
    world.near[14, :, 0] = 0  # 25 near an object
    births._measure_noise(world, 2, 20_000)
    first = restless.rate_of(-np.log(250 / 350), 0.02)
    assert world.run[0].noise == pytest.approx(first)
    world.pixels[2, 4] = np.uint64(1)
    kept = world.run[0].noise
    world.run[0].noise = 0.0
    births._measure_noise(world, 2, 20_000)
    assert world.run[0].noise == pytest.approx(0.2 * restless.rate_of(-np.log(225 / 350), 0.02)), "no noise is known, too"
    world.run[0].noise = kept
    births._measure_noise(world, 2, 20_000)
    assert world.run[0].noise == pytest.approx(first + 0.2 * (restless.rate_of(-np.log(225 / 350), 0.02) - first))


def test_noise_follows_from_the_median_where_few_cells_are_empty() -> None:
    _, world = scene()
    world.near[1:, :, 0] = 0  # 25 cells are far from objects
    world.pixels[2, 0, :18] = np.uint64(0b111)  # 7 of them are empty: 28 %
    births._measure_noise(world, 2, 20_000)
    # The median lies among those with 3 pixels: 5.5 of 18 above the empty ones.
    assert world.run[0].noise == pytest.approx(restless.rate_of(2.5 + 5.5 / 18 + 0.17, 0.02))


@pytest.mark.parametrize(("cells", "known"), [(15, False), (16, True)])
def test_noise_is_measured_in_16_cells_or_more(cells: int, known: bool) -> None:
    _, world = scene()
    world.near[:, :, 0] = 0
    world.near[0, :cells, 0] = -1
    births._measure_noise(world, 2, 20_000)
    assert (world.run[0].noise >= 0) == known


RING = [(x, y) for x in range(64, 80) for y in range(40, 56) if not (64 < x < 79 and 40 < y < 55)]  # 60 pixels in 4 cells


def find(tick: int, *, noise: float = 0.0, level: int = 0, pixels: list[tuple[int, int]] = RING, **config: float) -> World:
    """Births in a world of three lost or free objects, in the windows that end at the tick."""
    rules, world = scene({"alive": False}, {"alive": False}, {"alive": False}, **config)
    births.list_living(world)
    world.run[0].noise, world.run[0].birth_tick, world.run[0].first_us = noise, tick - 1, -(10**6)
    set_pixels(world, level, *pixels)
    for x, y in pixels:
        world.seen[y, x] = 1_000_000 - 1_000
    births.find_births(rules, world, 1_000_000)
    return world


def test_a_ring_of_pixels_becomes_an_object() -> None:
    world = find(1)
    assert (world.run[0].live, world.objects["mass"][0]) == (1, len(RING))
    np.testing.assert_allclose(world.state[0, :, 0], [71.5, 47.5])
    np.testing.assert_allclose(world.state[0, :, 2], [7.5, 7.5])
    assert not world.pixels.any(), "its pixels are no part of longer windows"
    assert world.objects["speed"][0] == pytest.approx(0.08 * 7.5 / 0.005)


def test_a_window_ends_every_power_of_two_ticks() -> None:
    assert [find(tick, level=3).run[0].live for tick in (4, 8, 12, 16)] == [0, 1, 0, 1]
    assert find(8, level=3).objects["speed"][0] == pytest.approx(0.08 * 7.5 / 0.040)


def test_pixels_that_make_no_object_count_in_the_next_window() -> None:
    world = find(2, pixels=RING[:11])
    assert image(world.pixels[2]).sum() == 11
    assert not world.pixels[[0, 1, 3, 4, 5]].any()
    at_the_top = [(x, y - 40) for x, y in RING]
    assert find(1, pixels=at_the_top).run[0].live == 1
    assert find(1, noise=-1.0, pixels=at_the_top).run[0].live == 0, "without a known noise nothing is born"
    assert find(4, noise=-1.0, level=2).run[0].noise > 0, "which is measured in the third window"
    assert find(2, noise=-1.0).run[0].noise == -1.0


def test_births_stop_when_no_object_is_free() -> None:
    rings = [(x + dx, y) for x, y in RING for dx in (-48, 0, 48, 96)]
    world = find(1, pixels=rings)
    assert (world.run[0].live, sorted(world.state[:, 0, 0].tolist())) == (3, [23.5, 71.5, 119.5])


def test_a_group_has_pixels_above_the_noise_and_for_its_contour() -> None:
    square = [(x, y) for x in range(64, 68) for y in range(40, 44)]
    assert find(1, pixels=square).run[0].live == 1
    assert find(1, pixels=square, birth_pixels=14).run[0].live == 1  # 2 for its cell
    assert find(1, pixels=square, birth_pixels=15).run[0].live == 0
    assert find(1, pixels=square, birth_pixels=14, noise=1.0).run[0].live == 0
    diagonal = [(60 + k, 40 + k) for k in range(40)]
    assert find(1, pixels=diagonal).run[0].live == 1  # 40 pixels, 40 wide and high
    assert find(1, pixels=[at for at in diagonal if at[0] % 4]).run[0].live == 0
    assert find(1, pixels=diagonal[:20] + diagonal[21:]).run[0].live == 0
    turned = [(x, 40 + 99 - y) for x, y in diagonal]
    assert find(1, pixels=turned[:20] + turned[21:]).run[0].live == 0


def test_pixels_close_to_an_object_stay_in_longer_windows() -> None:
    rules, world = scene({"x": 71.5, "y": 20, "hx": 10, "hy": 10, "vy": -4000, "track_id": -1}, {"alive": False})
    births.list_living(world)
    world.run[0].noise = 0.0
    set_pixels(world, 0, *RING)
    for x, y in RING:
        world.seen[y, x] = 1_000_000 - 1_000
    births.find_births(rules, world, 1_000_000)
    assert (world.run[0].live, image(world.pixels[1]).sum()) == (1, 60)
