# SPDX-License-Identifier: Apache-2.0
"""The extent of an object from its picture: where its pixels lie in the object's own frame.

The picture is collected while the object moves, and fades as it travels, so that weak and far edges count although one
packet shows none of them; what moves differently is smeared. It falls into parts that do not touch. A box that reaches
beyond all parts in it is shrunk to them. If an empty strip lies across it between two groups of parts that cannot be one
object (`unity.are_parts`), the box is left to the heavier one, and the other is born anew. A box is never extended by its
picture: what lies beside it may be another object.
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
_ENTERED = 2.0  # the same for an object that enters
_MOST_GAIN = 1e6
_STRIP = 0.2  # of a box: an empty strip between two objects
_SHARE = 0.15  # of the pixels: each of the two has as many
_SLACK = 1.25  # factor of gap and elongation, up to which they may still be one
_AROUND = 1.5  # gates: surroundings begin outside of them
_BINS_AROUND, _PIXELS = 40, 12.0  # from which a contrast is known


@step
def clear_picture(world: World, i: int) -> None:
    """Begin an object's picture anew, and what is usual of its pixels."""
    o = world.objects[i]
    world.picture[i] = 0.0
    world.usual[i] = 0.0
    o.gain, o.floor, o.drawn = 1.0, 0.0, 0.0
    o.contrast = np.inf


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
def _bounds(parts: Table, n: int, box: Table) -> None:
    """The bounds of all parts."""
    for axis in range(2):
        box[axis, 0], box[axis, 1] = 1e9, -1e9
        for k in range(n):
            box[axis, 0], box[axis, 1] = min(box[axis, 0], parts[k, axis, 0]), max(box[axis, 1], parts[k, axis, 1])


@step
def _divide(rules: Rules, world: World, i: int, parts: Table, n: int, box: Table) -> bool:
    """Find an empty strip across the picture between two objects; the bounds of the heavier one.

    The strip is wide, both sides of it have their share of the pixels, and together they cannot be parts of one object.
    """
    state = world.state[i]
    one, other = world.whole, world.rest
    total = 0.0
    for k in range(n):
        total += parts[k, 2, 0]
    for axis in range(2):
        for k in range(n):
            cut = parts[k, axis, 1]
            low_mass, high_mass, gap = 0.0, 0.0, 1e9
            for a in range(2):
                one[a, 0] = other[a, 0] = 1e9
                one[a, 1] = other[a, 1] = -1e9
            for m in range(n):
                low = parts[m, axis, 1] <= cut
                if not low and parts[m, axis, 0] < cut:
                    gap = -1.0  # it lies on both sides
                    break
                side = one if low else other
                for a in range(2):
                    side[a, 0], side[a, 1] = min(side[a, 0], parts[m, a, 0]), max(side[a, 1], parts[m, a, 1])
                if low:
                    low_mass += parts[m, 2, 0]
                else:
                    high_mass += parts[m, 2, 0]
                    gap = min(gap, parts[m, axis, 0] - cut)
            if min(low_mass, high_mass) < _SHARE * total or gap < _STRIP * 2.0 * state[axis, 2]:
                continue
            for a in range(2):
                heavier = one[a] if low_mass >= high_mass else other[a]
                box[a, 0], box[a, 1] = heavier[0], heavier[1]
                one[a, 0], one[a, 1] = 0.5 * (one[a, 0] + one[a, 1]), 0.5 * (one[a, 1] - one[a, 0])
                other[a, 0], other[a, 1] = 0.5 * (other[a, 0] + other[a, 1]), 0.5 * (other[a, 1] - other[a, 0])
            if not are_parts(one, other, _SLACK * rules.gap, _SLACK * rules.elongation):
                return True
    return False


@step
def _measure_contrast(rules: Rules, world: World, i: int, bins_x: float, bins_y: float) -> None:
    """Pixels in the box by those around the gate, per area: an object stands out from its surroundings."""
    o, state = world.objects[i], world.state[i]
    inner, outer, n_inner, n_outer = 0.0, 0.0, 0, 0
    bin_x, bin_y = 2.0 * REACH * o.unit_x / BINS, 2.0 * REACH * o.unit_y / BINS
    gate_x, gate_y = bins_x + _AROUND * o.gate / bin_x, bins_y + _AROUND * o.gate / bin_y
    for y in range(BINS):
        dy = y + 0.5 - 0.5 * BINS
        if not 0.0 <= state[1, 0] + dy * bin_y <= rules.height - 1.0:
            continue
        for x in range(BINS):
            dx = x + 0.5 - 0.5 * BINS
            if not 0.0 <= state[0, 0] + dx * bin_x <= rules.width - 1.0:
                continue
            if abs(dx) <= bins_x and abs(dy) <= bins_y:
                inner += world.picture[i, y, x]
                n_inner += 1
            elif abs(dx) > gate_x or abs(dy) > gate_y:
                outer += world.picture[i, y, x]
                n_outer += 1
    if n_inner > 0 and n_outer > _BINS_AROUND and inner + outer > _PIXELS * o.gain:
        o.contrast = (inner / n_inner) / (outer / n_outer + 1e-9)


@step
def fit_outline(rules: Rules, world: World, i: int) -> None:
    """Shrink a box to what is in it, or to the heavier one of two objects."""
    o, state = world.objects[i], world.state[i]
    bins_x = state[0, 2] * BINS / (2.0 * REACH * o.unit_x)
    bins_y = state[1, 2] * BINS / (2.0 * REACH * o.unit_y)
    inside, square = 0.0, 0.0
    for y in range(max(int(0.5 * BINS - bins_y), 0), min(int(0.5 * BINS + bins_y) + 1, BINS)):
        for x in range(max(int(0.5 * BINS - bins_x), 0), min(int(0.5 * BINS + bins_x) + 1, BINS)):
            value = max(world.picture[i, y, x] - o.floor, 0.0) / o.gain
            inside += value
            square += value * value
    _measure_contrast(rules, world, i, bins_x, bins_y)
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
    m = 0
    for k in range(n):
        x = 0.5 * (parts[k, 0, 0] + parts[k, 0, 1] - BINS)
        y = 0.5 * (parts[k, 1, 0] + parts[k, 1, 1] - BINS)
        if abs(x) > bins_x or abs(y) > bins_y:
            continue  # not in the box
        for axis in range(2):
            bin_px = 2.0 * REACH * (o.unit_x if axis == 0 else o.unit_y) / BINS
            parts[m, axis, 0] = (parts[k, axis, 0] - 0.5 * BINS) * bin_px
            parts[m, axis, 1] = (parts[k, axis, 1] - 0.5 * BINS) * bin_px
        parts[m, 2, 0] = parts[k, 2, 0]
        m += 1
    if m == 0 or o.drawn <= (_ENTERED if o.enters >= 0 else _FILLED):
        return
    if not _divide(rules, world, i, parts, m, box):
        if o.meets:
            return  # another object hides parts of this one
        _bounds(parts, m, box)
    changed = False
    for axis in range(2):
        s, p = state[axis], world.cov[i, axis]
        unit = o.unit_x if axis == 0 else o.unit_y
        bin_px = 2.0 * REACH * unit / BINS
        least = max(rules.tolerance * s[2], bin_px)
        # On average a part ends in the middle of its last bin.
        off_low, off_high = -s[2] - box[axis, 0] - 0.5 * bin_px, box[axis, 1] - s[2] - 0.5 * bin_px
        off_low = off_low if off_low <= -least else 0.0
        off_high = off_high if off_high <= -least else 0.0
        if off_low == 0.0 and off_high == 0.0:
            continue
        shift, wider = 0.5 * (off_high - off_low), 0.5 * (off_low + off_high)
        s[0] += shift
        if axis == 0:
            o.first_x += shift
        else:
            o.first_y += shift
        s[2] = max(s[2] + wider, 1.0)
        if off_low == 0.0 or off_high == 0.0:  # what is left moves as its other side did
            s[1] += -s[3] if off_low == 0.0 else s[3]
            s[3] = 0.0
            p[1, 1] += p[3, 3]
        p[0, 0] += (0.25 * shift) ** 2
        p[2, 2] += (0.25 * wider) ** 2
        move_picture(world, i, axis, shift / unit, 1.0)
        changed = True
    if changed:
        world.profile[i] = 0.0
        world.total[i] = 64.0
