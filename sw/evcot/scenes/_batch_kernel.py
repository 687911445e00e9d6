# SPDX-License-Identifier: Apache-2.0
"""Kernel: the events of a batch of frames: of the same shapes at successive times, in front of a background at rest.

Most pixels near a moving contour change too little for an event. So it is first estimated how far each pixel's intensity may
go. Only pixels that may leave the bounds within which they make no event are rendered.
The events are those that `draw` and `pixel_events` give frame by frame, to the last bit.
"""

from __future__ import annotations

import numpy as np

from .._numba_private import njit, step
from ._pixel_kernel import AT_ONCE, MEMORY, NEVER, OFF, ON, READY, ROUNDING, STATES, logarithm, longer, one_pixel, quiet_bounds
from ._render_kernel import (
    HIGH,
    LOW,
    MARGIN,
    WHOLE_HIGH,
    WHOLE_LOW,
    blended,
    bounds,
    edges_of,
    pixels_within,
    row_spans,
)  # fmt: skip
from .shapes import DISC, INTENSITY, KIND, X, Y

__all__ = ["batch_events"]

# A run: pixels of a row that a shape may touch at any of the times. First a rectangle, as for `draw`; then those that it covers
# as a whole at each time.
_BEGIN, _ROW, _PAST, _NEXT_ROW, _WHOLE_BEGIN, _WHOLE_PAST, _SHAPE = range(7)
_ROUNDING = 1e-5  # of an intensity; the estimate is in float32


@njit(cache=True, nogil=True)
def batch_events(shapes, times_us, background, pixels, maps, head, own, own_ends, refractory_us):  # type: ignore[no-untyped-def]
    """Keys of the events in (times_us[0], times_us[-1]], in any order. Times are relative to the first, and have the number of
    their interval added, so that no two intervals overlap.

    `shapes` (times, n, columns): the same ones at each time. `pixels`, `head`: see `pixel_events`; the last frame is neither
    read nor updated. `maps`: work space, of which the first is -1. `own`, `own_ends`: see `Spontaneous.between`.
    """
    ids, dark, bright = maps
    n, times = shapes.shape[1], len(times_us)
    edges, areas = np.empty((n, 4, 3, times)), np.empty((n, 4, times + 2), np.int64)
    rows = _prepare(shapes, edges, areas, background.shape[0], background.shape[1])
    runs, reaches = np.empty((rows, 7), np.int64), np.empty((rows, 4, 2))
    ways, spans = np.empty((2, 4, 2)), np.empty((4, len(background)))
    runs = runs[: _find_runs(shapes, edges, areas, ways, spans, runs, reaches)]
    lights = np.empty((n, times))
    for i in range(n):
        for k in range(times):
            lights[i, k] = shapes[k, i, INTENSITY]
    _estimate(runs, reaches, shapes, lights, edges, areas, background, dark, bright)
    link = np.empty(len(own), np.int64)
    most = len(own) + _count(runs) + 1
    restless, nearest, covers = np.empty(most, np.int64), np.full(most, -1), np.empty((most, 2), np.int64)
    spontaneous, n = _find_restless(runs, pixels, dark, bright, ids, own, link, head, restless, nearest, covers)
    restless = restless[:n]
    keys, n = np.empty(1024 + 2 * len(own), np.int64), 0
    values, known, awake = np.empty((AT_ONCE, times)), np.empty((AT_ONCE, STATES)), np.empty((AT_ONCE, 2), np.int64)
    part, levels = np.empty(times), np.empty(times)
    for begin in range(0, len(restless), AT_ONCE):
        some = restless[begin : begin + AT_ONCE]
        _fill(some, background, values)
        _render(some, nearest[begin : begin + AT_ONCE], covers, runs, reaches, shapes, lights, edges, areas, values, part)
        for i, k in awake[: _find_awake(some, spontaneous - begin, values, pixels, ids, awake, known)]:
            x, y, first = some[i] >> 17, some[i] >> 1 & 0xFFFF, -1
            if begin + i < spontaneous:
                first, head[y, x] = head[y, x], -1
            while True:
                past = _events(
                    keys, n, x, y, values[i], levels, k, times_us, pixels, known[i], link, first, own, own_ends, refractory_us
                )
                if past <= len(keys):
                    break
                keys = longer(keys, n, past)
            n = past
    return keys[:n]


@step
def _prepare(shapes, edges, areas, height, width):  # type: ignore[no-untyped-def]
    """Write the edges of each quadrangle, x, y and radius of each disc, and of each shape the rectangles of pixels that it may
    touch: at each time, at any, and those at every time. Returns the number of rows of all that are at any time."""
    times, rows = len(shapes), 0
    for i in range(shapes.shape[1]):
        some, every = areas[i, :, times], areas[i, :, times + 1]
        some[0], some[1], some[2], some[3] = width, height, 0, 0
        every[0], every[1], every[2], every[3] = 0, 0, width, height
        for k in range(times):
            if shapes[k, i, KIND] == DISC:
                edges[i, 0, 0, k], edges[i, 0, 1, k], edges[i, 0, 2, k] = shapes[k, i, X], shapes[k, i, Y], shapes[k, i, X + 1]
            else:
                edges_of(shapes[k, i], edges[i, :, :, k])
            left, top, right, bottom = bounds(shapes[k, i])
            left, top, right, bottom = pixels_within(left, top, right, bottom, width, height)
            if not (left < right and top < bottom):
                left, top, right, bottom = width, height, 0, 0
            areas[i, 0, k], areas[i, 1, k], areas[i, 2, k], areas[i, 3, k] = left, top, right, bottom
            some[0], some[1], some[2], some[3] = (
                min(some[0], left),
                min(some[1], top),
                max(some[2], right),
                max(some[3], bottom),
            )
            every[0], every[1], every[2], every[3] = (
                max(every[0], left), max(every[1], top), min(every[2], right), min(every[3], bottom)
            )  # fmt: skip
        rows += max(some[3] - some[1], 0)
    return rows


@step
def _find_runs(shapes, edges, areas, ways, spans, runs, reaches):  # type: ignore[no-untyped-def]
    """Write the runs, shape by shape; returns their number.

    `reaches` (runs, 4, 2): how far each edge may come in, and go out, after the first time, in the run; of a disc only the
    first is used. `ways` (2, 4, 2): work space for the same in the first and the last row of a shape.
    """
    n, times = 0, len(shapes)
    for i in range(shapes.shape[1]):
        left, top, right, bottom = areas[i, :, times]
        if not (left < right and top < bottom):
            continue
        every = areas[i, :, times + 1]
        ways[:] = 0.0
        if shapes[0, i, KIND] == DISC:
            ways[0, 0, 0] = ways[1, 0, 0] = _disc_move(shapes, i)
            _disc_spans(shapes[0, i], ways[0, 0, 0], left, right, top, bottom, spans)
        else:
            for end, y in enumerate((top, bottom - 1)):
                _find_ways(edges[i], left, y, ways[end])
                _find_ways(edges[i], right - 1, y, ways[end])
            at_top, at_bottom = 0.0, 0.0
            for edge in range(4):
                at_top = max(at_top, ways[0, edge, 0], ways[0, edge, 1])
                at_bottom = max(at_bottom, ways[1, edge, 0], ways[1, edge, 1])
            slack = at_top + MARGIN, (at_bottom - at_top) / max(bottom - 1 - top, 1)
            row_spans(edges[i, :, :, 0], slack, left, right, top, bottom, spans)
        for row in range(bottom - top):
            y, begin, past = top + row, int(spans[LOW, row]), int(spans[HIGH, row])
            if begin >= past:
                continue
            runs[n, _BEGIN], runs[n, _ROW], runs[n, _PAST], runs[n, _NEXT_ROW], runs[n, _SHAPE] = begin, y, past, y + 1, i
            whole_begin = max(begin, every[0], int(np.ceil(spans[WHOLE_LOW, row])))
            whole_past = min(past, every[2], int(np.floor(spans[WHOLE_HIGH, row])) + 1)
            if whole_begin >= whole_past or not every[1] <= y < every[3]:
                whole_begin = whole_past = past
            runs[n, _WHOLE_BEGIN], runs[n, _WHOLE_PAST] = whole_begin, whole_past
            share = row / max(bottom - 1 - top, 1)
            for edge in range(4):
                for way in range(2):
                    reaches[n, edge, way] = ways[0, edge, way] + share * (ways[1, edge, way] - ways[0, edge, way])
            n += 1
    return n


@step
def _find_ways(edges, x, y, ways):  # type: ignore[no-untyped-def]
    """Widen how far each edge of a quadrangle may come in, and go out, to what it does at (x, y)."""
    for edge in range(4):
        most_in, most_out = ways[edge, 0], ways[edge, 1]
        here = edges[edge, 0, 0] * x + edges[edge, 1, 0] * y + edges[edge, 2, 0]
        for k in range(1, edges.shape[2]):
            way = edges[edge, 0, k] * x + edges[edge, 1, k] * y + edges[edge, 2, k] - here
            most_in, most_out = max(most_in, -way), max(most_out, way)
        ways[edge, 0], ways[edge, 1] = most_in, most_out


@step
def _disc_move(shapes, i):  # type: ignore[no-untyped-def]
    """The most that a disc's coverage of a pixel may differ from that at the first time."""
    most, was = 0.0, shapes[0, i]
    for k in range(1, len(shapes)):
        now = shapes[k, i]
        most = max(most, np.hypot(now[X] - was[X], now[Y] - was[Y]) + abs(now[X + 1] - was[X + 1]))
    return most


@step
def _disc_spans(shape, move, first_x, past_x, first_y, past_y, spans):  # type: ignore[no-untyped-def]
    """`row_spans` of a disc that may move so far."""
    outer, inner = shape[X + 1] + 0.5 + move + MARGIN, max(shape[X + 1] - 0.5 - move - 2 * MARGIN, 0.0)
    for row in range(past_y - first_y):
        down = (row + first_y - shape[Y]) ** 2
        half = np.sqrt(max(outer**2 - down, 0.0))
        spans[LOW, row] = max(first_x, shape[X] - half)
        spans[HIGH, row] = min(past_x, shape[X] + half + 1.0)
        half = np.sqrt(inner**2 - down) if inner**2 > down else -1.0
        spans[WHOLE_LOW, row], spans[WHOLE_HIGH, row] = shape[X] - half, shape[X] + half


@step
def _estimate(runs, reaches, shapes, lights, edges, areas, background, dark, bright):  # type: ignore[no-untyped-def]
    """Write bounds of the intensity of each pixel of the runs."""
    for r in range(len(runs)):
        y = np.uint64(runs[r, _ROW])
        for x in range(np.uint64(runs[r, _BEGIN]), np.uint64(runs[r, _PAST])):
            dark[y, x] = bright[y, x] = background[y, x]
    shape, low, high = -1, np.float32(0.0), np.float32(0.0)
    for r in range(len(runs)):
        i, y, begin, past = runs[r, _SHAPE], np.uint64(runs[r, _ROW]), runs[r, _BEGIN], runs[r, _PAST]
        whole_begin, whole_past = runs[r, _WHOLE_BEGIN], runs[r, _WHOLE_PAST]
        if i != shape:
            shape, low, high = i, np.float32(lights[i, 0]), np.float32(lights[i, 0])
            for k in range(1, lights.shape[1]):
                low, high = min(low, np.float32(lights[i, k])), max(high, np.float32(lights[i, k]))
        every = areas[i, :, lights.shape[1] + 1]
        # Where the rectangles of the shape end, its contour may end abruptly.
        left, right = (every[0], every[2]) if every[1] <= runs[r, _ROW] < every[3] else (past, past)
        if shapes[0, i, KIND] == DISC:
            _bound_disc(shapes[0, i], reaches[r, 0, 0], dark[y], bright[y], y, begin, past, low, high)
        else:
            _bound_quadrangle(edges[i], reaches[r], dark[y], bright[y], y, begin, whole_begin, left, right, low, high)
            _bound_quadrangle(edges[i], reaches[r], dark[y], bright[y], y, whole_past, past, left, right, low, high)
        for x in range(np.uint64(whole_begin), np.uint64(whole_past)):
            dark[y, x], bright[y, x] = low, high


@step
def _bound_disc(shape, move, dark, bright, y, begin, past, low, high):  # type: ignore[no-untyped-def]
    """Blend the bounds of a disc of intensity `low` to `high`, which may move so far, into those of pixels of a row."""
    for x in range(np.uint64(begin), np.uint64(past)):
        within = shape[X + 1] - np.sqrt((x - shape[X]) ** 2 + (y - shape[Y]) ** 2) + 0.5
        least, most = np.float32(min(max(within - move, 0.0), 1.0)), np.float32(min(max(within + move, 0.0), 1.0))
        to_low, to_high = low - dark[x], high - bright[x]
        dark[x] += min(least * to_low, most * to_low)
        bright[x] += max(least * to_high, most * to_high)


@step
def _bound_quadrangle(edges, reach, dark, bright, y, begin, past, left, right, low, high):  # type: ignore[no-untyped-def]
    """Blend the bounds of a quadrangle of intensity `low` to `high` into those of pixels of a row. It may be nowhere in pixels
    that are not from `left` to `right`. `reach`: see `_find_runs`."""
    if begin >= past:
        return
    a, b, c, d = (edges[0, 0, 0], edges[1, 0, 0], edges[2, 0, 0], edges[3, 0, 0])
    a0, b0 = edges[0, 1, 0] * y + edges[0, 2, 0] + 0.5, edges[1, 1, 0] * y + edges[1, 2, 0] + 0.5
    c0, d0 = edges[2, 1, 0] * y + edges[2, 2, 0] + 0.5, edges[3, 1, 0] * y + edges[3, 2, 0] + 0.5
    a_in, a_out = reach[0, 0], reach[0, 1]
    b_in, b_out = reach[1, 0], reach[1, 1]
    c_in, c_out = reach[2, 0], reach[2, 1]
    d_in, d_out = reach[3, 0], reach[3, 1]
    first, end = float(left), float(right)
    for x in range(np.uint64(begin), np.uint64(past)):
        ax, bx, cx, dx = a * x + a0, b * x + b0, c * x + c0, d * x + d0
        wide = max(min(max(ax - a_in, 0.0), 1.0) + min(max(cx - c_in, 0.0), 1.0) - 1.0, 0.0)
        least = wide * max(min(max(bx - b_in, 0.0), 1.0) + min(max(dx - d_in, 0.0), 1.0) - 1.0, 0.0)
        wide = max(min(max(ax + a_out, 0.0), 1.0) + min(max(cx + c_out, 0.0), 1.0) - 1.0, 0.0)
        most = np.float32(wide * max(min(max(bx + b_out, 0.0), 1.0) + min(max(dx + d_out, 0.0), 1.0) - 1.0, 0.0))
        least = np.float32(least if (first <= float(x)) & (float(x) < end) else 0.0)
        to_low, to_high = low - dark[x], high - bright[x]
        dark[x] += min(least * to_low, most * to_low)
        bright[x] += max(least * to_high, most * to_high)


@step
def _count(runs):  # type: ignore[no-untyped-def]
    """How many pixels are in the runs."""
    pixels = 0
    for r in range(len(runs)):
        pixels += runs[r, _PAST] - runs[r, _BEGIN]
    return pixels


@step
def _find_restless(runs, pixels, dark, bright, ids, own, link, head, restless, nearest, covers):  # type: ignore[no-untyped-def]
    """Write the pixels that may make events, as x << 17 | y << 1, and their numbers to `ids`; returns how many have spontaneous
    events, which `link` and `head` list and which come first, and how many they are.

    `covers` lists, from `nearest` of a pixel on, the runs that may touch it, the farthest first, and the index of the next, or
    -1; it begins with the last one that covers the pixel as a whole at all times.
    """
    (_, low, high, _), n, m = pixels, 0, 0
    for i in range(len(own) - 1, -1, -1):
        x, y = own[i].x, own[i].y
        link[i] = head[y, x]
        head[y, x] = i
        if ids[y, x] < 0:
            restless[n], ids[y, x] = x << 17 | y << 1, n
            n += 1
    spontaneous = n
    for r in range(len(runs) - 1, -1, -1):
        y = np.uint64(runs[r, _ROW])
        for x in range(np.uint64(runs[r, _BEGIN]), np.uint64(runs[r, _PAST])):
            k = ids[y, x]
            if k < 0:
                least, most, slack = dark[y, x], bright[y, x], np.float32(_ROUNDING) * bright[y, x]
                if (low[y, x] < least - slack) & (most + slack < high[y, x]) | (least == most):
                    continue
                restless[n], ids[y, x] = np.int64(x) << 17 | runs[r, _ROW] << 1, n
                k, n = n, n + 1
            at = nearest[k]
            if at < 0 or not runs[covers[at, 0], _WHOLE_BEGIN] <= x < runs[covers[at, 0], _WHOLE_PAST]:
                covers[m, 0], covers[m, 1] = r, at
                nearest[k], m = m, m + 1
    return spontaneous, n


@step
def _fill(some, background, values):  # type: ignore[no-untyped-def]
    """Write the value of the background to those of each of some pixels."""
    for i in range(np.uint64(len(some))):
        x, y = np.uint64(some[i] >> 17), np.uint64(some[i] >> 1 & 0xFFFF)
        light = background[y, x]
        for k in range(np.uint64(values.shape[1])):
            values[i, k] = light


@step
def _find_awake(some, spontaneous, values, pixels, ids, awake, known):  # type: ignore[no-untyped-def]
    """Write which of some pixels leave their bounds, and at which time first, or have spontaneous events; returns how many they
    are. Writes the states of all to `known`: their memory is fetched in parallel. Clears `ids`."""
    _, low, high, states = pixels
    n, times = 0, values.shape[1]
    for i in range(len(some)):
        x, y = np.uint64(some[i] >> 17), np.uint64(some[i] >> 1 & 0xFFFF)
        ids[y, x] = -1
        for j in range(STATES):
            known[i, j] = states[y, x, j]
        least, most, first = low[y, x], high[y, x], times
        for k in range(np.uint64(1), np.uint64(times)):
            first = min(first, times if (least < values[i, k]) & (values[i, k] < most) else np.int64(k))
        awake[n, 0], awake[n, 1] = i, 1 if i < spontaneous else first
        n += (first < times) | (i < spontaneous)
    return n


@step
def _events(keys, n, x, y, values, levels, begin, times_us, pixels, state, link, first, own, own_ends, refractory_us):  # type: ignore[no-untyped-def]
    """Append the events of one pixel, whose first spontaneous event is `first`, and which makes none before a time. The others
    are as in `one_pixel`. Updates `pixels` if the keys have room. `levels`: work space."""
    _, low, high, states = pixels
    memory, ready, on, off = state[MEMORY], state[READY], state[ON], state[OFF]
    for k in range(np.uint64(begin - 1), np.uint64(len(values))):
        levels[k] = logarithm(values[k])
    rise, fall = on * ROUNDING, off * ROUNDING
    for k in range(begin, len(values)):
        before, after = levels[k - 1], levels[k]
        past = own_ends[k - 1]
        is_calm = ready == NEVER and after - memory < rise and memory - after < fall
        if not 0 <= first < past and (is_calm or before == after):
            continue
        n, first, memory, ready = one_pixel(
            keys, n, times_us[k - 1] - times_us[0] + k, x << 17 | y << 1, before, after, memory, ready, on, off, link, first,
            past, own, float(times_us[k - 1]), float(times_us[k] - times_us[k - 1]), refractory_us,
        )  # fmt: skip
    if n <= len(keys):
        states[y, x, MEMORY], states[y, x, READY] = memory, ready
        low[y, x], high[y, x] = quiet_bounds(memory, ready, on, off, True)
    return n


@step
def _render(some, nearest, covers, runs, reaches, shapes, lights, edges, areas, values, part):  # type: ignore[no-untyped-def]
    """Blend the shapes into the `values` of some pixels. `nearest`, `covers`: see `_find_restless`."""
    for k in range(len(some)):
        x, y, at = some[k] >> 17, some[k] >> 1 & 0xFFFF, nearest[k]
        while at >= 0:
            r, at = covers[at, 0], covers[at, 1]
            i = runs[r, _SHAPE]
            if runs[r, _WHOLE_BEGIN] <= x < runs[r, _WHOLE_PAST]:
                for j in range(np.uint64(len(part))):
                    values[k, j] = lights[i, j]
                continue
            if shapes[0, i, KIND] == DISC:
                _cover_by_disc(edges[i, 0], reaches[r, 0, 0] == 0.0, x, y, part)
                _blend(part, lights[i], values[k])
                continue
            clips, edge, is_outside = _find_clips(edges[i], reaches[r], x, y)
            if is_outside:
                continue
            if clips == 1:
                _blend_within_edge(edges[i, edge], lights[i], x, y, values[k])
            else:
                _cover_by_quadrangle(edges[i], areas[i], x, y, part)
                _blend(part, lights[i], values[k])


@step
def _cover_by_disc(path, is_still, x, y, part):  # type: ignore[no-untyped-def]
    """Write the part of a pixel that a disc covers at each time, as `draw` does. `path`: its x, y and radius at each time."""
    for k in range(np.uint64(1 if is_still else len(part))):
        across, down = x - path[0, k], y - path[1, k]
        part[k] = min(max(path[2, k] - np.sqrt(across * across + down * down) + 0.5, 0.0), 1.0)
    if is_still:
        for k in range(np.uint64(1), np.uint64(len(part))):
            part[k] = part[0]


@step
def _find_clips(edges, reach, x, y):  # type: ignore[no-untyped-def]
    """How many edges of a quadrangle a pixel is not within as a whole at every time, the last of them, and whether the pixel is
    outside one as a whole at every time."""
    clips, last, is_outside = 0, 0, False
    for edge in range(4):
        here = edges[edge, 0, 0] * x + edges[edge, 1, 0] * y + edges[edge, 2, 0]
        is_outside |= here + reach[edge, 1] <= -0.5 - MARGIN
        clip = here - reach[edge, 0] < 0.5 + MARGIN
        clips, last = clips + clip, edge if clip else last
    return clips, last, is_outside


@step
def _blend_within_edge(edge, lights, x, y, values):  # type: ignore[no-untyped-def]
    """Blend a quadrangle into a pixel that is within the other edges at every time. Where it covers a part of the pixel, the
    pixel is within its rectangle."""
    for k in range(np.uint64(len(values))):
        a = edge[0, k] * x + edge[1, k] * y + edge[2, k]
        part = min(max(a + 0.5, 0.0), 1.0) + 1.0 - 1.0  # rounded as in `_cover_by_quadrangle`
        values[k] = blended(values[k], part, lights[k])


@step
def _cover_by_quadrangle(edges, areas, x, y, part):  # type: ignore[no-untyped-def]
    """Write the part of a pixel that a quadrangle covers at each time, as `draw` does: nothing outside its rectangle."""
    for k in range(np.uint64(len(part))):
        a = edges[0, 0, k] * x + edges[0, 1, k] * y + edges[0, 2, k]
        b = edges[1, 0, k] * x + edges[1, 1, k] * y + edges[1, 2, k]
        c = edges[2, 0, k] * x + edges[2, 1, k] * y + edges[2, 2, k]
        d = edges[3, 0, k] * x + edges[3, 1, k] * y + edges[3, 2, k]
        wide = max(min(max(a + 0.5, 0.0), 1.0) + min(max(c + 0.5, 0.0), 1.0) - 1.0, 0.0)
        part[k] = wide * max(min(max(b + 0.5, 0.0), 1.0) + min(max(d + 0.5, 0.0), 1.0) - 1.0, 0.0)
    every = areas[:, len(part) + 1]
    if not (every[0] <= x < every[2] and every[1] <= y < every[3]):
        for k in range(np.uint64(len(part))):
            there = (areas[0, k] <= x) & (x < areas[2, k]) & (areas[1, k] <= y) & (y < areas[3, k])
            part[k] = part[k] if there else 0.0


@step
def _blend(part, lights, values):  # type: ignore[no-untyped-def]
    """Blend a shape into a pixel of which it covers a part at each time."""
    for k in range(np.uint64(len(part))):
        values[k] = blended(values[k], part[k], lights[k])
