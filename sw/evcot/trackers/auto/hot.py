# SPDX-License-Identifier: Apache-2.0
"""Hot pixels: those that send many times more events than any pixel around them, epoch after epoch."""

from __future__ import annotations

from numba import njit

from .layout import World

__all__ = ["find_hot_pixels"]

_TIMES = 5  # of the busiest neighbour
_LEAST = 25  # events in an epoch


@njit(cache=True, nogil=True)
def find_hot_pixels(world: World) -> None:
    """Judge every pixel by the events of the epoch that ends now; one that was hot in two in a row is ignored until it calms."""
    height, width = world.activity.shape
    for y in range(height):
        for x in range(width):
            n = world.activity[y, x]
            hot = False
            if n >= _LEAST:
                most = 0
                for yy in range(max(y - 1, 0), min(y + 2, height)):
                    for xx in range(max(x - 1, 0), min(x + 2, width)):
                        if (yy != y or xx != x) and world.hot[yy, xx] == 0:
                            most = max(most, world.activity[yy, xx])
                hot = n >= _TIMES * most
            world.hot[y, x] = min(world.hot[y, x] + 1, 2) if hot else 0
    world.activity[:] = 0
