# SPDX-License-Identifier: Apache-2.0
"""New objects: groups of neighbouring cells with enough different pixels that have unassigned events.

Pixels are counted, not events, so that a hot pixel counts once.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import step
from ...bits import count
from .layout import CELL_BITS, NOBODY, PROFILE, Rules, World

__all__ = ["find_births"]

Table = NDArray[Any]

_CELL_PIXELS = 2.0  # fewer in a cell are noise
_ABOVE_NOISE = 4.0
_NEAR = 2.0  # in gates: anything closer to an object is a part of it that its gate will reach
_CLUTTER_MIX = 0.1
_PLACE_PX = 3.0  # standard deviation of a new object's sides
_EDGE_PX = 8.0
_GROWTH = 0.3  # growth of a half side, as a fraction of the speed


@step
def _free_slot(world: World) -> int:
    for i in range(len(world.objects)):
        if not world.objects[i].alive:
            return i
    return -1


@step
def _gather(world: World, row: int, column: int, box: Table, least: float) -> int:
    """Remove the connected group of cells that contains a cell; returns its pixel count, and its bounds in `box`."""
    rows, columns = world.pixels.shape
    box[0] = box[2] = 1e9
    box[1] = box[3] = -1e9
    n, done = 1, 0
    world.queue[0] = row * columns + column
    found = 0
    words = world.pixels
    held = words[row, column]
    words[row, column] = np.uint64(0)
    world.group[0] = held
    while done < n:
        at = world.queue[done]
        word = world.group[done]
        done += 1
        found += count(word)
        r, c = at // columns, at % columns
        for y in range(8):
            for x in range(8):
                if word & world.bits[y, x]:
                    box[0] = min(box[0], (c << CELL_BITS) + x)
                    box[1] = max(box[1], (c << CELL_BITS) + x)
                    box[2] = min(box[2], (r << CELL_BITS) + y)
                    box[3] = max(box[3], (r << CELL_BITS) + y)
        for rr in range(max(r - 1, 0), min(r + 2, rows)):
            for cc in range(max(c - 1, 0), min(c + 2, columns)):
                if count(words[rr, cc]) >= least:
                    world.queue[n] = rr * columns + cc
                    world.group[n] = words[rr, cc]
                    words[rr, cc] = np.uint64(0)
                    n += 1
    return found


@step
def _touches(rules: Rules, world: World, box: Table) -> bool:
    """Whether a box lies close to an object: it is then a part of it that the object's gate will reach."""
    for i in range(len(world.objects)):
        if world.objects[i].alive:
            s = world.state[i]
            if (
                box[0] <= s[0, 0] + s[0, 2] + _NEAR * world.objects[i].gate
                and box[1] >= s[0, 0] - s[0, 2] - _NEAR * world.objects[i].gate
                and box[2] <= s[1, 0] + s[1, 2] + _NEAR * world.objects[i].gate
                and box[3] >= s[1, 0] - s[1, 2] - _NEAR * world.objects[i].gate
            ):
                return True
    return False


@step
def _edge(rules: Rules, box: Table) -> int:
    """The edge of the sensor that a box touches; if several, the one along which it is longest."""
    edge, most = -1, -1.0
    for k, near, along in (
        (0, box[0] < _EDGE_PX, box[3] - box[2]),
        (1, box[1] >= rules.width - _EDGE_PX, box[3] - box[2]),
        (2, box[2] < _EDGE_PX, box[1] - box[0]),
        (3, box[3] >= rules.height - _EDGE_PX, box[1] - box[0]),
    ):
        if near and along > most:
            edge, most = k, along
    return edge


@step
def _start(rules: Rules, world: World, i: int, box: Table, pixels: int, t_us: int) -> None:
    run = world.run[0]
    o = world.objects[i]
    o.alive = True
    o.gate = rules.gate_px
    o.track_id = -1
    o.supported_us = o.born_us = t_us
    o.enters = o.edge = _edge(rules, box)
    o.alone_us = 0
    o.support = pixels
    o.packet_events = pixels
    o.rate = pixels * rules.packet_us / rules.birth_us
    half_px = 0.25 * (box[1] - box[0] + box[3] - box[2])
    for axis in range(2):
        s, p = world.state[i, axis], world.cov[i, axis]
        s[0] = 0.5 * (box[2 * axis] + box[2 * axis + 1])
        s[1] = 0.0
        s[2] = max(0.5 * (box[2 * axis + 1] - box[2 * axis]), 1.0)
        s[3] = 0.0
        p[:] = 0.0
        p[0, 0] = p[2, 2] = _PLACE_PX * _PLACE_PX
        p[1, 1] = (rules.speed * half_px) ** 2
        p[3, 3] = (_GROWTH * rules.speed * half_px) ** 2
    world.profile[i] = 0.0
    world.total[i] = PROFILE * PROFILE
    run.live += 1


@step
def find_births(rules: Rules, world: World, t_us: int) -> None:
    """Start an object in each group of cells with enough pixels, and clear all cells."""
    run = world.run[0]
    rows, columns = world.pixels.shape
    box = world.group_box
    packets = rules.birth_us / rules.packet_us
    noise = run.clutter * 64.0 * packets
    least = max(_CELL_PIXELS, _ABOVE_NOISE * noise)
    alone, cells = 0, 0
    for row in range(rows):
        for column in range(columns):
            if world.near[row, column] == NOBODY:
                cells += 1
                alone += count(world.pixels[row, column])
            if count(world.pixels[row, column]) >= least:
                inside = world.near[row, column] == NOBODY
                found = _gather(world, row, column, box, least)
                if found >= rules.birth_pixels and not _touches(rules, world, box):
                    i = _free_slot(world)
                    if i >= 0:
                        _start(rules, world, i, box, found, t_us)
                        alone -= found if inside else 0
    world.pixels[:] = np.uint64(0)
    if cells:
        run.clutter += _CLUTTER_MIX * (max(alone, 0) / (cells * 64.0 * packets) - run.clutter)
