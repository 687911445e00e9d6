# SPDX-License-Identifier: Apache-2.0
"""How an object stands out in a look, against a slow count."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from evcot.trackers.adaptive.config import AdaptiveConfig
from evcot.trackers.adaptive.layout import BINS, Rules, World, make_rules
from evcot.trackers.adaptive.look import _measure_contrast
from support.bins import SENSOR, world_with


@njit(nogil=True)
def measure_contrast(rules: Rules, world: World, rows: int, columns: int, bin_px: int, reach: NDArray[Any]) -> None:
    """`_measure_contrast`, which is called only by compiled functions, with an entry for Python."""
    _measure_contrast(rules, world, 0, rows, columns, bin_px, reach)


def slow_contrast(world: World, rules: Rules, bins: NDArray[np.float64], bin_px: int, reach: NDArray[np.float64]) -> float:
    s, bounds, edge = world.state[0], world.bounds, 0.5 * world.objects["gate"][0]
    inner, outer = [], []
    for y, x in np.ndindex(*bins.shape):
        dx, dy = (x + 0.5) * bin_px - reach[0], (y + 0.5) * bin_px - reach[1]
        if not (0 <= s[0, 0] + dx <= rules.width - 1 and 0 <= s[1, 0] + dy <= rules.height - 1):
            continue
        if bounds[0, 0] <= dx <= bounds[0, 1] and bounds[1, 0] <= dy <= bounds[1, 1]:
            inner.append(bins[y, x])
        elif not (bounds[0, 0] - edge <= dx <= bounds[0, 1] + edge and bounds[1, 0] - edge <= dy <= bounds[1, 1] + edge):
            outer.append(bins[y, x])
    return float((sum(inner) / max(len(inner), 1) + 1e-9) / (sum(outer) / max(len(outer), 1) + 1e-9))


def test_contrast_is_that_of_a_count_bin_by_bin() -> None:
    rng, rules = np.random.default_rng(62), make_rules(AdaptiveConfig(), *SENSOR)
    at_an_edge = 0
    for _ in range(300):
        rows, columns = rng.integers(1, BINS + 1, 2)
        bin_px = int(rng.integers(1, 4))
        bins = (rng.integers(1, 5, (rows, columns)) * (rng.random((rows, columns)) < 0.2)).astype(np.float64)
        world = world_with(bins)
        reach: Any = 0.5 * bin_px * np.array([columns, rows])
        world.state[0, :, 0] = rng.uniform(0, SENSOR)
        world.objects["gate"] = rng.uniform(0, 10)
        world.bounds[:] = np.sort(rng.uniform(-reach[:, None], reach[:, None], (2, 2)), axis=1)
        at_an_edge += bool(np.any(world.state[0, :, 0] < reach))
        measure_contrast(rules, world, rows, columns, bin_px, reach)
        assert world.objects["contrast"][0] == slow_contrast(world, rules, bins, bin_px, reach)
    assert at_an_edge > 20
