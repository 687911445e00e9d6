# SPDX-License-Identifier: Apache-2.0
"""Pixels that never rest: hot ones, and those that see a lamp flicker. What moves leaves a pixel again."""

from __future__ import annotations

import numpy as np
from numba import njit

from .layout import World

__all__ = ["EPOCH_BIRTHS", "find_restless"]

EPOCH_BIRTHS = 10  # birth windows in an epoch
_EPOCHS = 20  # remembered
_LEAST = 10  # from which on a pixel is judged
_ACTIVE = 0.9  # of the epochs


@njit(cache=True, nogil=True)
def find_restless(world: World) -> None:
    """End an epoch: mark the pixels that sent events in nearly all of those remembered, and begin the next one."""
    run = world.run[0]
    run.epochs += 1
    known = min(run.epochs, _EPOCHS)
    least = int(np.ceil(_ACTIVE * known))
    height, width = world.active.shape
    for y in range(height):
        for x in range(width):
            word = world.active[y, x]
            restless = False
            if word & np.uint32(1) and known >= _LEAST:
                n, rest = 0, word & np.uint32((1 << _EPOCHS) - 1)
                while rest != np.uint32(0):
                    rest &= rest - np.uint32(1)
                    n += 1
                restless = n >= least
            world.restless[y, x] = restless
            world.active[y, x] = word << np.uint32(1)
