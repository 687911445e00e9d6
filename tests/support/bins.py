# SPDX-License-Identifier: Apache-2.0
"""The state of `auto` with the bins of a look filled, for tests of what is measured in them."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from evcot.trackers.adaptive.bins import smooth
from evcot.trackers.adaptive.layout import World, make_world

__all__ = ["SENSOR", "world_with"]

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
