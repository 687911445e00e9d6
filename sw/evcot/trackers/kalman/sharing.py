# SPDX-License-Identifier: Apache-2.0
"""Assignment of events: with one object nearby, by its gate; with several, shared in proportion to their event densities."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from ..._numba_private import step
from .layout import CELL_BITS, MANY, NOBODY, PROFILE, Rules, World

__all__ = ["prepare_packet", "share"]

Table = NDArray[Any]

_OUTSIDE = 0.1  # density in the gate around a box, as a part of that inside
_PRIOR = 1.0  # prior event count of each part of a profile


@step
def prepare_packet(rules: Rules, world: World) -> None:
    """Prepare the assignment of the open packet's events: each object's predicted box in mid-packet, and its cells."""
    world.near[:] = NOBODY
    middle_s = 0.5e-6 * rules.packet_us
    for i in range(len(world.objects)):
        o = world.objects[i]
        if not o.alive:
            continue
        s = world.state[i]
        o.x, o.y = s[0, 0] + middle_s * s[0, 1], s[1, 0] + middle_s * s[1, 1]
        o.half_x, o.half_y = s[0, 2], s[1, 2]
        o.weight = 0.0
        o.packet_events = 0
        world.beyond[i] = 0.0
        world.abreast[i] = 0.0
        o.gate = max(rules.gate_px, 0.5 * rules.gate_share * (o.half_x + o.half_y))
        _open_gate(o, rules.width, rules.height)
        top, bottom = max(int(o.top), 0) >> CELL_BITS, min(int(o.bottom) + 1, rules.height - 1) >> CELL_BITS
        left, right = max(int(o.left), 0) >> CELL_BITS, min(int(o.right) + 1, rules.width - 1) >> CELL_BITS
        for row in range(top, bottom + 1):
            for column in range(left, right + 1):
                world.near[row, column] = i if world.near[row, column] == NOBODY else MANY


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
def _density(world: World, i: int, x: float, y: float) -> float:
    """Expected number of events of object i per packet and pixel at a position."""
    o = world.objects[i]
    dx, dy = x - o.x, y - o.y
    if x < o.left or x > o.right or y < o.top or y > o.bottom:
        return 0.0
    seen = world.profile[i, PROFILE * _part(dy, o.half_y) + _part(dx, o.half_x)] + _PRIOR
    outside = _OUTSIDE if abs(dx) > o.half_x or abs(dy) > o.half_y else 1.0
    return float(outside * seen * (o.rate + 1e-3) / (world.total[i] * o.half_x * o.half_y))


@step
def _take(world: World, i: int, x: float, y: float, weight: float) -> bool:
    """Assign a share of an event to an object; returns False if the event lies outside its gate."""
    o = world.objects[i]
    dx, dy = x - o.x, y - o.y
    if x < o.left or x > o.right or y < o.top or y > o.bottom:
        return False
    o.weight += weight
    if abs(dy) <= o.half_y:
        world.abreast[i, 0] += weight
        if dx > o.half_x:
            world.beyond[i, 0, 1] += weight
        elif dx < -o.half_x:
            world.beyond[i, 0, 0] += weight
    if abs(dx) <= o.half_x:
        world.abreast[i, 1] += weight
        if dy > o.half_y:
            world.beyond[i, 1, 1] += weight
        elif dy < -o.half_y:
            world.beyond[i, 1, 0] += weight
    return True


@step
def share(world: World, x: int, y: int) -> int:
    """Assign an event; returns the slot with the largest share, or NOBODY after marking the pixel for births."""
    row, column = y >> CELL_BITS, x >> CELL_BITS
    near = world.near[row, column]
    if near >= 0 and _take(world, near, x, y, 1.0):
        o = world.objects[near]
        o.packet_events += 1
        if not o.meets:  # otherwise the profile would lack the parts that others hide
            world.profile[near, PROFILE * _part(y - o.y, o.half_y) + _part(x - o.x, o.half_x)] += 1.0
            world.total[near] += 1.0
        return int(near)
    if near == MANY:
        best, most, total = NOBODY, 0.0, 0.0
        for i in range(len(world.objects)):
            if world.objects[i].alive:
                density = _density(world, i, x, y)
                total += density
                if density > most:
                    best, most = i, density
        if best >= 0:
            for i in range(len(world.objects)):
                if world.objects[i].alive:
                    density = _density(world, i, x, y)
                    if density > 0.0:
                        _take(world, i, x, y, density / total)
            world.objects[best].packet_events += 1
            return best
    world.pixels[row, column] |= world.bits[y & 7, x & 7]
    return NOBODY
