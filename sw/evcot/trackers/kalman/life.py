# SPDX-License-Identifier: Apache-2.0
"""End of a packet: correct every object, end those without support, merge parts of one object, report."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..._numba_private import step
from ...tracks.log import Kind
from .births import find_births
from .layout import UNSET_US, Rules, World
from .motion import correct, predict, turn_back
from .sharing import prepare_packet
from .splits import split
from .unity import are_one

__all__ = ["RECORDS_PER_PACKET", "close_packet", "open_packet"]

Table = NDArray[Any]

RECORDS_PER_PACKET = 3  # an object is born or moves, and ends
BORN, MOVED, MERGED, LOST = int(Kind.BORN), int(Kind.MOVED), int(Kind.MERGED), int(Kind.LOST)
_MIN_HALF_PX = 1.0
_COVERED_PATIENCE = 5  # factor of the coasting time of an object hidden behind another
_RATE_MEAN_US = 30_000.0
_LEAST_SUPPORT = 0.5  # of the rate at which an object is born
_ENTERED = 0.8
_EDGE_VARIANCE = 1.0
_EDGE_GATES = 2.0
_PROFILE_KEEPS_US = 100_000.0


@step
def _record(rules: Rules, world: World, out: Table, kind: int, t_us: int, i: int, other_id: int) -> None:
    run = world.run[0]
    o = world.objects[i]
    row = out[run.records]
    row.t_us = t_us
    row.event_index = run.index - 1 if kind != LOST else run.index
    row.kind = kind
    row.track_id = o.track_id
    row.slot = i
    row.x, half_x = _seen(world.state[i, 0], rules.width)
    row.y, half_y = _seen(world.state[i, 1], rules.height)
    row.radius = 0.5 * (half_x + half_y)
    row.width = 2.0 * half_x
    row.height = 2.0 * half_y
    row.angle = 0.0
    row.vx = world.state[i, 0, 1]
    row.vy = world.state[i, 1, 1]
    row.confidence = o.rate / (o.rate + rules.birth_pixels * rules.packet_us / rules.birth_us)
    row.n_ev = o.packet_events
    row.support = o.support
    row.other_id = other_id
    run.records += 1


@step
def _seen(s: Table, size: int) -> tuple[float, float]:
    """Centre and half side of the part of a box that lies on the sensor, along one axis."""
    low = min(max(s[0] - s[2], -0.5), size - 0.5)
    high = min(max(s[0] + s[2], -0.5), size - 0.5)
    return 0.5 * (low + high), 0.5 * (high - low)


@step
def _hidden(world: World, i: int, axis: int, high: int) -> bool:
    """Whether the middle of a side lies in another object's box, so that events beyond the side are ambiguous."""
    o = world.objects[i]
    sign = 1.0 if high else -1.0
    x = o.x + (sign * o.half_x if axis == 0 else 0.0)
    y = o.y + (sign * o.half_y if axis == 1 else 0.0)
    for at in range(world.run[0].listed):
        k = world.slots[at]
        other = world.objects[k]
        if k != i and other.alive and abs(x - other.x) <= other.half_x and abs(y - other.y) <= other.half_y:
            return True
    return False


@step
def _predict(rules: Rules, world: World, i: int, lasted_us: int) -> None:
    """Predict an object over the packet. One that touches another keeps its course, since events may be the other's."""
    walk = 0.5 * (world.state[i, 0, 2] + world.state[i, 1, 2])
    if world.objects[i].meets:
        walk *= rules.meeting_walk
    for axis in range(2):
        s, p = world.state[i, axis], world.cov[i, axis]
        predict(s, p, 1e-6 * lasted_us, walk * rules.velocity_walk, walk * rules.growth_walk)
        if rules.walls:
            turn_back(s, p, rules.width if axis == 0 else rules.height)


@step
def _correct(rules: Rules, world: World, i: int) -> None:
    v = np.hypot(world.state[i, 0, 1], world.state[i, 1, 1]) + 1e-9
    for axis in range(2):
        s, p = world.state[i, axis], world.cov[i, axis]
        other = world.state[i, 1 - axis, 2]
        noise = world.run[0].clutter * 2.0 * other * world.objects[i].gate
        n = world.abreast[i, axis] - noise * (2.0 + 2.0 * s[2] / world.objects[i].gate)
        if n <= 0.0:
            continue
        density = 1.0 / (2.0 * s[2])
        ahead = s[1] / v
        for high in range(2):
            if world.objects[i].meets and _hidden(world, i, axis, high):
                continue
            sign = 1.0 if high else -1.0
            q = rules.quantile + rules.afterglow * max(-sign * ahead, 0.0)
            variance = rules.events_per_sample * q * (1.0 - q) / (n * density * density)
            off = sign * ((world.beyond[i, axis, high] - noise) / n - q) / density
            correct(s, p, sign, off, variance)


@step
def _overlap(a: Any, b: Any) -> bool:
    """Whether the boxes of two objects touch."""
    return bool(abs(a.x - b.x) <= a.half_x + b.half_x and abs(a.y - b.y) <= a.half_y + b.half_y)


@step
def _meets(world: World, i: int) -> bool:
    """Whether another object's box touches this one's."""
    for at in range(world.run[0].listed):
        k = world.slots[at]
        if k != i and world.objects[k].alive and _overlap(world.objects[i], world.objects[k]):
            return True
    return False


@step
def _covered(world: World, i: int) -> bool:
    """Whether another object's box holds the centre of this one."""
    o = world.objects[i]
    for at in range(world.run[0].listed):
        k = world.slots[at]
        other = world.objects[k]
        if k != i and other.alive and abs(o.x - other.x) <= other.half_x and abs(o.y - other.y) <= other.half_y:
            return True
    return False


@step
def _end(rules: Rules, world: World, out: Table, kind: int, t_us: int, i: int, other_id: int) -> None:
    if world.objects[i].track_id >= 0:
        _record(rules, world, out, kind, t_us, i, other_id)
    world.objects[i].alive = False
    world.run[0].live -= 1


@step
def _keep_at_edge(rules: Rules, world: World, i: int) -> None:
    """Extend an entering object to the edge until it is about as long as it is wide."""
    o = world.objects[i]
    axis = o.enters >> 1
    s, p = world.state[i, axis], world.cov[i, axis]
    high = o.enters & 1
    sign = 1.0 if high else -1.0
    edge = ((rules.width if axis == 0 else rules.height) - 0.5) if high else -0.5
    away = edge - (s[0] + sign * s[2])
    if s[2] < _ENTERED * world.state[i, 1 - axis, 2]:
        correct(s, p, sign, away, _EDGE_VARIANCE)
    elif sign * away > _EDGE_GATES * o.gate:
        o.enters = -1


@step
def _merge(rules: Rules, world: World, out: Table, t_us: int) -> None:
    """Merge pairs of objects that are one: the first born survives, with a box around both."""
    for first in range(world.run[0].listed):
        i = world.slots[first]
        for second in range(world.run[0].listed):
            k = world.slots[second]
            a, b = world.objects[i], world.objects[k]
            if i == k or not (a.alive and b.alive and a.track_id < b.track_id and are_one(rules, world, i, k)):
                continue
            for axis in range(2):
                into, gone = world.state[i, axis], world.state[k, axis]
                low = min(into[0] - into[2], gone[0] - gone[2])
                high = max(into[0] + into[2], gone[0] + gone[2])
                into[0], into[2] = 0.5 * (low + high), 0.5 * (high - low)
            a.support += b.support
            _end(rules, world, out, MERGED, t_us, k, a.track_id)


@step
def _outside(rules: Rules, world: World, i: int) -> bool:
    s = world.state[i]
    return bool(s[0, 0] < -0.5 or s[0, 0] > rules.width - 0.5 or s[1, 0] < -0.5 or s[1, 0] > rules.height - 0.5)


@njit(cache=True, nogil=True)
def close_packet(rules: Rules, world: World, t_us: int, lasted_us: int, out: Table) -> None:
    """Process the events of a packet of length `lasted_us` at its end, `t_us`."""
    run = world.run[0]
    n = len(world.objects)
    mix = min(rules.packet_us / _RATE_MEAN_US, 1.0)
    least = _LEAST_SUPPORT * rules.birth_pixels * rules.packet_us / rules.birth_us
    fade = 1.0 - min(rules.packet_us / _PROFILE_KEEPS_US, 1.0)
    for i in range(n):
        if world.objects[i].alive:
            world.objects[i].meets = _meets(world, i)
            world.objects[i].alone_us += 0 if world.objects[i].meets else lasted_us
            _predict(rules, world, i, lasted_us)
            _correct(rules, world, i)
            if world.objects[i].enters >= 0:
                _keep_at_edge(rules, world, i)
            for axis in range(2):
                s = world.state[i, axis]
                if s[2] < _MIN_HALF_PX:
                    s[2] = _MIN_HALF_PX
                    s[3] = max(s[3], 0.0)
    for i in range(n):
        o = world.objects[i]
        if not o.alive:
            continue
        noise = run.clutter * (o.right - o.left) * (o.bottom - o.top)
        o.rate += mix * (max(o.weight - noise, 0.0) - o.rate)
        if o.rate >= least:
            o.supported_us = t_us
        o.support += o.packet_events
        if not o.meets:
            for part in range(world.profile.shape[1]):
                world.profile[i, part] *= fade
            world.total[i] = 64.0 + fade * (world.total[i] - 64.0)
        silent_us = t_us - o.supported_us
        patience = _COVERED_PATIENCE if o.meets and _covered(world, i) else 1
        if silent_us >= patience * rules.coast_us or _outside(rules, world, i):
            _end(rules, world, out, LOST, t_us, i, -1)
    _merge(rules, world, out, t_us)
    if t_us >= run.birth_end_us:
        for i in range(n):
            if world.objects[i].alive and world.objects[i].enters < 0 and not world.objects[i].meets:
                split(rules, world, i)
        find_births(rules, world, t_us)
        run.birth_end_us = t_us + rules.birth_us
    for i in range(n):
        o = world.objects[i]
        if not o.alive:
            continue
        if o.track_id < 0:
            o.track_id = run.births
            run.births += 1
            _record(rules, world, out, BORN, t_us, i, -1)
        else:
            _record(rules, world, out, MOVED, t_us, i, -1)


@step
def open_packet(rules: Rules, world: World, t_us: int, out: Table) -> bool:
    """Close the open packet and open the next; returns whether that one holds `t_us`."""
    run = world.run[0]
    if run.packet_end_us == UNSET_US:
        run.packet_end_us = t_us + rules.packet_us
        run.birth_end_us = t_us + rules.birth_us
    else:
        close_packet(rules, world, run.packet_end_us, rules.packet_us, out)
        run.packet_end_us += rules.packet_us
        if run.live == 0 and t_us >= run.packet_end_us:
            run.packet_end_us += (t_us - run.packet_end_us) // rules.packet_us * rules.packet_us + rules.packet_us
    prepare_packet(rules, world)
    return bool(t_us < run.packet_end_us)
