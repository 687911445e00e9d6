# SPDX-License-Identifier: Apache-2.0
"""The extent of an object from its outline: where its pixels lie along each axis, in the object's own frame.

The outline is collected while the object moves, and fades as it travels, so that weak and far edges count although one
packet shows none of them; what moves differently is smeared. A box that holds only a part of the object is extended to the
rest, across gaps of a part of its half side.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .layout import BINS, EDGE_BIN, Rules, World

__all__ = ["fade_outline", "fit_outline"]

Table = NDArray[Any]

_DENSE = 0.2  # of the mean density within the box
_SIGMAS = 3.0
_ENOUGH = 40.0  # pixels in an outline from which it counts
_STEP_BINS = 2  # a side closer than this to the outline's end is left to the correction by quantiles
_LEAST_SHARE = 0.04  # of the pixels, beyond a side, for which it is extended


@njit(cache=True, nogil=True)
def fade_outline(rules: Rules, world: World, i: int, travel: float, noise: float) -> None:
    """Fade an object's outline by a distance travelled, in half sides, and add the noise expected in a packet to its floor.

    Args:
        noise: pixels of the background's noise in a packet, per pixel.
    """
    keep = np.exp(-travel / rules.memory)
    s = world.state[i]
    for axis in range(2):
        for k in range(BINS):
            world.outline[i, axis, k] *= keep
        area = 2.0 * s[1 - axis, 2] * s[axis, 2] / EDGE_BIN
        world.floor[i, axis] = keep * (world.floor[i, axis] + noise * area)


@njit(cache=True, nogil=True)
def fit_outline(rules: Rules, world: World, i: int) -> bool:
    """Extend a box to the end of its outline; returns whether it has changed."""
    changed = False
    half = BINS // 2
    for axis in range(2):
        line, floor = world.outline[i, axis], world.floor[i, axis]
        inside = 0.0
        for k in range(half - EDGE_BIN, half + EDGE_BIN):
            inside += line[k]
        inside -= 2 * EDGE_BIN * floor
        if inside < _ENOUGH:
            continue
        level = max(_DENSE * inside / (2 * EDGE_BIN), 1.0) + floor + _SIGMAS * np.sqrt(floor)
        most = int(rules.gap * EDGE_BIN + 0.5)
        far = np.zeros(2, np.int64)
        for high in range(2):
            gap, mass = 0, 0.0
            for step in range(half - EDGE_BIN):
                k = half + EDGE_BIN + step if high else half - EDGE_BIN - 1 - step
                mass += line[k] - floor
                if line[k] >= level:
                    gap = 0
                    if mass >= _LEAST_SHARE * inside:
                        far[high] = step + 1
                else:
                    gap += 1
                    if gap > most:
                        break
        for high in range(2):
            if far[high] >= _STEP_BINS:
                s = world.state[i, axis]
                by = far[high] * s[2] / EDGE_BIN
                s[0] += 0.5 * by if high else -0.5 * by
                s[2] += 0.5 * by
                world.cov[i, axis, 0, 0] += (0.25 * by) ** 2
                world.cov[i, axis, 2, 2] += (0.25 * by) ** 2
                changed = True
        if changed:
            break
    if changed:
        world.outline[i] = 0.0
        world.floor[i] = 0.0
        world.profile[i] = 0.0
        world.total[i] = 64.0
    return changed
