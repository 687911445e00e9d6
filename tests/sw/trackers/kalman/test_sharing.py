# SPDX-License-Identifier: Apache-2.0
"""Events are shared among all objects whose gates hold them, however many there are, as a plain search shares them."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from evcot.trackers.kalman.layout import NOBODY, PROFILE, Rules, World, make_rules, make_world
from evcot.trackers.kalman.presets import PRESETS
from evcot.trackers.kalman.sharing import prepare_packet, share

SENSOR = 346, 260
OUTSIDE, PRIOR = 0.1, 1.0


@njit(nogil=True)
def prepare(rules: Rules, world: World) -> None:
    """`prepare_packet`, which is called only by compiled functions, with an entry for Python."""
    prepare_packet(rules, world)


@njit(nogil=True)
def share_event(world: World, x: int, y: int) -> int:
    """`share`, likewise."""
    return share(world, x, y)


def densities(world: World, x: int, y: int) -> np.ndarray:
    """Expected events of each object at a pixel; 0 outside its gate, and for one that is not alive."""
    expected = np.zeros(len(world.objects))
    for i in np.flatnonzero(world.objects["alive"]):
        o = world.objects[i]
        dx, dy = x - o["x"], y - o["y"]
        if abs(dx) <= o["half_x"] + o["gate"] and abs(dy) <= o["half_y"] + o["gate"]:
            parts = [
                np.clip(np.floor((u + half) / (2 * half) * PROFILE), 0, PROFILE - 1)
                for u, half in ((dy, o["half_y"]), (dx, o["half_x"]))
            ]
            seen = world.profile[i, int(PROFILE * parts[0] + parts[1])] + PRIOR
            inside = abs(dx) <= o["half_x"] and abs(dy) <= o["half_y"]
            expected[i] = (1 if inside else OUTSIDE) * seen * (o["rate"] + 1e-3) / (world.total[i] * o["half_x"] * o["half_y"])
    return expected


@pytest.mark.parametrize("n", [12, 64, 130])
def test_events_are_shared_by_density(n: int) -> None:
    rng = np.random.default_rng([11, n])
    rules, world = make_rules(PRESETS["discs"], *SENSOR), make_world(n, *SENSOR)
    world.objects["alive"] = rng.random(n) < 0.9
    world.objects["enters"] = -1
    world.objects["meets"] = True  # profiles stay as they are
    world.objects["rate"] = rng.uniform(1, 20, n)
    world.state[:, :, 0] = rng.uniform((40, 40), (120, 110), (n, 2))
    world.state[:, :, 2] = rng.uniform(3, 30, (n, 2))
    world.profile[:] = rng.uniform(0, 9, world.profile.shape)
    world.total[:] = world.profile.sum(axis=1) + PROFILE**2
    prepare(rules, world)
    weights, events, shared = np.zeros(n), np.zeros(n), 0
    for x, y in rng.integers((0, 0), (160, 150), (400, 2)):
        expected = densities(world, x, y)
        owner = share_event(world, x, y)
        if not expected.any():
            assert owner == NOBODY
            continue
        assert owner == np.argmax(expected)
        weights += expected / expected.sum()
        events[owner] += 1
        shared += np.count_nonzero(expected) > 1
    assert world.objects["weight"] == pytest.approx(weights)
    assert (world.objects["packet_events"] == events).all()
    assert shared > 20
    if n > 64:
        assert events[64:].any(), "objects beyond the first word of a set have their share"
