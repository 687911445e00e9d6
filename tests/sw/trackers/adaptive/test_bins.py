# SPDX-License-Identifier: Apache-2.0
"""The bins of a measurement by the adaptive tracker: the parts into which they fall against a search bin by bin."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from evcot.trackers.adaptive.bins import find_parts, smooth
from evcot.trackers.adaptive.layout import BINS, PARTS, World, make_world

SENSOR = 346, 260


@njit(nogil=True)
def _smooth(world: World, rows: int, columns: int) -> None:
    smooth(world, rows, columns)


def world_with(bins: NDArray[np.float64]) -> World:
    """The state of a tracker of one object whose look shows `bins`, (rows, columns) pixels in each."""
    world = make_world(1, *SENSOR)
    rows, columns = bins.shape
    world.bins[:rows, :columns] = bins
    for y, x in np.argwhere(bins > 0):
        world.filled[y] |= np.uint64(1) << np.uint64(x)
    _smooth(world, rows, columns)
    return world


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
