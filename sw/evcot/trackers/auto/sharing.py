# SPDX-License-Identifier: Apache-2.0
"""Assignment of events: with one object nearby, by its gate; with several, shared in proportion to their event densities."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from ..._numba_private import step
from .layout import BINS, CELL_BITS, NEAR, NOBODY, PROFILE, REACH, Rules, World
from .outline import move_picture

__all__ = ["prepare_packet", "share"]

Table = NDArray[Any]

_OUTSIDE = 0.1  # density in the gate around a box, as a part of that inside
_PRIOR = 1.0  # prior event count of each part of a profile
_LEAST_GATE_PX = 2.0
_THIN = 0.6  # of the longer half side
_KEPT = 0.85


@step
def prepare_packet(rules: Rules, world: World) -> None:
    """Prepare the assignment of the open packet's events: each object's predicted box in mid-packet, and its cells."""
    world.near[:] = NOBODY
    middle_s = 0.5e-6 * world.run[0].packet_us
    for at in range(world.run[0].live):
        i = world.slots[at]
        o, s = world.objects[i], world.state[i]
        o.x, o.y = s[0, 0] + middle_s * s[0, 1], s[1, 0] + middle_s * s[1, 1]
        o.half_x, o.half_y = s[0, 2], s[1, 2]
        o.weight = 0.0
        o.packet_events = 0
        world.beyond[i] = 0.0
        world.abreast[i] = 0.0
        world.moments[i] = 0.0
        o.gate = max(_LEAST_GATE_PX, 0.5 * rules.gate * (o.half_x + o.half_y))
        _open_gate(o, rules.width, rules.height)
        _choose_unit(world, i)
        _enlist(rules, world, i, o.left, o.right, o.top, o.bottom)
    for at in range(world.run[0].live):
        # After the gates of all, which must not be left out.
        i = world.slots[at]
        o = world.objects[i]
        reach_x, reach_y = REACH * o.unit_x, REACH * o.unit_y
        _enlist(rules, world, i, o.x - reach_x, o.x + reach_x, o.y - reach_y, o.y + reach_y)


@step
def _choose_unit(world: World, i: int) -> None:
    """Keep the units of an object's picture close to its half sides, and not far below the longer one: parts may be thin."""
    o = world.objects[i]
    for axis in range(2):
        half, other = (o.half_x, o.half_y) if axis == 0 else (o.half_y, o.half_x)
        wanted = max(half, _THIN * other)
        unit = o.unit_x if axis == 0 else o.unit_y
        if not _KEPT * wanted < unit < wanted / _KEPT:
            if unit > 0.0:
                move_picture(world, i, axis, 0.0, wanted / unit)
                o.floor *= wanted / unit
            if axis == 0:
                o.unit_x = wanted
            else:
                o.unit_y = wanted


@step
def _enlist(rules: Rules, world: World, i: int, left: float, right: float, top: float, bottom: float) -> None:
    """Enter an object in the cells of a rectangle."""
    first, last = max(int(left), 0) >> CELL_BITS, min(int(right) + 1, rules.width - 1) >> CELL_BITS
    for row in range(max(int(top), 0) >> CELL_BITS, (min(int(bottom) + 1, rules.height - 1) >> CELL_BITS) + 1):
        for column in range(first, last + 1):
            for k in range(NEAR):
                if world.near[row, column, k] == NOBODY:
                    world.near[row, column, k] = i
                if world.near[row, column, k] == i:
                    break


@step
def _open_gate(o: Any, width: int, height: int) -> None:
    """Set the gate around a box; for an entering object, up to the edge."""
    o.left, o.right = o.x - o.half_x - o.gate, o.x + o.half_x + o.gate
    o.top, o.bottom = o.y - o.half_y - o.gate, o.y + o.half_y + o.gate
    if o.enters == 0:
        o.left = -1.0
    elif o.enters == 1:
        o.right = width + 1.0
    elif o.enters == 2:
        o.top = -1.0
    elif o.enters == 3:
        o.bottom = height + 1.0


@step
def _part(u: float, half: float) -> int:
    """Index of the part of a side at offset u from its middle."""
    return max(min(int((u + half) * (0.5 * PROFILE / half)), PROFILE - 1), 0)


@step
def _holds(o: Any, x: float, y: float) -> bool:
    return bool(o.left <= x <= o.right and o.top <= y <= o.bottom)


@step
def _density(world: World, i: int, x: float, y: float) -> float:
    """Expected number of events of object i per second and pixel at a position."""
    o = world.objects[i]
    if not _holds(o, x, y):
        return 0.0
    dx, dy = x - o.x, y - o.y
    seen = world.profile[i, PROFILE * _part(dy, o.half_y) + _part(dx, o.half_x)] + _PRIOR
    outside = _OUTSIDE if abs(dx) > o.half_x or abs(dy) > o.half_y else 1.0
    return float(outside * seen * (o.rate + 1e-3) / (world.total[i] * o.half_x * o.half_y))


@step
def _draw(world: World, i: int, x: float, y: float, weight: float) -> None:
    """Add a pixel to an object's picture."""
    o = world.objects[i]
    column = int(((x - o.x) / o.unit_x + REACH) * (BINS / 2.0 / REACH))
    row = int(((y - o.y) / o.unit_y + REACH) * (BINS / 2.0 / REACH))
    if 0 <= column < BINS and 0 <= row < BINS:
        world.picture[i, row, column] += weight * o.gain


@step
def _take(world: World, i: int, x: float, y: float, weight: float) -> None:
    """Assign a share of a pixel in its gate to an object."""
    o = world.objects[i]
    dx, dy = x - o.x, y - o.y
    o.weight += weight
    if abs(dy) <= o.half_y:
        world.abreast[i, 0] += weight
        world.moments[i, 0, 0] += weight * dx
        world.moments[i, 0, 1] += weight * abs(dx)
        if dx > o.half_x:
            world.beyond[i, 0, 1] += weight
        elif dx < -o.half_x:
            world.beyond[i, 0, 0] += weight
    if abs(dx) <= o.half_x:
        world.abreast[i, 1] += weight
        world.moments[i, 1, 0] += weight * dy
        world.moments[i, 1, 1] += weight * abs(dy)
        if dy > o.half_y:
            world.beyond[i, 1, 1] += weight
        elif dy < -o.half_y:
            world.beyond[i, 1, 0] += weight
    _draw(world, i, x, y, weight)


@step
def _own(world: World, i: int, x: int, y: int, fresh: bool) -> None:
    """Assign an event to its only owner."""
    o = world.objects[i]
    o.packet_events += 1
    if fresh:
        _take(world, i, x, y, 1.0)
        if not o.meets:  # otherwise the profile would lack the parts that others hide
            world.profile[i, PROFILE * _part(y - o.y, o.half_y) + _part(x - o.x, o.half_x)] += 1.0
            world.total[i] += 1.0


@step
def _divide(world: World, row: int, column: int, x: int, y: int, fresh: bool) -> int:
    """Divide an event among the objects whose gates hold it; returns the slot with the largest share."""
    best, most, total = NOBODY, -1.0, 0.0
    for k in range(NEAR):
        i = world.near[row, column, k]
        if i == NOBODY:
            break
        if _holds(world.objects[i], x, y):
            density = _density(world, i, x, y)
            total += density
            if density > most:
                best, most = i, density
    if fresh:
        for k in range(NEAR):
            i = world.near[row, column, k]
            if i == NOBODY:
                break
            if _holds(world.objects[i], x, y):
                _take(world, i, x, y, _density(world, i, x, y) / total)
    world.objects[best].packet_events += 1
    return best


@step
def share(world: World, x: int, y: int, fresh: bool) -> int:
    """Assign an event; returns the slot with the largest share, or NOBODY after marking the pixel for births.

    Args:
        fresh: whether it is the pixel's first event in the packet; others change no measurement.
    """
    row, column = y >> CELL_BITS, x >> CELL_BITS
    owner, holding = NOBODY, 0
    for k in range(NEAR):
        i = world.near[row, column, k]
        if i == NOBODY:
            break
        if _holds(world.objects[i], x, y):
            owner = i
            holding += 1
    if holding > 1:
        return int(_divide(world, row, column, x, y, fresh))
    if holding == 1:
        _own(world, owner, x, y, fresh)
    if fresh:
        if holding == 0 or world.objects[owner].track_id < 0:
            for k in range(NEAR):
                i = world.near[row, column, k]
                if i == NOBODY:
                    break
                if i != owner:
                    _draw(world, i, x, y, 1.0)  # it may be a part of that one
        if holding == 0:
            world.pixels[0, row, column] |= world.bits[y & 7, x & 7]
    return int(owner)
