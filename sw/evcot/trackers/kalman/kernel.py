# SPDX-License-Identifier: Apache-2.0
"""The loop over events."""

from __future__ import annotations

from typing import Any

from numba import njit
from numpy.typing import NDArray

from .layout import NOBODY, Rules, World
from .life import RECORDS_PER_PACKET, open_packet
from .sharing import share

__all__ = ["feed"]

Table = NDArray[Any]


@njit(cache=True, nogil=True)
def feed(rules: Rules, world: World, ts: Table, xs: Table, ys: Table, begin: int, owner: Table, out: Table) -> int:
    """Track events from `begin` on until all are done or `out` could overflow; returns the number done."""
    run = world.run[0]
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
        x = int(xs[e])
        y = int(ys[e])
        owner[e] = NOBODY
        if t_us - world.accepted_us[y, x] >= rules.refractory_us:
            world.accepted_us[y, x] = t_us
            owner[e] = share(world, x, y)
        index += 1
    run.index = index
    if len(ts) > begin:
        run.last_us = ts[-1]
    return len(ts)
