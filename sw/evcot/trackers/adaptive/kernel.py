# SPDX-License-Identifier: Apache-2.0
"""The loop over events."""

from __future__ import annotations

from typing import Any

from numba import njit
from numpy.typing import NDArray

from ..._numba_private import step
from .layout import CELL_BITS, NEAR, NOBODY, UNSET_US, Rules, World
from .life import RECORDS_PER_PACKET, open_packet
from .restless import epoch_of, rests

__all__ = ["feed"]

Table = NDArray[Any]


@step
def _away(o: Any, x: int, y: int) -> float:
    """The distance of a pixel from an object's middle, in half sides."""
    return float(max(abs(x - o.x) / o.half_x, abs(y - o.y) / o.half_y))


@step
def _owner(world: World, x: int, y: int) -> int:
    """The object in whose box or gate a pixel lies; of several, the one to whose middle it is closest in half sides."""
    near = world.near[y >> CELL_BITS, x >> CELL_BITS]
    owner = NOBODY
    for k in range(NEAR):
        i = near[k]
        if i == NOBODY:
            break
        o = world.objects[i]
        inside = abs(x - o.x) <= o.half_x + o.gate and abs(y - o.y) <= o.half_y + o.gate
        if inside and (owner == NOBODY or _away(o, x, y) < _away(world.objects[owner], x, y)):
            owner = i
    return owner


@njit(cache=True, nogil=True)
def feed(rules: Rules, world: World, ts: Table, xs: Table, ys: Table, begin: int, owner: Table, out: Table) -> int:
    """Track events from `begin` on until all are done or `out` could overflow; returns the number done."""
    run = world.run[0]
    seen, noted, first_us = world.seen, world.noted, run.first_us
    if run.packet_end_us == UNSET_US and len(ts) > begin:
        first_us = run.first_us = ts[begin]
    most = RECORDS_PER_PACKET * len(world.objects)
    end_us, index = run.packet_end_us, run.index
    for e in range(begin, len(ts)):
        t_us = ts[e]
        if t_us >= end_us:
            run.index = index
            while t_us >= run.packet_end_us:
                if run.records + most > len(out):
                    return e
                if open_packet(rules, world, t_us, out):
                    break
            end_us = run.packet_end_us
        x, y = int(xs[e]), int(ys[e])
        i = NOBODY
        index += 1
        if rests(noted, x, y, epoch_of(t_us, first_us)):
            seen[y, x] = t_us
            world.pixels[0, y >> CELL_BITS, x >> CELL_BITS] |= world.bits[y & 7, x & 7]
            if world.near[y >> CELL_BITS, x >> CELL_BITS, 0] != NOBODY:
                i = _owner(world, x, y)
                if i != NOBODY:
                    world.objects[i].packet_events += 1
        owner[e] = i
    run.index = index
    if len(ts) > begin:
        run.last_us = ts[-1]
    return len(ts)
