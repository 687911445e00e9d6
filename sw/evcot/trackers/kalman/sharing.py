# SPDX-License-Identifier: Apache-2.0
"""Assignment of events: with one object nearby, by its gate; with several, shared in proportion to their event densities."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import inlined_step, step
from ...bits import lowest, without_lowest
from .layout import CELL_BITS, MANY, NOBODY, PROFILE, Rules, World

__all__ = ["prepare_packet", "share"]

Table = NDArray[Any]

_OUTSIDE = 0.1  # density in the gate around a box, as a part of that inside
_NONE = np.uint64(0)
_PRIOR = 1.0  # prior event count of each part of a profile


@step
def prepare_packet(rules: Rules, world: World) -> None:
    """Prepare the assignment of the open packet's events: each object's predicted box in mid-packet, and its cells."""
    world.near[:] = NOBODY
    middle_s = 0.5e-6 * rules.packet_us
    n = 0
    for i in range(len(world.objects)):
        o = world.objects[i]
        if not o.alive:
            continue
        world.slots[n] = i
        n += 1
        s = world.state[i]
        o.x, o.y = s[0, 0] + middle_s * s[0, 1], s[1, 0] + middle_s * s[1, 1]
        o.half_x, o.half_y = s[0, 2], s[1, 2]
        o.parts_x, o.parts_y = 0.5 * PROFILE / o.half_x, 0.5 * PROFILE / o.half_y
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
                if world.near[row, column] == NOBODY:
                    world.near[row, column] = i
                    world.sets[row, column] = np.uint64(0)
                else:
                    world.near[row, column] = MANY
                world.sets[row, column, i >> 6] |= np.uint64(1) << np.uint64(i & 63)
    world.run[0].listed = n


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
def _part(u: float, half: float, parts: float) -> int:
    """Index of the part of a side at offset u from its middle; `parts` of them lie in a pixel."""
    return max(min(int((u + half) * parts), PROFILE - 1), 0)


@step
def _part_of_box(o: Any, dx: float, dy: float) -> int:
    """Index of the part of an object's box at an offset from its middle."""
    return PROFILE * _part(dy, o.half_y, o.parts_y) + _part(dx, o.half_x, o.parts_x)


@step
def _density(world: World, i: int, x: float, y: float) -> float:
    """Expected number of events of object i per packet and pixel at a position."""
    o = world.objects[i]
    dx, dy = x - o.x, y - o.y
    if x < o.left or x > o.right or y < o.top or y > o.bottom:
        return 0.0
    seen = world.profile[i, _part_of_box(o, dx, dy)] + _PRIOR
    outside = _OUTSIDE if abs(dx) > o.half_x or abs(dy) > o.half_y else 1.0
    return float(outside * seen * (o.rate + 1e-3) / (world.total[i] * o.half_x * o.half_y))


@inlined_step
def _take(world: World, i: int, x: float, y: float, weight: float) -> bool:
    """Assign a share of an event to an object; returns False if the event lies outside its gate."""
    o = world.objects[i]
    dx, dy = x - o.x, y - o.y
    if x < o.left or x > o.right or y < o.top or y > o.bottom:
        return False
    # Zero is added where a comparison fails: events lie on either side of a box's sides, so no branch could be foreseen.
    o.weight += weight
    along_y = weight if abs(dy) <= o.half_y else 0.0
    along_x = weight if abs(dx) <= o.half_x else 0.0
    world.abreast[i, 0] += along_y
    world.abreast[i, 1] += along_x
    world.beyond[i, 0, 1 if dx > 0.0 else 0] += along_y if abs(dx) > o.half_x else 0.0
    world.beyond[i, 1, 1 if dy > 0.0 else 0] += along_x if abs(dy) > o.half_y else 0.0
    return True


@step
def _share_among(world: World, x: int, y: int, words: Table) -> int:
    """Assign an event to those of a set of objects in whose gates it lies; returns the slot with the largest share."""
    best, most, total = NOBODY, 0.0, 0.0
    for k in range(len(words)):
        word = words[k]
        while word != _NONE:
            i = int(lowest(word)) + (k << 6)
            word = without_lowest(word)
            density = world.density[i] = _density(world, i, x, y)
            total += density
            if density > most:
                best, most = i, density
    if best == NOBODY:
        return NOBODY
    for k in range(len(words)):
        word = words[k]
        while word != _NONE:
            i = int(lowest(word)) + (k << 6)
            word = without_lowest(word)
            if world.density[i] > 0.0:
                _take(world, i, x, y, world.density[i] / total)
    world.objects[best].packet_events += 1
    return best


@inlined_step
def share(world: World, x: int, y: int) -> int:
    """Assign an event; returns the slot with the largest share, or NOBODY after marking the pixel for births."""
    row, column = y >> CELL_BITS, x >> CELL_BITS
    near = world.near[row, column]
    if near >= 0 and _take(world, near, x, y, 1.0):
        o = world.objects[near]
        o.packet_events += 1
        if not o.meets:  # otherwise the profile would lack the parts that others hide
            world.profile[near, _part_of_box(o, x - o.x, y - o.y)] += 1.0
            world.total[near] += 1.0
        return int(near)
    if near == MANY:
        best = _share_among(world, x, y, world.sets[row, column])
        if best != NOBODY:
            return best
    world.pixels[row, column] |= world.bits[y & 7, x & 7]
    return NOBODY
