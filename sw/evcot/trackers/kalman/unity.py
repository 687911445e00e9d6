# SPDX-License-Identifier: Apache-2.0
"""Decide whether two boxes are parts of one object."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import step
from ..boxes import mostly_within, overlap, together
from .layout import Rules, World

__all__ = ["are_one", "are_parts"]

Table = NDArray[Any]

_NEW_US = 200_000
_ALONE_US = 500_000  # two slow objects (people) that have both been alone for this long are not parts of one
_SLOW = 7.0  # half sides per second
_ENTERING_GAP = 1.0  # between two that enter, as a part of the longest half side
_ABREAST = 0.6  # share of the wider box that is covered by the other
_ELONGATED = 2.3  # maximum ratio of length to width of an object


@step
def are_parts(a: Table, b: Table, gap: float, slack: float) -> bool:
    """Whether the positions of two boxes, (2, 2) centre and half side by axis, allow them to be parts of one object: one mostly
    inside the other; or one behind the other, of equal width, and together no longer than an object can be."""
    if mostly_within(a, b):
        return True
    for axis in range(2):
        across = 1 - axis
        length, width = together(a, b, axis), together(a, b, across)
        if (
            overlap(a, b, across) >= 2.0 * _ABREAST / slack * max(a[across, 1], b[across, 1])
            and -overlap(a, b, axis) <= slack * gap * 0.25 * (length + width)
            and length <= slack * _ELONGATED * width
        ):
            return True
    return False


@step
def are_one(rules: Rules, world: World, i: int, k: int) -> bool:
    """Whether two objects are one: by position and with equal motion; or both entering over the same edge, side by side."""
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
    boxes_a, boxes_b = a[:, ::2], b[:, ::2]
    if max(one.born_us, other.born_us) <= new_us:
        if not mostly_within(boxes_a, boxes_b):
            return False
    elif not are_parts(boxes_a, boxes_b, rules.merge_gap, 1.0):
        return False
    fast = max(np.hypot(a[0, 1], a[1, 1]), np.hypot(b[0, 1], b[1, 1]))
    unsure = 0.0
    if min(one.alone_us, other.alone_us) < _ALONE_US or fast > _SLOW * 0.5 * (a[0, 2] + a[1, 2]):
        for axis in range(2):
            unsure += world.cov[i, axis, 1, 1] + world.cov[k, axis, 1, 1]
    return bool(np.hypot(a[0, 1] - b[0, 1], a[1, 1] - b[1, 1]) <= rules.merge_velocity * (fast + np.sqrt(unsure)))
