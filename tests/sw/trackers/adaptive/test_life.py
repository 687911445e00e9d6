# SPDX-License-Identifier: Apache-2.0
"""Groups of pixels, and measurements of an object from them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from evcot.trackers.adaptive.bins import find_parts
from evcot.trackers.adaptive.config import AdaptiveConfig
from evcot.trackers.adaptive.layout import BINS, PARTS, Rules, World, make_rules
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


LEVEL = 2.0


@njit(nogil=True)
def parts_of(world: World, rows: int, half: NDArray[Any], reach: NDArray[Any], link: int) -> int:
    """`find_parts`, which is called only by compiled functions, with an entry for Python."""
    return find_parts(world, LEVEL, rows, half, reach, 1, link)


def slow_parts(bins: NDArray[np.float64], link: int) -> list[tuple[tuple[int, int, int, int], float, set[tuple[int, int]]]]:
    """Of each part, in the order of their first bins by row: its bounds, its pixels, its bins."""
    rows, columns = bins.shape
    padded = np.pad(bins, 1)
    around = sum(padded[v : v + rows, u : u + columns] for v in range(3) for u in range(3))
    free = {(int(y), int(x)) for y, x in np.argwhere((bins > 0) & (around >= LEVEL))}
    found = []
    while free:
        part, edge = set(), [min(free)]
        while edge:
            y, x = edge.pop()
            if (y, x) in free:
                free.remove((y, x))
                part.add((y, x))
                edge += [(y + v, x + u) for v in range(-link, link + 1) for u in range(-link, link + 1)]
        ys, xs = zip(*part, strict=True)
        found.append(((min(xs), max(xs) + 1, min(ys), max(ys) + 1), float(sum(bins[at] for at in part)), part))
    return found


@pytest.mark.parametrize("link", [2, 3])
@pytest.mark.parametrize("density", [0.02, 0.06, 0.1, 0.3])
def test_parts_are_those_of_a_search_bin_by_bin(density: float, link: int) -> None:
    rng = np.random.default_rng([61, link, round(100 * density)])
    several = many = 0
    for _ in range(60):
        rows, columns = rng.integers(1, BINS + 1, 2)
        bins = (rng.integers(1, 5, (rows, columns)) * (rng.random((rows, columns)) < density)).astype(np.float64)
        world = world_with(bins)
        reach = 0.5 * np.array([columns, rows])
        half = reach - rng.uniform(0, 4, 2)
        n = parts_of(world, rows, half, reach, link)
        slow = slow_parts(bins, link)
        assert n == min(len(slow), PARTS)
        several += n > 1
        many += len(slow) > PARTS
        for k, (bounds, mass, part) in enumerate(slow[:n]):
            assert (*world.parts[k, 0], *world.parts[k, 1]) == bounds
            inside = sum(
                bins[y, x] for y, x in part if abs(x + 0.5 - reach[0]) <= half[0] and abs(y + 0.5 - reach[1]) <= half[1]
            )
            assert tuple(world.parts[k, 2]) == (mass, inside)
            assert all(world.label[at] == k + 1 for at in part)
        taken = {(y, x) for y in range(rows) for x in range(columns) if int(world.taken[y]) >> x & 1}
        assert taken == set().union(*(part for _, _, part in slow[:n]))
    assert several > 0
    assert many > 0 or (density, link) != (0.02, 2)
