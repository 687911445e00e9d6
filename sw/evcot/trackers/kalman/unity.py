# SPDX-License-Identifier: Apache-2.0
"""When are two boxes parts of one object?"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .layout import Rules, World

__all__ = ["are_one", "are_parts"]

Table = NDArray[Any]

_NEW_US = 200_000
_ALONE_US = 500_000  # who has been alone for so long, and is as slow as people are, is no part of another that has
_SLOW = 7.0  # half sides per second
_ENTERING_GAP = 1.0  # between two that enter, as a part of the longest half side
_WITHIN = 0.7  # of the smaller box, in the greater
_ABREAST = 0.6  # of the wider, covered by the other
_ELONGATED = 2.3  # length of an object by its width, at most


@njit(cache=True, nogil=True)
def _within(a: Table, b: Table) -> bool:
    """Whether the smaller box lies in the greater for the most part along both axes."""
    for axis in range(2):
        overlap = a[axis, 1] + b[axis, 1] - abs(a[axis, 0] - b[axis, 0])
        if overlap < 2.0 * _WITHIN * min(a[axis, 1], b[axis, 1]):
            return False
    return True


@njit(cache=True, nogil=True)
def are_parts(a: Table, b: Table, gap: float, slack: float) -> bool:
    """Whether two boxes (2, 2) of centre and half side by axis lie so that they can be parts of one object: one in the other
    for the most part; or one behind the other, as wide as each other, and together no longer than an object is."""
    overlap, together = np.empty(2), np.empty(2)
    for axis in range(2):
        low_a, high_a = a[axis, 0] - a[axis, 1], a[axis, 0] + a[axis, 1]
        low_b, high_b = b[axis, 0] - b[axis, 1], b[axis, 0] + b[axis, 1]
        overlap[axis] = min(high_a, high_b) - max(low_a, low_b)
        together[axis] = max(high_a, high_b) - min(low_a, low_b)
    if _within(a, b):
        return True
    for axis in range(2):
        across = 1 - axis
        if (
            overlap[across] >= 2.0 * _ABREAST / slack * max(a[across, 1], b[across, 1])
            and -overlap[axis] <= slack * gap * 0.25 * (together[0] + together[1])
            and together[axis] <= slack * _ELONGATED * together[across]
        ):
            return True
    return False


@njit(cache=True, nogil=True)
def are_one(rules: Rules, world: World, i: int, k: int) -> bool:
    """Whether two objects are one: parts of one by place, and with one motion; or both entering over one edge, side by side."""
    a, b = world.state[i], world.state[k]
    one, other = world.objects[i], world.objects[k]
    new_us = world.run[0].packet_end_us - _NEW_US
    if one.edge >= 0 and one.edge == other.edge and min(one.born_us, other.born_us) > new_us:
        gap, most = -1e9, 0.0
        for axis in range(2):
            gap = max(gap, abs(a[axis, 0] - b[axis, 0]) - a[axis, 2] - b[axis, 2])
            most = max(most, a[axis, 2], b[axis, 2])
        if gap <= _ENTERING_GAP * most:
            return True
    fast = max(np.hypot(a[0, 1], a[1, 1]), np.hypot(b[0, 1], b[1, 1]))
    unsure = 0.0
    if min(one.alone_us, other.alone_us) < _ALONE_US or fast > _SLOW * 0.5 * (a[0, 2] + a[1, 2]):
        for axis in range(2):
            unsure += world.cov[i, axis, 1, 1] + world.cov[k, axis, 1, 1]
    if np.hypot(a[0, 1] - b[0, 1], a[1, 1] - b[1, 1]) > rules.merge_velocity * (fast + np.sqrt(unsure)):
        return False
    if max(one.born_us, other.born_us) <= new_us:
        return _within(a[:, ::2], b[:, ::2])
    return are_parts(a[:, ::2], b[:, ::2], rules.merge_gap, 1.0)
