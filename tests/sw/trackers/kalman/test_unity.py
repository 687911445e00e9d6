# SPDX-License-Identifier: Apache-2.0
"""When two overlapping boxes are one object."""

from __future__ import annotations

import pytest
from numba import njit

from evcot.trackers.kalman.layout import Rules, World, make_rules, make_world
from evcot.trackers.kalman.presets import PRESETS
from evcot.trackers.kalman.unity import are_one

SENSOR = 346, 260


@njit(nogil=True)
def one_object(rules: Rules, world: World) -> bool:
    """`are_one`, which is called only by compiled functions, with an entry for Python."""
    return are_one(rules, world, 0, 1)


@pytest.mark.parametrize(
    ("alone_us", "velocities", "one"),
    [
        ((0, 2_000_000), (15.0, -15.0), True),  # a part that was never seen alone; its velocity is hardly known
        ((600_000, 2_000_000), (15.0, -15.0), False),  # two people who pass each other
        ((600_000, 2_000_000), (15.0, 12.0), True),  # who walk together, or two tracks on one
        ((600_000, 2_000_000), (90.0, 20.0), True),  # cars, or what a tracker has made of them
        ((600_000, 2_000_000), (90.0, -90.0), False),
    ],
)
def test_people_who_pass_each_other_stay_two(alone_us: tuple[int, int], velocities: tuple[float, float], one: bool) -> None:
    rules, world = make_rules(PRESETS["road"], *SENSOR), make_world(2, *SENSOR)
    world.run["packet_end_us"] = 5_000_000
    world.objects["alive"], world.objects["edge"] = True, -1
    world.objects["alone_us"] = alone_us
    world.state[:, :, 0] = (170.0, 100.0)
    world.state[:, :, 2] = (7.0, 15.0)
    world.state[:, 0, 1] = velocities
    world.cov[:, :, 1, 1] = 20.0**2
    assert one_object(rules, world) is one
