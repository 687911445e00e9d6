# SPDX-License-Identifier: Apache-2.0
"""End of a packet: correct every object, end those without support, merge parts of one object, report."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..._numba_private import step
from ...tracks.log import Kind
from ..kalman.motion import correct, predict
from .births import BIRTH_US, find_births, list_living
from .centroid import correct_by_centroid
from .layout import PROFILE, UNSET_US, Rules, World
from .outline import add_travel, clear_picture, fit_outline
from .sharing import prepare_packet
from .unity import are_one

__all__ = ["RECORDS_PER_PACKET", "close_packet", "open_packet"]

Table = NDArray[Any]

RECORDS_PER_PACKET = 3  # an object is born or moves, and ends
BORN, MOVED, MERGED, LOST = int(Kind.BORN), int(Kind.MOVED), int(Kind.MERGED), int(Kind.LOST)
PACKET_MIN_US, PACKET_MAX_US = 1_000, 5_000
_PACKETS = (1 << 31) - 1  # mask of a packet's number
_MIN_HALF_PX = 1.0
_COVERED_PATIENCE = 4.0  # factor of the coasting of an object hidden behind another
_RATE_MEAN = 0.15  # half sides of travel over which the rate is averaged
_LEAST_SUPPORT = 0.15  # of the usual rate
_ENTERED = 0.8
_EDGE_VARIANCE = 1.0
_EDGE_GATES = 2.0
_SPEED_KEEPS = 6.0  # half sides of travel for which an object's greatest speed counts
_SLOWEST = 0.5  # half sides per second: the least unit of velocity
_SETTLED = 3  # packets after which an object's first box is noted
_SIGNIFICANT = 2.5  # standard deviations of a velocity
_DETOUR = 4.0  # times the distance wanted, after which a new start is tried
_SLOW = 1.0  # half sides per second
_FARTHER = 4.0
_STRAIGHT = 0.5  # distance moved, as a part of the way
_STILL = 3.0  # half sides that it would travel, after which an object without motion is lost
_TENTATIVE_COAST = 0.5
_GROWTH_KEEPS = 2.0  # half sides of travel
_EMISSION = 0.2  # half sides that an object travels at least while it sends as many pixels as its picture fills
_FIT_EVERY = 0.15  # half sides of travel between two looks at a picture
_FAR_MORE = 4.0  # times the rate
_LEAST_CONTRAST = 2.0
_LEAVING_PATIENCE = 0.25  # factor of the coasting of an object at the edge on its way out


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
    row.confidence = o.travel / (o.travel + rules.visible_travel + 1e-9)
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
def _half(world: World, i: int) -> float:
    """The longer half side: an object's unit of length."""
    return float(max(world.state[i, 0, 2], world.state[i, 1, 2]))


@step
def _sure(world: World, i: int, of: int, sigmas: float) -> float:
    """The speed of an object's centre (1) or of its half sides (3) that is beyond its uncertainty."""
    s, p = world.state[i], world.cov[i]
    return float(max(np.hypot(s[0, of], s[1, of]) - sigmas * np.sqrt(p[0, of, of] + p[1, of, of]), 0.0))


@step
def _hidden(world: World, i: int, axis: int, high: int) -> bool:
    """Whether the middle of a side lies in another object's box, so that events beyond the side are ambiguous."""
    o = world.objects[i]
    sign = 1.0 if high else -1.0
    x = o.x + (sign * o.half_x if axis == 0 else 0.0)
    y = o.y + (sign * o.half_y if axis == 1 else 0.0)
    for at in range(world.run[0].live):
        k = world.slots[at]
        other = world.objects[k]
        if k != i and abs(x - other.x) <= other.half_x and abs(y - other.y) <= other.half_y:
            return True
    return False


@step
def _predict(rules: Rules, world: World, i: int, lasted_s: float) -> None:
    """Predict an object over the packet. One that touches another keeps its course, since events may be the other's."""
    o = world.objects[i]
    # A change of velocity by `agility` times the speed while the object travels a half side.
    walk = o.speed * np.sqrt(o.speed / _half(world, i))
    if o.meets:
        walk *= rules.meeting_agility
    for axis in range(2):
        predict(world.state[i, axis], world.cov[i, axis], lasted_s, walk * rules.agility, walk * rules.growth_agility)


@step
def _correct(rules: Rules, world: World, i: int, lasted_s: float) -> None:
    o = world.objects[i]
    noise_px = max(world.run[0].noise, 0.0) * lasted_s
    for axis in range(2):
        s, p = world.state[i, axis], world.cov[i, axis]
        noise = noise_px * 2.0 * world.state[i, 1 - axis, 2] * o.gate
        n = world.abreast[i, axis] - noise * (2.0 + 2.0 * s[2] / o.gate)
        if n <= 0.0:
            continue
        density = 1.0 / (2.0 * s[2])
        q = rules.quantile
        # How far the noise differs from place to place is not known: where it is more than the share it decides nothing.
        variance = rules.events_per_sample * q * (1.0 - q) / (n * density * density) * (1.0 + noise / (q * n)) ** 2
        for high in range(2):
            if _hidden(world, i, axis, high):
                continue
            sign = 1.0 if high else -1.0
            off = sign * ((world.beyond[i, axis, high] - noise) / n - q) / density
            correct(s, p, sign, off, variance)
        went = o.speed * lasted_s / _half(world, i)
        correct_by_centroid(rules, world, i, axis, n, noise * (2.0 + 2.0 * s[2] / o.gate), went)


@step
def _overlap(a: Any, b: Any) -> bool:
    """Whether the boxes of two objects touch."""
    return bool(abs(a.x - b.x) <= a.half_x + b.half_x and abs(a.y - b.y) <= a.half_y + b.half_y)


@step
def _meets(world: World, i: int) -> bool:
    """Whether another object's box touches this one's."""
    for at in range(world.run[0].live):
        k = world.slots[at]
        if k != i and world.objects[k].track_id >= 0 and _overlap(world.objects[i], world.objects[k]):
            return True
    return False


@step
def _covered(world: World, i: int) -> bool:
    """Whether another object's box holds the centre of this one."""
    o = world.objects[i]
    for at in range(world.run[0].live):
        k = world.slots[at]
        other = world.objects[k]
        if k != i and abs(o.x - other.x) <= other.half_x and abs(o.y - other.y) <= other.half_y:
            return True
    return False


@step
def _end(rules: Rules, world: World, out: Table, kind: int, t_us: int, i: int, other_id: int) -> None:
    if world.objects[i].track_id >= 0:
        _record(rules, world, out, kind, t_us, i, other_id)
    world.objects[i].alive = False


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
def _survives(a: Any, b: Any) -> bool:
    """Whether the first of two objects that are one keeps its name: it sends far more, or else is the older one."""
    if max(a.rate, b.rate) > _FAR_MORE * min(a.rate, b.rate):
        return bool(a.rate > b.rate)
    if (a.track_id >= 0) != (b.track_id >= 0):
        return bool(a.track_id >= 0)
    return bool(a.track_id < b.track_id) if a.track_id >= 0 else bool(a.born_us < b.born_us)


@step
def _merge(rules: Rules, world: World, out: Table, t_us: int) -> None:
    """Merge pairs of objects that are one: the first born survives, with a box around both."""
    n = world.run[0].live
    for at in range(n):
        i = world.slots[at]
        for after in range(at + 1, n):
            k = world.slots[after]
            if not (world.objects[i].alive and world.objects[k].alive and are_one(rules, world, i, k)):
                continue
            first, second = (k, i) if _survives(world.objects[k], world.objects[i]) else (i, k)
            for axis in range(2):
                into, gone = world.state[first, axis], world.state[second, axis]
                low = min(into[0] - into[2], gone[0] - gone[2])
                high = max(into[0] + into[2], gone[0] + gone[2])
                if axis == 0:
                    world.objects[first].first_x += 0.5 * (low + high) - into[0]
                else:
                    world.objects[first].first_y += 0.5 * (low + high) - into[0]
                into[0], into[2] = 0.5 * (low + high), 0.5 * (high - low)
            clear_picture(world, first)
            world.objects[first].support += world.objects[second].support
            _end(rules, world, out, MERGED, t_us, second, world.objects[first].track_id)


@step
def _outside(rules: Rules, world: World, i: int) -> bool:
    s = world.state[i]
    return bool(s[0, 0] < -0.5 or s[0, 0] > rules.width - 0.5 or s[1, 0] < -0.5 or s[1, 0] > rules.height - 0.5)


@step
def _leaves(rules: Rules, world: World, i: int) -> bool:
    """Whether an object's box reaches over an edge of the sensor towards which it moves."""
    for axis in range(2):
        s, size = world.state[i, axis], rules.width if axis == 0 else rules.height
        if (s[1] < 0.0 and s[0] - s[2] <= 0.0) or (s[1] > 0.0 and s[0] + s[2] >= size - 1.0):
            return True
    return False


@step
def _becomes_visible(rules: Rules, world: World, i: int, lasted_s: float) -> bool:
    """Whether an object has moved, more or less straight, by more than the uncertainty of its place: what flickers has not."""
    o = world.objects[i]
    s, p = world.state[i], world.cov[i]
    half = _half(world, i)
    v = np.hypot(s[0, 1], s[1, 1])
    # What is slow may be a place that flickers and drifts: it must go farther.
    wanted = max(rules.visible_travel * half * min(max(_SLOW * half / max(v, 1e-9), 1.0), _FARTHER), 1.0)
    wanted += np.sqrt(p[0, 0, 0] + p[1, 0, 0])
    if o.packets <= _SETTLED or o.path > _DETOUR * wanted:
        o.first_x, o.first_y, o.path = s[0, 0], s[1, 0], 0.0
        return False
    o.path += np.hypot(s[0, 1], s[1, 1]) * lasted_s
    moved = np.hypot(s[0, 0] - o.first_x, s[1, 0] - o.first_y)
    fast = v > _SIGNIFICANT * np.sqrt(p[0, 1, 1] + p[1, 1, 1])
    return bool(fast and moved >= wanted and moved >= _STRAIGHT * o.path)


@njit(cache=True, nogil=True)
def close_packet(rules: Rules, world: World, t_us: int, lasted_us: int, out: Table) -> None:
    """Process the events of a packet of length `lasted_us` at its end, `t_us`."""
    run = world.run[0]
    lasted_s = 1e-6 * lasted_us
    noise_px = max(run.noise, 0.0) * lasted_s
    for at in range(run.live):
        i = world.slots[at]
        o = world.objects[i]
        o.packets += 1
        o.meets = _meets(world, i)
        _predict(rules, world, i, lasted_s)
        _correct(rules, world, i, lasted_s)
        if o.enters >= 0:
            _keep_at_edge(rules, world, i)
        for axis in range(2):
            s = world.state[i, axis]
            if s[2] < _MIN_HALF_PX:
                s[2] = _MIN_HALF_PX
                s[3] = max(s[3], 0.0)
    for at in range(run.live):
        i = world.slots[at]
        o = world.objects[i]
        half = _half(world, i)
        state = world.state[i]
        v = _sure(world, i, 1, 1.0) + _sure(world, i, 3, 2.0)
        went = o.speed * lasted_s / half  # in the object's units
        o.still = 0.0 if v > 0.0 else o.still + went
        o.speed = max(v, o.speed * np.exp(-went / _SPEED_KEEPS), _SLOWEST * half)
        o.travel += v * lasted_s / half
        o.within = o.within + v * lasted_s / half if o.inside >= 0 else 0.0
        o.inside = -1
        noise = noise_px * (o.right - o.left) * (o.bottom - o.top)
        mix = min(went / _RATE_MEAN, 1.0)
        o.rate += mix * (max(o.weight - noise, 0.0) / max(lasted_s, 1e-9) - o.rate)
        o.usual += 0.1 * mix * (o.rate / o.speed - o.usual)
        background = max(run.noise, 0.0) * (o.right - o.left) * (o.bottom - o.top)
        least = max(o.speed * max(_LEAST_SUPPORT * o.usual, rules.full * 2.0 * half), background)
        if o.rate >= least and o.contrast >= _LEAST_CONTRAST:
            o.silent_us = 0
        else:
            o.silent_us += lasted_us
            state[0, 3] = state[1, 3] = 0.0
        for axis in range(2):
            state[axis, 3] *= np.exp(-went / _GROWTH_KEEPS)
        o.support += o.packet_events
        fade = np.exp(-went / rules.memory)
        if not o.meets:
            for k in range(PROFILE * PROFILE):
                world.profile[i, k] *= fade
            world.total[i] = 64.0 + fade * (world.total[i] - 64.0)
        seen = max(went, _EMISSION * max(o.weight - noise, 0.0) / o.area)
        add_travel(rules, world, i, seen, noise_px)
        o.unfitted += seen
        if o.unfitted >= _FIT_EVERY:
            o.unfitted = 0.0
            fit_outline(rules, world, i)
        patience = rules.coast * (_COVERED_PATIENCE if _covered(world, i) else 1.0 if o.track_id >= 0 else _TENTATIVE_COAST)
        if _leaves(rules, world, i):
            patience *= _LEAVING_PATIENCE
        if 1e-6 * o.silent_us * o.speed > patience * half or o.still > _STILL or _outside(rules, world, i):
            _end(rules, world, out, LOST, t_us, i, -1)
    list_living(world)
    _merge(rules, world, out, t_us)
    list_living(world)
    if t_us >= run.birth_end_us:
        find_births(rules, world, t_us)
        run.birth_end_us = t_us + BIRTH_US
    for at in range(run.live):
        i = world.slots[at]
        o = world.objects[i]
        if o.track_id >= 0:
            _record(rules, world, out, MOVED, t_us, i, -1)
        elif _becomes_visible(rules, world, i, lasted_s):
            o.track_id = run.births
            run.births += 1
            _record(rules, world, out, BORN, t_us, i, -1)


@step
def _next_packet_us(rules: Rules, world: World) -> int:
    """Length of the next packet: a small part of the time in which the fastest object travels its half side."""
    shortest = 1e-6 * PACKET_MAX_US
    for at in range(world.run[0].live):
        i = world.slots[at]
        o = world.objects[i]
        shortest = min(shortest, rules.step * _half(world, i) / o.speed)
    return max(int(1e6 * shortest), PACKET_MIN_US)


@step
def open_packet(rules: Rules, world: World, t_us: int, out: Table) -> bool:
    """Close the open packet and open the next; returns whether that one holds `t_us`."""
    run = world.run[0]
    if run.packet_end_us == UNSET_US:
        run.packet_end_us = t_us
        run.birth_end_us = t_us + BIRTH_US
    else:
        close_packet(rules, world, run.packet_end_us, run.packet_us, out)
        if run.live == 0 and t_us >= run.packet_end_us + PACKET_MAX_US:
            run.packet_end_us = t_us
    run.packet = (run.packet + 1) & _PACKETS
    run.settled = run.index
    run.packet_us = _next_packet_us(rules, world)
    run.packet_end_us += run.packet_us
    prepare_packet(rules, world)
    return bool(t_us < run.packet_end_us)
