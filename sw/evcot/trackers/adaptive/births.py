# SPDX-License-Identifier: Apache-2.0
"""New objects: groups of neighbouring cells with more different pixels than noise would send.

Pixels outside objects are collected in windows of six lengths, each twice as long as the one before, so that fast and slow
objects are found when they have moved by about the same distance. Pixels are counted, not events, so that a hot pixel counts
once.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import step
from ...bits import BYTES, bits_between, count
from .layout import CELL_BITS, INSIDE, LEVELS, NOBODY, Rules, World
from .look import NOISE_SIGMAS, look_at_group
from .restless import MANY_EMPTY, median_pixels, rate_of

__all__ = ["BIRTH_US", "UNSEEN_HALVES", "find_births", "list_living"]

Table = NDArray[Any]

BIRTH_US = 5_000  # the shortest window
_NOISE_WINDOW = 2  # number of the window in which the noise is measured: 20 ms
_NOISE_KNOWN_US = 2 * BIRTH_US << _NOISE_WINDOW  # until then there are no births

# Thresholds. A "half" is the longer half side of an object's box, its unit of length. Values without a reason of their own were
# tuned on the seed sets 1, 2 and 21 (docs/defaults.md).

# Groups of cells.
_NOISE_MIX = 0.2  # weight of one window in the measured noise
_MIN_CELL_PIXELS = 2.0  # pixels: fewer in a cell are noise
_MIN_CONTOUR_SHARE = 0.5  # share of a group's width and height that its pixels must number
_MAX_SENSOR_SHARE = 0.5  # share of the sensor: a group that covers more is no object
_NEAR_GATES = 1.0  # gates: anything closer to an object is a part of it that its gate will reach
_TRAIL_HALVES = 1.0  # halves behind an object in which pixels still fire

# State of a new object.
_MIN_DRIFT_HALVES = 0.8  # halves of drift of the pixels, from which on the drift gives the velocity
_DRIFT_SIGMAS = 3.0  # standard deviations that this drift must exceed
_PLACE_HALVES = 0.3  # halves: standard deviation of the sides
_GROWTH_SHARE = 0.3  # standard deviation of the growth of a half side, as a share of the speed

# Return of a track that was lost.
_EDGE_PX = 8.0  # pixels from the sensor's edge within which an object enters
UNSEEN_HALVES = 0.15  # halves without support, from which on an object is assumed to stop, or may be found again elsewhere
_FOLLOWS_HALVES = 1.0  # halves of travel, in which the rest of an object follows its centre over the edge
_FOUND_HALVES = 3.0  # halves between the places of loss and return
_SPEED_KNOWN_HALVES = 5.0  # halves travelled, from which on the speed extends that distance
_SPEED_RATIO = 1.5  # actual by noted speed, at most: the noted one leaves out what is uncertain
_FARTHEST_HALVES = 12.0  # halves by which the distance is extended, at most
_SIZE_RATIO = 3.5  # larger by smaller size


@step
def _free_slot(world: World) -> int:
    for i in range(len(world.objects)):
        if not world.objects[i].alive:
            return i
    return -1


@step
def list_living(world: World) -> None:
    """Bring the list of the living objects up to date."""
    n = 0
    for i in range(len(world.objects)):
        if world.objects[i].alive:
            world.slots[n] = i
            n += 1
    world.run[0].live = n


@step
def _gather(world: World, level: int, row: int, column: int, box: Table, least: float) -> tuple[int, int]:
    """Remove the connected group of cells that contains a cell; returns its pixels and cells, and its bounds in `box`."""
    words = world.pixels[level]
    rows, columns = words.shape
    box[0] = box[2] = 1e9
    box[1] = box[3] = -1e9
    n, done, found = 1, 0, 0
    world.queue[0] = row * columns + column
    world.group[0] = words[row, column]
    words[row, column] = np.uint64(0)
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
                if words[rr, cc] != np.uint64(0) and count(words[rr, cc]) >= least:
                    world.queue[n] = rr * columns + cc
                    world.group[n] = words[rr, cc]
                    words[rr, cc] = np.uint64(0)
                    n += 1
    return found, n


@step
def _is_seen(o: Any) -> bool:
    """Whether what is close to an object is its own: it was seen lately, or only its centre has left the sensor."""
    return bool(o.track_id < 0 or o.missed < (_FOLLOWS_HALVES if 0 <= o.away < INSIDE else UNSEEN_HALVES))


@step
def _touches(world: World, box: Table, window_s: float) -> bool:
    """Whether a box lies close to an object, or where one was in the window: it is a part of it, or of what it left behind."""
    for at in range(world.run[0].live):
        i = world.slots[at]
        o, s = world.objects[i], world.state[i]
        near = _is_seen(o)
        for axis in range(2):
            back = -s[axis, 1] * window_s
            if o.track_id >= 0 and o.speed > 0.0:
                back -= _TRAIL_HALVES * s[axis, 2] * s[axis, 1] / o.speed
            high = s[axis, 0] + s[axis, 2] + _NEAR_GATES * o.gate + max(back, 0.0)
            low = s[axis, 0] - s[axis, 2] - _NEAR_GATES * o.gate + min(back, 0.0)
            near = near and box[2 * axis] <= high and box[2 * axis + 1] >= low
        if near:
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
def _drift(world: World, box: Table, t_us: int, window_us: int) -> float:
    """The speed at which a new group moves, px/s: of a line through the places of its pixels over the times of their events;
    or 0 if it may be chance."""
    n, times, squares = 0.0, 0.0, 0.0
    xs, ys, txs, tys, places = 0.0, 0.0, 0.0, 0.0, 0.0
    middle_x, middle_y = 0.5 * (box[0] + box[1]), 0.5 * (box[2] + box[3])
    for y in range(int(box[2]), int(box[3]) + 1):
        for x in range(int(box[0]), int(box[1]) + 1):
            ago_s = 1e-6 * (t_us - world.seen[y, x])
            if ago_s > 1e-6 * window_us:
                continue
            dx, dy = x - middle_x, y - middle_y
            n += 1.0
            times -= ago_s
            squares += ago_s * ago_s
            xs += dx
            ys += dy
            txs -= ago_s * dx
            tys -= ago_s * dy
            places += dx * dx + dy * dy
    if n <= 2.0:
        return 0.0
    spread = squares - times * times / n
    along_x, along_y = txs - times * xs / n, tys - times * ys / n
    if spread <= 0.0:
        return 0.0
    rest = places - (xs * xs + ys * ys) / n - (along_x * along_x + along_y * along_y) / spread
    drift = np.hypot(along_x, along_y) / spread
    return float(drift) if drift > _DRIFT_SIGMAS * np.sqrt(max(rest, 0.0) / ((n - 2.0) * spread)) else 0.0


@step
def _start(rules: Rules, world: World, i: int, box: Table, pixels: int, t_us: int, window_us: int) -> None:
    o = world.objects[i]
    o.alive = True
    o.track_id = o.name = -1
    o.born_us = t_us
    o.packets = 0
    # What is there when the stream begins has not entered.
    begins = t_us - world.run[0].first_us <= _NOISE_KNOWN_US
    o.edge = -1 if begins else _edge(rules, box)
    o.travel = o.within = o.path = o.still = o.missed = 0.0
    o.inside = o.away = -1
    o.meets = False
    o.apart = 0
    o.unseen_us = o.lost_us = 0
    o.contrast = np.inf
    o.mass = pixels
    o.support = pixels
    o.packet_events = pixels
    half_px = max(0.25 * (box[1] - box[0] + box[3] - box[2]), 1.0)
    o.speed = rules.birth_speed * half_px / (1e-6 * window_us)
    if begins and _edge(rules, box) < 0:
        # It was not looked for in shorter windows: it may be so fast that its picture is drawn out.
        drift = _drift(world, box, t_us, window_us)
        if 1e-6 * window_us * drift >= _MIN_DRIFT_HALVES * half_px:
            o.speed = max(o.speed, drift)
    o.usual = pixels / (1e-6 * window_us) / o.speed
    o.gate = rules.gate * half_px
    for axis in range(2):
        s, p = world.state[i, axis], world.cov[i, axis]
        s[0] = 0.5 * (box[2 * axis] + box[2 * axis + 1])
        s[1] = 0.0
        s[2] = max(0.5 * (box[2 * axis + 1] - box[2 * axis]), 1.0)
        s[3] = 0.0
        p[:] = 0.0
        p[0, 0] = p[2, 2] = (_PLACE_HALVES * half_px) ** 2
        p[1, 1] = o.speed**2
        p[3, 3] = (_GROWTH_SHARE * o.speed) ** 2


@step
def _find_again(rules: Rules, world: World, box: Table) -> int:
    """The object without support that lies closest to a new group, and is as large, if it can have come there; or -1.

    One that has left the sensor returns over the same edge.
    """
    best, least = -1, 1.0
    edge = _edge(rules, box)
    width, height = box[1] - box[0] + 1.0, box[3] - box[2] + 1.0
    for at in range(world.run[0].live):
        i = world.slots[at]
        o, s = world.objects[i], world.state[i]
        if _is_seen(o) or (0 <= o.away < INSIDE and o.away != edge):
            continue
        half = max(s[0, 2], s[1, 2])
        ratio = (width + height) / (2.0 * (s[0, 2] + s[1, 2]))
        away = max(abs(0.5 * (box[0] + box[1]) - s[0, 0]), abs(0.5 * (box[2] + box[3]) - s[1, 0]))
        within = half * (_FOUND_HALVES if o.away >= 0 else _FOUND_HALVES + o.missed)
        if o.travel >= _SPEED_KNOWN_HALVES:
            within += min(1e-6 * o.lost_us * _SPEED_RATIO * o.speed, _FARTHEST_HALVES * half)
        away /= within
        enters = 0 <= o.away < INSIDE  # as far as its edge cuts it off, it may be small
        if (enters or ratio > 1.0 / _SIZE_RATIO) and ratio < _SIZE_RATIO and away < least:
            best, least = i, away
    return best


@step
def _resume(world: World, i: int, box: Table) -> None:
    """Let an object go on where it was found again."""
    o, s, p = world.objects[i], world.state[i], world.cov[i]
    if o.away >= 0:
        o.travel = o.within = 0.0
        o.edge = o.away if o.away < INSIDE else -1
    if o.away == INSIDE:
        o.name, o.track_id, o.packets, o.path = o.track_id, -1, 0, 0.0
    o.missed, o.still, o.unseen_us, o.lost_us, o.apart, o.away = 0.0, 0.0, 0, 0, 0, -1
    half = max(s[0, 2], s[1, 2])
    for axis in range(2):
        s[axis, 0] = 0.5 * (box[2 * axis] + box[2 * axis + 1])
        s[axis, 2] = max(0.5 * (box[2 * axis + 1] - box[2 * axis]), 1.0)
        s[axis, 1] = s[axis, 3] = 0.0
        p[axis] = 0.0
        p[axis, 0, 0] = p[axis, 2, 2] = (_PLACE_HALVES * half) ** 2
        p[axis, 1, 1] = o.speed**2
        p[axis, 3, 3] = (_GROWTH_SHARE * o.speed) ** 2


@step
def _sweep(world: World) -> None:
    """Remove the pixels in objects' boxes and gates."""
    rows, columns = world.pixels.shape[1:]
    for at in range(world.run[0].live):
        i = world.slots[at]
        s, gate = world.state[i], world.objects[i].gate
        if not _is_seen(world.objects[i]):
            continue
        left, right = int(s[0, 0] - s[0, 2] - gate), int(s[0, 0] + s[0, 2] + gate)
        top, bottom = int(s[1, 0] - s[1, 2] - gate), int(s[1, 0] + s[1, 2] + gate)
        for row in range(max(top, 0) >> CELL_BITS, min((bottom >> CELL_BITS) + 1, rows)):
            y0, y1 = max(top - (row << CELL_BITS), 0), min(bottom - (row << CELL_BITS), 7)
            for column in range(max(left, 0) >> CELL_BITS, min((right >> CELL_BITS) + 1, columns)):
                x0, x1 = max(left - (column << CELL_BITS), 0), min(right - (column << CELL_BITS), 7)
                outside = ~(bits_between(x0, x1) * BYTES & bits_between(8 * y0, 8 * y1 + 7))
                for level in range(LEVELS):
                    world.pixels[level, row, column] &= outside


@step
def _measure_noise(world: World, level: int, window_us: int) -> None:
    """Update the background's rate from the cells far from objects: from the empty ones, or the median if few are empty."""
    run = world.run[0]
    rows, columns = world.pixels.shape[1:]
    world.counts[:] = 0
    cells = 0
    for row in range(rows):
        for column in range(columns):
            if world.near[row, column, 0] == NOBODY:
                world.counts[count(world.pixels[level, row, column])] += 1
                cells += 1
    if cells < 16:
        return
    empty = world.counts[0]
    mean = -np.log(empty / cells) if empty >= MANY_EMPTY * cells else median_pixels(world.counts, cells)
    rate = rate_of(mean, 1e-6 * window_us)
    run.noise = rate if run.noise < 0.0 else run.noise + _NOISE_MIX * (rate - run.noise)


@step
def find_births(rules: Rules, world: World, t_us: int) -> None:
    """Start an object in each group of cells with enough pixels, in every window that ends now, and begin these anew."""
    run = world.run[0]
    rows, columns = world.pixels.shape[1:]
    box = world.group_box
    run.birth_tick += 1
    _sweep(world)
    for level in range(LEVELS):
        if run.birth_tick % (1 << level):
            break
        window_us = BIRTH_US << level
        if level == _NOISE_WINDOW:
            _measure_noise(world, level, window_us)
        known = run.noise >= 0.0
        mean = 64.0 * (1.0 - np.exp(-1e-6 * window_us * max(run.noise, 0.0)))
        least = max(_MIN_CELL_PIXELS, mean + NOISE_SIGMAS * np.sqrt(mean) + (1.0 if mean > 0.2 else 0.0))
        if level + 1 < LEVELS:
            for row in range(rows):
                for column in range(columns):
                    world.pixels[level + 1, row, column] |= world.pixels[level, row, column]
        for row in range(rows if known else 0):
            for column in range(columns):
                if count(world.pixels[level, row, column]) < least:
                    continue
                found, cells = _gather(world, level, row, column, box, least)
                if found < rules.birth_pixels + cells * least or cells >= _MAX_SENSOR_SHARE * rows * columns:
                    continue
                born = 0
                parts = world.parts
                n = look_at_group(rules, world, box, t_us, 1e-6 * window_us)
                for k in range(n):
                    for edge in range(4):
                        box[edge] = parts[k, edge >> 1, edge & 1]
                    width, height = box[1] - box[0] + 1.0, box[3] - box[2] + 1.0
                    noise = width * height * mean / 64.0
                    mass = parts[k, 2, 0] - noise - NOISE_SIGMAS * np.sqrt(noise)
                    if mass < max(rules.birth_pixels, _MIN_CONTOUR_SHARE * (width + height)) or _touches(
                        world, box, 1e-6 * window_us
                    ):
                        continue
                    i = _find_again(rules, world, box)
                    if i >= 0:
                        _resume(world, i, box)
                        born += 1
                        continue
                    i = _free_slot(world)
                    if i >= 0:
                        _start(rules, world, i, box, int(parts[k, 2, 0]), t_us, window_us)
                        born += 1
                if born > 0:
                    list_living(world)
                    for k in range(cells):
                        for above in range(level + 1, LEVELS):
                            world.pixels[above, world.queue[k] // columns, world.queue[k] % columns] = np.uint64(0)
        world.pixels[level] = np.uint64(0)
