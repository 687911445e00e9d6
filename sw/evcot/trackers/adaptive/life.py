# SPDX-License-Identifier: Apache-2.0
"""End of a packet: correct every object, end those without support, merge parts of one object, report."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import njit, step
from ...tracks.log import Kind
from .births import BIRTH_US, UNSEEN_HALVES, find_births, list_living
from .boxes import are_one, predict
from .layout import CELL_BITS, INSIDE, NEAR, NOBODY, UNSET_US, Rules, World
from .look import MIN_SPEED_HALVES_S, look

__all__ = ["RECORDS_PER_PACKET", "close_packet", "open_packet"]

Table = NDArray[Any]

RECORDS_PER_PACKET = 3  # an object is born or moves, and ends
BORN, MOVED, MERGED, LOST = int(Kind.BORN), int(Kind.MOVED), int(Kind.MERGED), int(Kind.LOST)
PACKET_MIN_US, PACKET_MAX_US = 1_000, 5_000
_PACKET_MASK = (1 << 31) - 1  # of a packet's number

# Thresholds. A "half" is the longer half side of an object's box, its unit of length. Values without a reason of their own were
# tuned on the seed sets 1, 2 and 21 (docs/defaults.md).

# How long an object without support is kept, as a factor of the setting `coast`.
_COVERED_PATIENCE = 4.0  # hidden behind another object
_TENTATIVE_PATIENCE = 0.5  # not visible yet
_LEAVING_PATIENCE = 0.25  # at the sensor's edge, on its way out

# Silence.
_REPORTED_HALVES = 0.3  # halves without support, for which it is still reported
_STOP_DECAY_HALVES = 0.5  # halves of expected travel in which the velocity of an object that stops falls to 37 %
_SILENT_HALVES_S = 2.0  # halves per second that count as travelled without support, at least: a slow object ends, too
_STILL_HALVES = 3.0  # halves of expected travel after which an object without significant motion is lost

# Visibility.
_SETTLED_PACKETS = 3  # packets after which an object's first box is noted
_PLACE_SIGMAS = 2.0  # standard deviations of its place that it must move beyond the wanted distance
_DETOUR_RATIO = 4.0  # path by wanted distance, after which it starts anew: what flickers wanders about
_SLOW_HALVES_S = 1.0  # halves per second; a slower object may be a place that flickers and drifts, and must go farther
_SLOW_TRAVEL_RATIO = 4.0  # how much farther, at most
_MIN_STRAIGHTNESS = 0.5  # distance by path

# Return of a track that was lost.
_RETURN_AFTER_HALVES = 1.0  # halves travelled, from which on an object may return
_ALONE_HALVES = 3.0  # halves between an object and others: what is found here later can be this one alone
_AWAY_HALVES = 16.0  # halves of expected travel until its return, at most

# State.
_MIN_HALF_PX = 1.0  # pixels: smaller objects have no measurable side
_MIN_GATE_PX = 2.0  # pixels around a box whose events belong to it, at least
_SPEED_DECAY_HALVES = 6.0  # halves of travel in which an object's greatest speed falls to 37 %
_GROWTH_DECAY_HALVES = 2.0  # the same for its growth, which is measured less well
_HEAVIER_RATIO = 4.0  # pixels of one object by those of another, from which on the heavier of two that are one survives
_MIN_CONTRAST = 2.0  # pixels per area in a box by those around it


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
def _meet(world: World, i: int) -> int:
    """List the objects whose gates touch this one's, in `world.meeting`; returns how many there are."""
    o, s = world.objects[i], world.state[i]
    n = 0
    for at in range(world.run[0].live):
        k = world.slots[at]
        other, other_o = world.state[k], world.objects[k]
        gate = o.gate + other_o.gate
        # What is not visible yet may be a part of this one: it hides nothing.
        if (
            k != i
            and other_o.away < 0
            and (other_o.track_id >= 0 or o.track_id < 0)
            and abs(s[0, 0] - other[0, 0]) <= s[0, 2] + other[0, 2] + gate
            and abs(s[1, 0] - other[1, 0]) <= s[1, 2] + other[1, 2] + gate
        ):
            world.meeting[n] = k
            n += 1
    return n


@step
def _covered(world: World, i: int) -> bool:
    """Whether another object's box holds the centre of this one."""
    s = world.state[i]
    for at in range(world.run[0].live):
        k = world.slots[at]
        other = world.state[k]
        seen = world.objects[k].track_id >= 0 and world.objects[k].missed < UNSEEN_HALVES and world.objects[k].away < 0
        if k != i and seen and abs(s[0, 0] - other[0, 0]) <= other[0, 2] and abs(s[1, 0] - other[1, 0]) <= other[1, 2]:
            return True
    return False


@step
def _alone(world: World, i: int) -> bool:
    """Whether no other visible object's box is near: what is found here later can be this one alone."""
    s = world.state[i]
    far = _ALONE_HALVES * _half(world, i)
    for at in range(world.run[0].live):
        k = world.slots[at]
        o, other = world.objects[k], world.state[k]
        if k == i or o.track_id < 0 or o.away >= 0:
            continue
        if (
            abs(s[0, 0] - other[0, 0]) <= s[0, 2] + other[0, 2] + far
            and abs(s[1, 0] - other[1, 0]) <= s[1, 2] + other[1, 2] + far
        ):
            return False
    return True


@step
def _end(rules: Rules, world: World, out: Table, kind: int, t_us: int, i: int, other_id: int) -> None:
    if world.objects[i].track_id >= 0:
        _record(rules, world, out, kind, t_us, i, other_id)
    world.objects[i].alive = False


@step
def _is_here(world: World, i: int) -> bool:
    """Whether an object lives, and is on the sensor."""
    return bool(world.objects[i].alive and world.objects[i].away < 0)


@step
def _survives(a: Any, b: Any) -> bool:
    """Whether the first of two objects that are one keeps its name: it shows far more, or else is the older one."""
    if max(a.mass, b.mass) > _HEAVIER_RATIO * min(a.mass, b.mass):
        return bool(a.mass > b.mass)
    if (a.track_id >= 0) != (b.track_id >= 0):
        return bool(a.track_id >= 0)
    return bool(a.track_id < b.track_id) if a.track_id >= 0 else bool(a.born_us < b.born_us)


@step
def _merge(rules: Rules, world: World, out: Table, t_us: int) -> None:
    """Merge pairs of objects that are one: the first born survives, with a box around both.

    A visible object that merges into one that is not visible yet is lost: there is no track that it could have merged into.
    """
    n = world.run[0].live
    for at in range(n):
        i = world.slots[at]
        for after in range(at + 1, n):
            k = world.slots[after]
            if not (_is_here(world, i) and _is_here(world, k) and are_one(rules, world, i, k)):
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
            world.objects[first].support += world.objects[second].support
            other_id = world.objects[first].track_id
            _end(rules, world, out, MERGED if other_id >= 0 else LOST, t_us, second, other_id)


@step
def _outside(rules: Rules, world: World, i: int) -> bool:
    s = world.state[i]
    return bool(s[0, 0] < -0.5 or s[0, 0] > rules.width - 0.5 or s[1, 0] < -0.5 or s[1, 0] > rules.height - 0.5)


@step
def _leaves(rules: Rules, world: World, i: int) -> int:
    """The edge of the sensor over which an object's box reaches and towards which it moves, as in `layout.OBJECT`; or -1."""
    for axis in range(2):
        s, size = world.state[i, axis], rules.width if axis == 0 else rules.height
        if s[1] < 0.0 and s[0] - s[2] <= 0.0:
            return 2 * axis
        if s[1] > 0.0 and s[0] + s[2] >= size - 1.0:
            return 2 * axis + 1
    return -1


@step
def _go_away(rules: Rules, world: World, out: Table, t_us: int, i: int, edge: int) -> None:
    """Let an object wait where it left the sensor, or stopped: what swings comes back. Its track is lost until then."""
    _record(rules, world, out, LOST, t_us, i, -1)
    world.objects[i].away = edge
    if edge != INSIDE:
        world.objects[i].missed = 0.0
    for axis in range(2):
        s, size = world.state[i, axis], rules.width if axis == 0 else rules.height
        s[0] = min(max(s[0], 0.0), size - 1.0)
        s[1] = s[3] = 0.0


@step
def _becomes_visible(rules: Rules, world: World, i: int, lasted_s: float) -> bool:
    """Whether an object has moved, more or less straight, by more than the uncertainty of its place: what flickers has not."""
    o = world.objects[i]
    s, p = world.state[i], world.cov[i]
    half = _half(world, i)
    v = np.hypot(s[0, 1], s[1, 1])
    # What is slow may be a place that flickers and drifts: it must go farther.
    wanted = max(rules.visible_travel * half * min(max(_SLOW_HALVES_S * half / max(v, 1e-9), 1.0), _SLOW_TRAVEL_RATIO), 1.0)
    wanted += _PLACE_SIGMAS * np.sqrt(p[0, 0, 0] + p[1, 0, 0])
    if o.packets <= _SETTLED_PACKETS or o.path > _DETOUR_RATIO * wanted:
        o.first_x, o.first_y, o.path = s[0, 0], s[1, 0], 0.0
        return False
    o.path += np.hypot(s[0, 1], s[1, 1]) * lasted_s
    moved = np.hypot(s[0, 0] - o.first_x, s[1, 0] - o.first_y)
    return bool(moved >= wanted and moved >= _MIN_STRAIGHTNESS * o.path)


@step
def _observe(rules: Rules, world: World, i: int, t_us: int) -> None:
    """Look at an object, and note whether it is there."""
    o, s = world.objects[i], world.state[i]
    mass = look(rules, world, i, _meet(world, i), t_us)
    if mass > 0.0 and o.contrast >= _MIN_CONTRAST:
        o.missed, o.lost_us = 0.0, 0
    else:
        s[0, 3] = s[1, 3] = 0.0
    o.unseen_us = 0
    for axis in range(2):
        if s[axis, 2] < _MIN_HALF_PX:
            s[axis, 2] = _MIN_HALF_PX
            s[axis, 3] = max(s[axis, 3], 0.0)


@step
def _advance(rules: Rules, world: World, i: int, lasted_s: float) -> None:
    """Move an object on by a packet."""
    o, s = world.objects[i], world.state[i]
    _predict(rules, world, i, lasted_s)
    half = _half(world, i)
    v = _sure(world, i, 1, 1.0) + _sure(world, i, 3, 2.0)
    went = o.speed * lasted_s / half  # in the object's units
    o.still = 0.0 if v > 0.0 else o.still + went
    o.speed = max(v, o.speed * np.exp(-went / _SPEED_DECAY_HALVES), MIN_SPEED_HALVES_S * half)
    o.travel += v * lasted_s / half
    o.within = o.within + v * lasted_s / half if o.inside >= 0 else 0.0
    o.inside = -1
    o.missed += max(np.hypot(s[0, 1], s[1, 1]) / half, _SILENT_HALVES_S) * lasted_s
    o.support += o.packet_events
    o.gate = max(_MIN_GATE_PX, 0.5 * rules.gate * (s[0, 2] + s[1, 2]))
    # What sends no events has stopped, or is hidden.
    keeps = np.exp(-went / _STOP_DECAY_HALVES) if o.missed > UNSEEN_HALVES and not _covered(world, i) else 1.0
    for axis in range(2):
        s[axis, 3] *= np.exp(-went / _GROWTH_DECAY_HALVES)
        s[axis, 1] *= keeps


@njit(cache=True, nogil=True)
def close_packet(rules: Rules, world: World, t_us: int, lasted_us: int, out: Table) -> None:
    """Process the events of a packet of length `lasted_us` at its end, `t_us`."""
    run = world.run[0]
    lasted_s = 1e-6 * lasted_us
    for at in range(run.live):
        i = world.slots[at]
        o = world.objects[i]
        o.packets += 1
        o.lost_us += lasted_us
        if o.away >= 0:
            o.missed += o.speed * lasted_s / _half(world, i)
            continue
        o.unseen_us += lasted_us
        _advance(rules, world, i, lasted_s)
        o.meets = _meet(world, i) > 0
    for at in range(run.live):
        i = world.slots[at]
        o = world.objects[i]
        if o.away >= 0:
            o.alive = o.missed <= _AWAY_HALVES
            continue
        if 1e-6 * o.unseen_us * o.speed >= rules.pause * _half(world, i):
            _observe(rules, world, i, t_us)
        patience = rules.coast
        if _covered(world, i):
            patience *= _COVERED_PATIENCE
        elif o.track_id < 0:
            patience *= _TENTATIVE_PATIENCE
        edge = _leaves(rules, world, i)
        if edge >= 0:
            patience *= _LEAVING_PATIENCE
        outside = _outside(rules, world, i)
        gone = o.missed > patience + rules.pause or outside
        returns = o.track_id >= 0 and o.travel >= _RETURN_AFTER_HALVES
        if gone and edge >= 0 and returns:
            _go_away(rules, world, out, t_us, i, edge)
        elif (gone or o.still > _STILL_HALVES) and returns and not outside and _alone(world, i):
            _go_away(rules, world, out, t_us, i, INSIDE)
        elif gone or o.still > _STILL_HALVES:
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
            if o.away < 0 and (o.missed <= _REPORTED_HALVES or _covered(world, i)):
                _record(rules, world, out, MOVED, t_us, i, -1)
        elif _becomes_visible(rules, world, i, lasted_s):
            kind = MOVED if o.name >= 0 else BORN  # a track is born once
            o.track_id = o.name if o.name >= 0 else run.births
            run.births += o.name < 0
            _record(rules, world, out, kind, t_us, i, -1)


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
def _prepare(rules: Rules, world: World) -> None:
    """Prepare the assignment of the open packet's events: each object's predicted box in mid-packet, and its cells."""
    world.near[:] = NOBODY
    middle_s = 0.5e-6 * world.run[0].packet_us
    for at in range(world.run[0].live):
        i = world.slots[at]
        o, s = world.objects[i], world.state[i]
        if o.away >= 0:
            continue
        o.x, o.y = s[0, 0] + middle_s * s[0, 1], s[1, 0] + middle_s * s[1, 1]
        o.half_x, o.half_y = s[0, 2], s[1, 2]
        o.packet_events = 0
        left, right = int(max(o.x - o.half_x - o.gate, 0.0)), int(min(o.x + o.half_x + o.gate + 1.0, rules.width - 1.0))
        top, bottom = int(max(o.y - o.half_y - o.gate, 0.0)), int(min(o.y + o.half_y + o.gate + 1.0, rules.height - 1.0))
        for row in range(top >> CELL_BITS, (bottom >> CELL_BITS) + 1):
            for column in range(left >> CELL_BITS, (right >> CELL_BITS) + 1):
                for k in range(NEAR):
                    if world.near[row, column, k] == NOBODY:
                        world.near[row, column, k] = i
                        break


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
    run.packet = (run.packet + 1) & _PACKET_MASK
    run.settled = run.index
    run.packet_us = _next_packet_us(rules, world)
    run.packet_end_us += run.packet_us
    _prepare(rules, world)
    return bool(t_us < run.packet_end_us)
