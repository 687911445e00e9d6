# SPDX-License-Identifier: Apache-2.0
"""The extent of an object from its picture: where its pixels lie in the object's own frame.

The picture is collected while the object moves, and fades as it travels, so that weak and far edges count although one
packet shows none of them; what moves differently is smeared. It falls into parts that do not touch. The heaviest part and
those that can belong to it (`unity.are_parts`) are the object: a box that holds less is extended, one that holds more is
shrunk.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import step
from .layout import BINS, REACH, Rules, World
from .unity import are_parts

__all__ = ["add_travel", "clear_picture", "fit_outline", "move_picture"]

Table = NDArray[Any]

_LEAST = 0.5  # pixels in a bin of the picture, at least
_SIGMAS = 3.0
_ENOUGH = 40.0  # pixels in a picture from which it counts
_LEAST_SHARE = 0.04  # of the pixels: a smaller part is noise
_LEAST_PIXELS = 4.0
_FILLED = 0.6  # half sides of travel after which a picture is complete enough to shrink a box
_MOST_GAIN = 1e6


@step
def clear_picture(world: World, i: int) -> None:
    """Begin an object's picture anew."""
    o = world.objects[i]
    world.picture[i] = 0.0
    o.gain, o.floor, o.drawn = 1.0, 0.0, 0.0


@step
def add_travel(rules: Rules, world: World, i: int, travel: float, noise: float) -> None:
    """Fade an object's picture by a distance travelled, in half sides: what comes later weighs more.

    Args:
        noise: pixels of the background's noise in a packet, per pixel.
    """
    o = world.objects[i]
    o.drawn += travel
    o.floor += o.gain * noise * o.unit_x * o.unit_y * (2.0 * REACH / BINS) ** 2
    o.gain *= np.exp(min(travel / rules.memory, 5.0))
    if o.gain > _MOST_GAIN:
        for y in range(BINS):
            for x in range(BINS):
                world.picture[i, y, x] /= o.gain
        o.floor /= o.gain
        o.gain = 1.0


@step
def move_picture(world: World, i: int, axis: int, shift: float, scale: float) -> None:
    """Redraw a picture in a frame moved along an axis by `shift` old units, with a unit `scale` times as long."""
    picture = world.picture[i]
    line = world.line
    for k in range(BINS):
        for at in range(BINS):
            line[at] = picture[k, at] if axis == 0 else picture[at, k]
        for at in range(BINS):
            old = int((((at + 0.5) * 2.0 * REACH / BINS - REACH) * scale + shift + REACH) * BINS / (2.0 * REACH))
            value = line[old] * scale if 0 <= old < BINS else 0.0
            if axis == 0:
                picture[k, at] = value
            else:
                picture[at, k] = value


@step
def _parts(world: World, i: int, level: float, parts: Table, least: float) -> int:
    """The connected parts of a picture: first and last bin along x and y, and sum; returns how many there are."""
    picture, done, queue = world.picture[i], world.done, world.bin_queue
    done[:] = False
    n, filled = 0, 0
    for y in range(BINS):
        for x in range(BINS):
            if done[y, x] or picture[y, x] < level:
                continue
            left, right, top, bottom, mass = x, x, y, y, 0.0
            queue[0] = y * BINS + x
            done[y, x] = True
            k, m = 0, 1
            while k < m:
                yy, xx = queue[k] // BINS, queue[k] % BINS
                k += 1
                mass += picture[yy, xx]
                filled += 1
                left, right, top, bottom = min(left, xx), max(right, xx), min(top, yy), max(bottom, yy)
                for v in range(max(yy - 1, 0), min(yy + 2, BINS)):
                    for u in range(max(xx - 1, 0), min(xx + 2, BINS)):
                        if not done[v, u] and picture[v, u] >= level:
                            done[v, u] = True
                            queue[m] = v * BINS + u
                            m += 1
            if mass >= least and n < len(parts):
                parts[n, 0, 0], parts[n, 0, 1] = left, right + 1
                parts[n, 1, 0], parts[n, 1, 1] = top, bottom + 1
                parts[n, 2, 0] = mass
                n += 1
    world.run[0].filled = filled
    return n


@step
def _join(rules: Rules, world: World, i: int, parts: Table, n: int, box: Table) -> None:
    """The bounds in px, relative to the box's centre, of the heaviest part with all that belong to it."""
    o = world.objects[i]
    heaviest = 0
    for k in range(n):
        for axis in range(2):
            bin_px = 2.0 * REACH * (o.unit_x if axis == 0 else o.unit_y) / BINS
            low, high = (parts[k, axis, 0] - 0.5 * BINS) * bin_px, (parts[k, axis, 1] - 0.5 * BINS) * bin_px
            parts[k, axis, 0], parts[k, axis, 1] = 0.5 * (low + high), 0.5 * (high - low)
        if parts[k, 2, 0] > parts[heaviest, 2, 0]:
            heaviest = k
    whole = world.whole
    for axis in range(2):
        whole[axis, 0], whole[axis, 1] = parts[heaviest, axis, 0], parts[heaviest, axis, 1]
    parts[heaviest, 2, 0] = 0.0
    grown = True
    while grown:
        grown = False
        for k in range(n):
            if parts[k, 2, 0] > 0.0 and are_parts(whole, parts[k, :2], rules.gap, rules.elongation):
                for axis in range(2):
                    low = min(whole[axis, 0] - whole[axis, 1], parts[k, axis, 0] - parts[k, axis, 1])
                    high = max(whole[axis, 0] + whole[axis, 1], parts[k, axis, 0] + parts[k, axis, 1])
                    whole[axis, 0], whole[axis, 1] = 0.5 * (low + high), 0.5 * (high - low)
                parts[k, 2, 0] = 0.0
                grown = True
    for axis in range(2):
        box[axis, 0], box[axis, 1] = whole[axis, 0] - whole[axis, 1], whole[axis, 0] + whole[axis, 1]


@step
def fit_outline(rules: Rules, world: World, i: int) -> None:
    """Make a box hold its object if it is off by much."""
    o, state = world.objects[i], world.state[i]
    bins_x = state[0, 2] * BINS / (2.0 * REACH * o.unit_x)
    bins_y = state[1, 2] * BINS / (2.0 * REACH * o.unit_y)
    inside, square = 0.0, 0.0
    for y in range(max(int(0.5 * BINS - bins_y), 0), min(int(0.5 * BINS + bins_y) + 1, BINS)):
        for x in range(max(int(0.5 * BINS - bins_x), 0), min(int(0.5 * BINS + bins_x) + 1, BINS)):
            value = max(world.picture[i, y, x] - o.floor, 0.0) / o.gain
            inside += value
            square += value * value
    if inside < _ENOUGH:
        return
    floor = o.floor / o.gain
    level = max(rules.dense * square / inside, _LEAST) + floor + _SIGMAS * np.sqrt(floor)
    parts, box = world.parts, world.bounds
    n = _parts(world, i, level * o.gain, parts, max(_LEAST_SHARE * inside, _LEAST_PIXELS) * o.gain)
    if n == 0:
        return
    bin_area = o.unit_x * o.unit_y * (2.0 * REACH / BINS) ** 2
    o.area = max(world.run[0].filled * bin_area, 1.0)
    _join(rules, world, i, parts, n, box)
    changed = False
    for axis in range(2):
        s, p = state[axis], world.cov[i, axis]
        unit = o.unit_x if axis == 0 else o.unit_y
        bin_px = 2.0 * REACH * unit / BINS
        least = max(rules.tolerance * s[2], bin_px)
        # On average a part ends in the middle of its last bin.
        off_low, off_high = -s[2] - box[axis, 0] - 0.5 * bin_px, box[axis, 1] - s[2] - 0.5 * bin_px
        off_low = off_low if off_low >= least or (off_low <= -least and o.drawn > _FILLED) else 0.0
        off_high = off_high if off_high >= least or (off_high <= -least and o.drawn > _FILLED) else 0.0
        if off_low == 0.0 and off_high == 0.0:
            continue
        shift, wider = 0.5 * (off_high - off_low), 0.5 * (off_low + off_high)
        s[0] += shift
        if axis == 0:
            o.first_x += shift
        else:
            o.first_y += shift
        s[2] = max(s[2] + wider, 1.0)
        p[0, 0] += (0.25 * shift) ** 2
        p[2, 2] += (0.25 * wider) ** 2
        move_picture(world, i, axis, shift / unit, 1.0)
        changed = True
    if changed:
        world.profile[i] = 0.0
        world.total[i] = 64.0
