# SPDX-License-Identifier: Apache-2.0
"""Values of fields, and points of them."""

from __future__ import annotations

from typing import Any

import pytest

from evcot.errors import ConfigError
from evcot_cosim.sweep.axes import Axis, axis_from, grid, latin, uniform


def test_a_grid_is_every_combination_with_the_last_axis_fastest() -> None:
    axes = [axis_from("cot.init_radix", [8, 10]), axis_from("rct.radius_px", {"from": 1.0, "to": 4.0, "steps": 3, "log": True})]
    points = list(grid(axes))
    assert [tuple(point.values()) for point in points] == [(8, 1.0), (8, 2.0), (8, 4.0), (10, 1.0), (10, 2.0), (10, 4.0)]


def test_a_grid_of_whole_numbers_has_each_once() -> None:
    assert axis_from("shape.n_slots", {"from": 1, "to": 3, "steps": 9}).grid() == (1, 2, 3)


def test_a_latin_hypercube_has_one_point_in_each_part() -> None:
    axes = [axis_from("rct.radius_px", {"from": 1.0, "to": 11.0}), axis_from("shape.n_slots", {"from": 1, "to": 10})]
    points = list(latin(axes, 10, 3))
    assert sorted(int(point["rct.radius_px"] - 1.0) for point in points) == list(range(10))
    assert sorted(point["shape.n_slots"] for point in points) == list(range(1, 11))
    assert points == list(latin(axes, 10, 3))
    assert points != list(latin(axes, 10, 4))


def test_random_points_begin_alike_however_many_there_are() -> None:
    axes = [axis_from("rct.radius_px", {"from": 1.0, "to": 100.0, "log": True}), axis_from("filters.polarity", ["on", "off"])]
    few, many = list(uniform(axes, 5, 1)), list(uniform(axes, 400, 1))
    assert many[:5] == few
    below = sum(point["rct.radius_px"] < 10 for point in many)
    assert 150 < below < 250, "half of them below the middle of a ratio"
    assert {point["filters.polarity"] for point in many} == {"on", "off"}
    assert all(1 <= point["rct.radius_px"] <= 100 for point in many)


def test_limits_of_whole_numbers_are_reached() -> None:
    axis = Axis("shape.n_slots", (), 1, 3)
    assert {axis.at(share / 100) for share in range(100)} == {1, 2, 3}
    assert (axis.at(0.0), axis.at(0.999999)) == (1, 3)


@pytest.mark.parametrize(
    ("name", "values", "why"),
    [
        ("cot.init_radii", [1], "fields.cot.init_radii: no such field: must be one of clust_nev, "),
        ("cut.init_radix", [1], "fields.cut.init_radix: no such field: must be preset, hardware, or TABLE.FIELD"),
        ("slot.init_radix", [1], "fields.slot.init_radix: no such field"),
        ("rct.radius_px", [], "fields.rct.radius_px = []: must have one value at least"),
        ("rct.radius_px", {"from": 5.0, "to": 5.0}, "fields.rct.radius_px: from 5.0 to 5.0: is empty"),
        ("rct.radius_px", {"from": 5.0, "to": 2000.0}, "fields.rct.radius_px: 2000.0: must be from 0.5 to 1000 "),
        ("cot.hist_avg", [3, 9], "fields.cot.hist_avg: 9: must be from 0 to 8 "),
        ("cot.hist_avg", [3.5], "fields.cot.hist_avg: 3.5: must be from 0 to 8 "),
        ("shape.n_slots", {"from": 0, "to": 4}, "fields.shape.n_slots: 0: must be from 1 to 64 "),
        ("filters.recent_radius", [True], "fields.filters.recent_radius: True: must be from 1 to 15 "),
        ("rct.alpha", {"from": 0.1, "upto": 0.2}, "fields.rct.alpha: unknown key 'upto'"),
        ("rct.alpha", {"from": 0.1, "to": "b"}, "fields.rct.alpha.to = 'b': must be a number"),
        ("rct.coast_us", {"from": 0, "to": 9, "log": True}, "fields.rct.coast_us: from 0: must be above 0 with log"),
        (
            "rct.alpha",
            {"from": 0.1, "to": 0.2, "steps": 1},
            "fields.rct.alpha.steps = 1: must be a whole number from 2 to ",
        ),
    ],
)
def test_what_cannot_be_is_refused(name: str, values: Any, why: str) -> None:
    with pytest.raises(ConfigError) as refused:
        axis_from(name, values)
    assert str(refused.value).startswith(why)


def test_a_range_without_steps_is_no_grid() -> None:
    with pytest.raises(ConfigError, match=r"fields.rct.alpha: a range without steps"):
        next(grid([axis_from("rct.alpha", {"from": 0.1, "to": 0.2})]))


def test_a_grid_has_its_limit() -> None:
    axes = [Axis(f"a{i}", tuple(range(100))) for i in range(4)]
    with pytest.raises(ConfigError, match="100,000,000 points: must be at most 200,000"):
        next(grid(axes))
