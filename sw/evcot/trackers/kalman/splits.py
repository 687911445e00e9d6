# SPDX-License-Identifier: Apache-2.0
"""Split a box around two objects: its profile has a gap, and the two sides of the gap are not parts of one object."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from ..._numba_private import step
from .layout import PROFILE, Rules, World
from .unity import are_parts

__all__ = ["split"]

Table = NDArray[Any]

_EMPTY = 0.1  # events in a part of a side that is empty, of the mean
_GAP = 2  # parts that must be empty
_SLACK = 1.5  # factor of the merging distance from which on two parts are split
_ENOUGH = 200.0  # minimum number of events in a profile


@step
def _cell(world: World, i: int, axis: int, along: int, across: int) -> float:
    at = PROFILE * across + along if axis == 0 else PROFILE * along + across
    return float(world.profile[i, at])


@step
def _sums(world: World, i: int, axis: int, begin: int, end: int, sums: Table) -> None:
    """Sum the profile's parts `begin` to `end` along this axis, for each part along the other."""
    sums[:] = 0.0
    for along in range(begin, end):
        for across in range(PROFILE):
            sums[across] += _cell(world, i, axis, along, across)


@step
def _extent(sums: Table, level: float) -> tuple[int, int]:
    """The first non-empty part, and the one after the last."""
    begin, end = 0, PROFILE
    while begin < end - 1 and sums[begin] < level:
        begin += 1
    while end > begin + 1 and sums[end - 1] < level:
        end -= 1
    return begin, end


@step
def _bounds(world: World, i: int, axis: int, begin: int, end: int, box: Table) -> float:
    """Compute centre and half side, by axis, of the parts `begin` to `end` along an axis; returns the number of events."""
    sums = world.sums[1]
    _sums(world, i, axis, begin, end, sums)
    first, after = _extent(sums, _EMPTY * sums.sum() / PROFILE)
    for a, low, high in ((axis, begin, end), (1 - axis, first, after)):
        s = world.state[i, a]
        box[a, 0] = s[0] + s[2] * ((low + high) / PROFILE - 1.0)
        box[a, 1] = s[2] * (high - low) / PROFILE
    return float(sums.sum())


@step
def split(rules: Rules, world: World, i: int) -> bool:
    """If a box holds two objects, shrink it to the larger of them."""
    sums, a, b = world.sums[0], world.sides[0], world.sides[1]
    for axis in range(2):
        _sums(world, i, 1 - axis, 0, PROFILE, sums)
        events = sums.sum()
        if events < _ENOUGH:
            return False
        level = _EMPTY * events / PROFILE
        begin, end = _extent(sums, level)
        k = begin + 1
        while k < end:
            after = k
            while after < end and sums[after] < level:
                after += 1
            if after - k >= _GAP and after < end:
                more = _bounds(world, i, axis, begin, k, a) >= _bounds(world, i, axis, after, end, b)
                if not are_parts(a, b, rules.merge_gap, _SLACK):
                    _leave(world, i, a if more else b)
                    return True
            k = after + 1
    return False


@step
def _leave(world: World, i: int, box: Table) -> None:
    for axis in range(2):
        world.state[i, axis, 0] = box[axis, 0]
        world.state[i, axis, 2] = max(box[axis, 1], 1.0)
        world.state[i, axis, 3] = 0.0
        for row in range(4):
            for column in range(4):
                world.cov[i, axis, row, column] *= 4.0
    world.profile[i] = 0.0
    world.total[i] = PROFILE * PROFILE
