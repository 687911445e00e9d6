# SPDX-License-Identifier: Apache-2.0
"""The loop over events."""

from __future__ import annotations

from typing import Any

from numba import njit
from numpy.typing import NDArray

from .layout import NOBODY, UNSET_US, Rules, World
from .life import RECORDS_PER_PACKET, open_packet
from .restless import epoch_of, rests
from .sharing import share

__all__ = ["feed"]

Table = NDArray[Any]


@njit(cache=True, nogil=True)
def feed(rules: Rules, world: World, ts: Table, xs: Table, ys: Table, begin: int, owner: Table, out: Table) -> int:
    """Track events from `begin` on until all are done or `out` could overflow; returns the number done."""
    run = world.run[0]
    seen, first_us = world.seen, run.first_us
    if run.packet_end_us == UNSET_US and len(ts) > begin:
        first_us = run.first_us = ts[begin]
    most = RECORDS_PER_PACKET * len(world.objects)
    end_us, packet, index = run.packet_end_us, run.packet, run.index
    for e in range(begin, len(ts)):
        t_us = ts[e]
        if t_us >= end_us:
            run.index = index
            while t_us >= run.packet_end_us:
                if run.records + most > len(out):
                    return e
                if open_packet(rules, world, t_us, out):
                    break
            end_us, packet = run.packet_end_us, run.packet
        x, y = xs[e], ys[e]
        owner[e] = NOBODY
        index += 1
        if rests(seen, x, y, epoch_of(t_us, first_us)):
            fresh = seen[y, x, 0] != packet
            seen[y, x, 0] = packet
            owner[e] = share(world, int(x), int(y), fresh)
    run.index = index
    if len(ts) > begin:
        run.last_us = ts[-1]
    return len(ts)
