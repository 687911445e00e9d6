# SPDX-License-Identifier: Apache-2.0
"""A look at an object: the connected groups of pixels that sent events lately, moved to where they are now.

Each pixel's last event is moved on by the object's velocity, and away from its centre by its growth, for the time since then.
So a look takes in what sent events while the object travelled some of its half side, weak edges among them, and yet is as sharp
as the velocity is known. In bins of about a twelfth of the half side, it falls into parts that do not touch. Those in the box
are the object; they give its sides.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import step
from ...bits import lowest, without_lowest
from .bins import NO_BINS, clear, fill, find_parts, pixels_in, smooth, span
from .boxes import are_parts, correct
from .layout import BINS, CELL_BITS, NOBODY, Rules, World

__all__ = ["MIN_SPEED_HALVES_S", "NOISE_SIGMAS", "look", "look_at_group"]

Table = NDArray[Any]

# Thresholds. A "half" is the longer half side of an object's box, its unit of length. Values without a reason of their own were
# tuned on the seed sets 1, 2 and 21 (docs/defaults.md).

# How far back a measurement reads.
MIN_SPEED_HALVES_S = 0.5  # halves per second: the least unit of velocity; else the window of an object at rest would never end
_MIN_PACE_SHARE = 0.3  # share of an object's greatest speed, likewise: an object that turns does not stand for long
_WINDOW_MIN_S, _WINDOW_MAX_S = 2e-3, 0.4  # seconds: below, an edge has sent too few events; above, the velocity is too old
_MAX_NOISE_PER_PIXEL = 0.2  # events of noise per pixel in the window: beyond, noise hides the object's contour
_LATE_HALVES = 0.1  # halves of travel: the later part of a window, or its later half if that is longer
_MIN_LATE_SHARE = 0.25  # share of the pixels in the later part; with fewer, the object has left the place

# Bins.
_MARGIN_HALVES, _MARGIN_PX = 0.5, 3.0  # around the box, in halves and at least in pixels: a side may have moved
_BINS_PER_HALF = 12.0  # bins: finer ones hold too few pixels for a level
_LINK_BINS = 2  # bins: what is closer touches
_MIN_CELL_PIXELS = 2.0  # pixels in 3 x 3 bins
NOISE_SIGMAS = 3.0  # standard deviations of the noise's count, above which pixels are an object's

# Parts of an object.
_MIN_PART_SHARE = 0.03  # share of all pixels: a smaller part is noise
_MIN_PART_PIXELS = 4.0  # pixels, likewise
_INSIDE_SHARE = 0.5  # share of a part's pixels that lie in the box
_CLOSE_HALVES = 0.15  # halves: a part so close to the box is the object's, wherever it lies
_LIGHTER_SHARE = 0.3  # share of another group's pixels: a lighter group may be a part of that one, wherever it lies
_MIN_HELD_SHARE = 0.2  # share of the object's pixels that its box must hold, or the box has lost the object
_MIN_DIVIDED_SHARE = 0.2  # share of the pixels that each of two objects in one box must have
_GAP_SLACK = 1.25  # factor of the setting `gap`, up to which two groups may still be one object
_DIVIDE_AFTER = 5  # measurements in a row that show two objects

# Support, sides and the usual number of pixels.
_MIN_SUPPORT_SHARE = 0.15  # share of the object's usual number of pixels
_SIZE_KNOWN_HALVES = 3.0  # halves travelled, from which on few pixels say little about the size
_JUMP_SIGMAS = 4.0  # standard deviations of a side's offset, from which on another part has appeared and nothing has moved
_BORDER_PX = 1.5  # pixels from the sensor's edge within which a side may be cut off by the edge
_CUT_OFF_PX = 1.0  # pixels by which such a side must lie within its expected place to count as cut off
_USUAL_MIX = 0.2  # weight of one measurement in the usual number of pixels


@step
def _pace(world: World, i: int) -> float:
    """The speed by which an object's looks are timed, px/s."""
    s = world.state[i]
    return float(
        max(np.hypot(s[0, 1], s[1, 1]), _MIN_PACE_SHARE * world.objects[i].speed, MIN_SPEED_HALVES_S * max(s[0, 2], s[1, 2]))
    )


@step
def _window_s(rules: Rules, world: World, i: int) -> float:
    """How far back a look goes."""
    o, s, p = world.objects[i], world.state[i], world.cov[i]
    half, speed = max(s[0, 2], s[1, 2]), _pace(world, i)
    unsure = np.sqrt(p[0, 1, 1] + p[1, 1, 1])
    enough_s = rules.fill * 2.0 * (s[0, 2] + s[1, 2]) / max(o.usual * speed, 1e-9)
    window_s = min(enough_s, rules.memory * half / speed, rules.blur * half / max(unsure, 1e-9), _WINDOW_MAX_S)
    window_s = min(window_s, _MAX_NOISE_PER_PIXEL / max(world.run[0].noise, 1e-9))
    return float(max(window_s, _WINDOW_MIN_S))


@step
def _of_another(world: World, i: int, n: int, x: float, y: float) -> bool:
    """Whether a place lies closer, in half sides, to one of `n` objects that this one meets."""
    s = world.state[i]
    for k in range(n):
        other, gate = world.state[world.meeting[k]], world.objects[world.meeting[k]].gate
        dx, dy = abs(x - other[0, 0]), abs(y - other[1, 0])
        if dx < other[0, 2] + gate and dy < other[1, 2] + gate:
            own = max(abs(x - s[0, 0]) / s[0, 2], abs(y - s[1, 0]) / s[1, 2])
            if max(dx / other[0, 2], dy / other[1, 2]) < own:
                return True
    return False


@step
def _lately(world: World, y: int, begin: int, end: int, since_us: int) -> Any:
    """The pixels of a row, up to 64 from `begin` on, that have sent an event since then: a bit each."""
    row, word = world.seen[y, begin:end], np.uint64(0)
    for k in range(len(row)):
        word |= np.uint64(row[k] >= since_us) << np.uint64(k)
    return word


@step
def _collect(rules: Rules, world: World, i: int, t_us: int, window_s: float, bin_px: int, reach: Table, n: int) -> float:
    """Fill the bins; returns the share of the pixels in the box that sent an event lately."""
    s = world.state[i]
    clear(world)
    since_us = t_us - int(1e6 * window_s)
    first = world.rest
    for axis in range(2):
        size = rules.width if axis == 0 else rules.height
        back = -s[axis, 1] * window_s
        wider = max(-s[axis, 3] * window_s, 0.0)
        first[axis, 0] = max(s[axis, 0] - reach[axis] - wider + min(back, 0.0), 0.0)
        first[axis, 1] = min(s[axis, 0] + reach[axis] + wider + max(back, 0.0), size - 1.0)
    inside, late = 1e-9, 0.0
    late_s = max(0.5 * window_s, _LATE_HALVES * max(s[0, 2], s[1, 2]) / _pace(world, i))
    # Read once: what is written to the bins could be the same memory, for all the compiler knows.
    (at_x, vx, half_x), (at_y, vy, half_y) = (s[0, 0], s[0, 1], s[0, 2]), (s[1, 0], s[1, 1], s[1, 2])
    grow_x, grow_y = s[0, 3] / half_x, s[1, 3] / half_y
    reach_x, reach_y = reach[0], reach[1]
    left, right = int(np.ceil(first[0, 0])), int(first[0, 1]) + 1
    for y in range(int(np.ceil(first[1, 0])), int(first[1, 1]) + 1):
        for begin in range(left, right, 64):
            word = _lately(world, y, begin, min(begin + 64, right), since_us)
            while word != NO_BINS:
                x = begin + int(lowest(word))
                word = without_lowest(word)
                ago_s = 1e-6 * (t_us - world.seen[y, x])
                dx = (x - at_x + vx * ago_s) * (1.0 + min(max(grow_x * ago_s, -0.5), 1.0))
                dy = (y - at_y + vy * ago_s) * (1.0 + min(max(grow_y * ago_s, -0.5), 1.0))
                if abs(dx) >= reach_x or abs(dy) >= reach_y:
                    continue
                if n > 0 and _of_another(world, i, n, at_x + dx, at_y + dy):
                    continue
                fill(world, int((dy + reach_y) / bin_px), int((dx + reach_x) / bin_px))
                if abs(dx) <= half_x and abs(dy) <= half_y:
                    inside += 1.0
                    late += 1.0 if ago_s <= late_s else 0.0
    return late / inside


@step
def look_at_group(rules: Rules, world: World, box: Table, t_us: int, window_s: float) -> int:
    """Find the parts of a group of cells with bounds `box` (left, right, top, bottom), in `world.parts`: now in pixels.

    Returns how many there are; those too small have no pixels.
    """
    half, middle, parts, reach = world.bounds[0], world.bounds[1], world.parts, world.line[0]
    bin_px = 1
    for axis in range(2):
        half[axis] = 0.5 * (box[2 * axis + 1] - box[2 * axis]) + 0.5
        middle[axis] = 0.5 * (box[2 * axis + 1] + box[2 * axis])
    while max(half[0], half[1]) >= 0.5 * BINS * bin_px:
        bin_px += 1
    left, right = max(int(box[0]), 0), min(int(box[1]), rules.width - 1)
    top, bottom = max(int(box[2]), 0), min(int(box[3]), rules.height - 1)
    columns, rows = (right - left) // bin_px + 1, (bottom - top) // bin_px + 1
    clear(world)
    since_us = t_us - int(1e6 * window_s)
    for y in range(top, bottom + 1):
        for x in range(left, right + 1):
            if world.seen[y, x] >= since_us and world.near[y >> CELL_BITS, x >> CELL_BITS, 0] == NOBODY:
                fill(world, (y - top) // bin_px, (x - left) // bin_px)
    smooth(world, rows, columns)
    noise = bin_px * bin_px * (1.0 - np.exp(-max(world.run[0].noise, 0.0) * window_s))
    mean = 9.0 * noise
    level = max(_MIN_CELL_PIXELS, mean + NOISE_SIGMAS * np.sqrt(mean))
    reach[0] = reach[1] = 0.0
    half[0] = half[1] = 1e9
    n = find_parts(world, level, rows, half, reach, bin_px, max(2 // bin_px, 1) + 1)
    for k in range(n):
        parts[k, 0, 0], parts[k, 0, 1] = left + parts[k, 0, 0] * bin_px, left + parts[k, 0, 1] * bin_px - 1
        parts[k, 1, 0], parts[k, 1, 1] = top + parts[k, 1, 0] * bin_px, top + parts[k, 1, 1] * bin_px - 1
    return n


@step
def _level(rules: Rules, world: World, i: int, noise: float, bin_px: int, reach: Table, rows: int) -> float:
    """Pixels in 3 x 3 bins from which they belong to an object."""
    s = world.state[i]
    total, square = 0.0, 0.0
    for y in range(rows):
        if abs((y + 0.5) * bin_px - reach[1]) > s[1, 2]:
            continue
        row = world.filled[y]
        while row != NO_BINS:
            x = int(lowest(row))
            row = without_lowest(row)
            if abs((x + 0.5) * bin_px - reach[0]) <= s[0, 2]:
                total += world.bins[y, x]
                square += world.bins[y, x] * world.around[y, x]
    mean = 9.0 * noise
    level = max(_MIN_CELL_PIXELS, mean + NOISE_SIGMAS * np.sqrt(mean))
    if total > 0.0:
        level = max(level, rules.dense * square / total)
    return float(level)


@step
def _between(a: Table, b: Table) -> float:
    """The gap between two boxes, (2, 2) middle and half side by axis; negative if they overlap."""
    return float(max(abs(a[0, 0] - b[0, 0]) - a[0, 1] - b[0, 1], abs(a[1, 0] - b[1, 0]) - a[1, 1] - b[1, 1]))


@step
def _join_groups(rules: Rules, world: World, n: int, close: float) -> bool:
    """Join two groups of parts that may be one object; returns whether there were two such. See `_divide`."""
    groups, group_of = world.groups, world.group_of
    for a in range(n):
        if groups[a, 2, 0] == 0.0:
            continue
        for b in range(a + 1, n):
            if groups[b, 2, 0] == 0.0:
                continue
            lighter = min(groups[a, 2, 0], groups[b, 2, 0]) < _LIGHTER_SHARE * max(groups[a, 2, 0], groups[b, 2, 0])
            if not (lighter and _between(groups[a], groups[b]) <= close) and not are_parts(
                groups[a], groups[b], _GAP_SLACK * rules.gap, rules.elongation
            ):
                continue
            for axis in range(2):
                low = min(groups[a, axis, 0] - groups[a, axis, 1], groups[b, axis, 0] - groups[b, axis, 1])
                high = max(groups[a, axis, 0] + groups[a, axis, 1], groups[b, axis, 0] + groups[b, axis, 1])
                groups[a, axis, 0], groups[a, axis, 1] = 0.5 * (low + high), 0.5 * (high - low)
            groups[a, 2, 0] += groups[b, 2, 0]
            groups[b, 2, 0] = 0.0
            for k in range(n):
                if group_of[k] == b:
                    group_of[k] = a
            return True
    return False


@step
def _divide(rules: Rules, world: World, n: int, close: float) -> bool:
    """Whether the parts are two objects: groups that cannot be one, each with its share; leaves out all but the heaviest.

    Parts that do not count have no pixels.

    Args:
        close: bins between a group and a much lighter one that belongs to it, wherever it lies.
    """
    parts, groups, group_of = world.parts, world.groups, world.group_of
    total = 0.0
    for k in range(n):
        group_of[k] = k
        for axis in range(2):
            groups[k, axis, 0] = 0.5 * (parts[k, axis, 0] + parts[k, axis, 1])
            groups[k, axis, 1] = 0.5 * (parts[k, axis, 1] - parts[k, axis, 0])
        groups[k, 2, 0] = parts[k, 2, 0]
        total += parts[k, 2, 0]
    while _join_groups(rules, world, n, close):
        pass
    best, second = 0, 0.0
    for k in range(1, n):
        if groups[k, 2, 0] > groups[best, 2, 0]:
            best = k
    for k in range(n):
        if k != best:
            second = max(second, groups[k, 2, 0])
    if second < _MIN_DIVIDED_SHARE * total:
        return False
    for k in range(n):
        if group_of[k] != best:
            parts[k, 2, 0] = 0.0
    return True


@step
def _choose(rules: Rules, world: World, i: int, n: int, bin_px: int, reach: Table) -> float:
    """Leave out the parts that are not the object's: their pixels become none. Returns the pixels of the others.

    Its parts are those in the box, and those beside it that may be of one object with it.
    """
    parts, state = world.parts, world.state[i]
    one, other = world.whole, world.rest
    total, left = 0.0, 0.0
    for k in range(n):
        total += parts[k, 2, 1]
    for axis in range(2):
        one[axis, 0], one[axis, 1] = reach[axis], state[axis, 2]
    for k in range(n):
        mass, inside = parts[k, 2, 0], parts[k, 2, 1]
        belongs = inside >= _INSIDE_SHARE * mass
        if not belongs:
            for axis in range(2):
                other[axis, 0] = 0.5 * (parts[k, axis, 0] + parts[k, axis, 1]) * bin_px
                other[axis, 1] = 0.5 * (parts[k, axis, 1] - parts[k, axis, 0]) * bin_px
            belongs = _between(one, other) <= _CLOSE_HALVES * max(state[0, 2], state[1, 2])
            belongs = belongs or are_parts(one, other, rules.gap, rules.elongation)
        if not belongs or mass < max(_MIN_PART_SHARE * total, _MIN_PART_PIXELS):
            parts[k, 2, 0] = 0.0
        left += parts[k, 2, 0]
    return left if total >= _MIN_HELD_SHARE * left else 0.0


@step
def _observe_side(s: Table, p: Table, sign: float, off_px: float, variance: float) -> None:
    """Correct a side; what jumps has not moved: it is another part of the object."""
    expected = p[0, 0] + 2.0 * sign * p[0, 2] + p[2, 2] + variance
    if off_px * off_px <= _JUMP_SIGMAS * _JUMP_SIGMAS * expected:
        correct(s, p, sign, off_px, variance)
        return
    s[0] += 0.5 * off_px
    s[2] += 0.5 * sign * off_px
    for k in range(4):
        for of in range(0, 4, 2):
            if k != of:
                p[k, of] = p[of, k] = 0.0
    p[0, 0] += 0.25 * variance
    p[2, 2] += 0.25 * variance


@step
def _measure_sides(rules: Rules, world: World, rows: int, columns: int, bin_px: int, reach: Table) -> float:
    """The sides of what was chosen, in `world.bounds`, from the centre; returns its pixels."""
    line, bounds = world.line, world.bounds
    line[:] = 0.0
    mass = 0.0
    for y in range(rows):
        row = world.taken[y]
        while row != NO_BINS:
            x = int(lowest(row))
            row = without_lowest(row)
            if world.parts[world.label[y, x] - 1, 2, 0] > 0.0:
                line[0, x] += world.bins[y, x]
                line[1, y] += world.bins[y, x]
                mass += world.bins[y, x]
    for axis in range(2):
        count = columns if axis == 0 else rows
        beyond = rules.quantile * mass
        k, below = 0, 0.0
        while k < count - 1 and below + line[axis, k] <= beyond:
            below += line[axis, k]
            k += 1
        bounds[axis, 0] = (k + (beyond - below) / max(line[axis, k], 1e-9)) * bin_px - reach[axis]
        k, above = count - 1, 0.0
        while k > 0 and above + line[axis, k] <= beyond:
            above += line[axis, k]
            k -= 1
        bounds[axis, 1] = (k + 1 - (beyond - above) / max(line[axis, k], 1e-9)) * bin_px - reach[axis]
    return mass


@step
def _measure_contrast(rules: Rules, world: World, i: int, rows: int, columns: int, bin_px: int, reach: Table) -> None:
    """Pixels in the box by those around the gate, per area: an object stands out from its surroundings."""
    o, s, bounds = world.objects[i], world.state[i], world.bounds
    inner, outer, n_inner, n_outer = 0.0, 0.0, 0, 0
    edge = 0.5 * o.gate
    left, right = span(0.0, rules.width - 1.0, s[0, 0], columns, bin_px, reach[0])  # on the sensor
    top, bottom = span(0.0, rules.height - 1.0, s[1, 0], rows, bin_px, reach[1])
    box_left, box_right = span(bounds[0, 0], bounds[0, 1], 0.0, columns, bin_px, reach[0])
    box_top, box_bottom = span(bounds[1, 0], bounds[1, 1], 0.0, rows, bin_px, reach[1])
    gate_left, gate_right = span(bounds[0, 0] - edge, bounds[0, 1] + edge, 0.0, columns, bin_px, reach[0])
    gate_top, gate_bottom = span(bounds[1, 0] - edge, bounds[1, 1] + edge, 0.0, rows, bin_px, reach[1])
    box_left, box_right = max(box_left, left), min(box_right, right)
    gate_left, gate_right = min(max(gate_left, left), right), max(min(gate_right, right), left)
    for y in range(top, bottom):
        if box_top <= y < box_bottom and box_left < box_right:
            inner += pixels_in(world, y, box_left, box_right)
            n_inner += box_right - box_left
        if gate_top <= y < gate_bottom and gate_left < gate_right:
            outer += pixels_in(world, y, left, gate_left) + pixels_in(world, y, gate_right, right)
            n_outer += gate_left - left + right - gate_right
        else:
            outer += pixels_in(world, y, left, right)
            n_outer += right - left
    o.contrast = (inner / max(n_inner, 1) + 1e-9) / (outer / max(n_outer, 1) + 1e-9)


@step
def _hidden(world: World, i: int, n: int, axis: int, high: int) -> bool:
    """Whether the middle of a side lies in the box of an object that this one meets: what lies beyond may be the other's."""
    s = world.state[i]
    sign = 1.0 if high else -1.0
    x = s[0, 0] + (sign * s[0, 2] if axis == 0 else 0.0)
    y = s[1, 0] + (sign * s[1, 2] if axis == 1 else 0.0)
    for k in range(n):
        other, gate = world.state[world.meeting[k]], world.objects[world.meeting[k]].gate
        if abs(x - other[0, 0]) <= other[0, 2] + gate and abs(y - other[1, 0]) <= other[1, 2] + gate:
            return True
    return False


@step
def look(rules: Rules, world: World, i: int, n: int, t_us: int) -> float:
    """Look at an object at the end of a packet, and correct its state; returns the pixels of it that were seen.

    Args:
        n: objects that it meets, in `world.meeting`.
    """
    o, s, p = world.objects[i], world.state[i], world.cov[i]
    window_s = _window_s(rules, world, i)
    half = max(s[0, 2], s[1, 2])
    bin_px = max(int(np.ceil(half / _BINS_PER_HALF)), 1)
    reach = world.group_box
    for axis in range(2):
        reach[axis] = min(s[axis, 2] + max(_MARGIN_HALVES * half, _MARGIN_PX), 0.5 * BINS * bin_px - 1e-6)
    columns = min(int(2.0 * reach[0] / bin_px) + 1, BINS)
    rows = min(int(2.0 * reach[1] / bin_px) + 1, BINS)
    late = _collect(rules, world, i, t_us, window_s, bin_px, reach, n)
    smooth(world, rows, columns)
    noise = bin_px * bin_px * (1.0 - np.exp(-max(world.run[0].noise, 0.0) * window_s))
    level = _level(rules, world, i, noise, bin_px, reach, rows)
    found = find_parts(world, level, rows, s[:, 2], reach, bin_px, _LINK_BINS)
    total = _choose(rules, world, i, found, bin_px, reach)
    speed = max(np.hypot(s[0, 1], s[1, 1]), 0.2 * o.speed)
    expected = o.usual * np.hypot(s[0, 1], s[1, 1]) * window_s
    full = rules.full * 2.0 * (s[0, 2] + s[1, 2]) * max(speed * window_s, 1.0)
    if late < _MIN_LATE_SHARE or total < max(0.5 * rules.birth_pixels, full, _MIN_SUPPORT_SHARE * expected):
        return 0.0
    if found > 1 and _divide(rules, world, found, _CLOSE_HALVES * half / bin_px):
        o.apart += 1
        if o.apart < _DIVIDE_AFTER:
            return total
    else:
        o.apart = 0
    mass = _measure_sides(rules, world, rows, columns, bin_px, reach)
    _measure_contrast(rules, world, i, rows, columns, bin_px, reach)
    if o.travel >= _SIZE_KNOWN_HALVES:
        # What turns back or stops sends little: few pixels tell less of a size that is known.
        expected = max(expected, rules.fill * 2.0 * (s[0, 2] + s[1, 2]))
    variance = (rules.precision * half + 0.3 * bin_px) ** 2 * min(max(expected / mass, 1.0), 10.0)
    for axis in range(2):
        size = rules.width if axis == 0 else rules.height
        low, high = s[axis, 0] + world.bounds[axis, 0], s[axis, 0] + world.bounds[axis, 1]
        off_low, off_high = low - (s[axis, 0] - s[axis, 2]), high - (s[axis, 0] + s[axis, 2])
        see_low = not _hidden(world, i, n, axis, 0) and not (low < _BORDER_PX and off_low > _CUT_OFF_PX)
        see_high = not _hidden(world, i, n, axis, 1) and not (high > size - 1.0 - _BORDER_PX and off_high < -_CUT_OFF_PX)
        if see_low:
            before = s[axis, 0], s[axis, 2]
            _observe_side(s[axis], p[axis], -1.0, off_low, variance)
            off_high -= (s[axis, 0] + s[axis, 2]) - (before[0] + before[1])
        if see_high:
            _observe_side(s[axis], p[axis], 1.0, off_high, variance)
    o.mass = mass
    sent = mass / max(speed * window_s, 1.0)
    o.usual += _USUAL_MIX * (sent - o.usual)
    return mass
