# SPDX-License-Identifier: Apache-2.0
"""Kernel: the events of a batch of frames: of the same shapes at successive times, in front of a background at rest.

Most pixels near a moving contour change too little for an event. So it is first estimated how far each pixel's intensity may
go. Only pixels that may leave the bounds within which they make no event are rendered.
The events are those that `draw` and `pixel_events` give frame by frame, to the last bit.
"""

from __future__ import annotations

import numpy as np

from .._numba_private import njit, step
from ._logarithm import logarithm
from ._pixel_kernel import most_events, one_pixel, quiet_bounds
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
_AT_ONCE = 64  # pixels whose memory is fetched in parallel
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
    edges, areas = np.empty((n, 4, 3, times)), np.empty((n, times + 2, 4), np.int64)
    rows = _prepare(shapes, edges, areas, background.shape[0], background.shape[1])
    runs, ways, spans = np.empty((rows, 7), np.int64), np.zeros((n, 2, 4, 2)), np.empty((4, len(background)))
    runs = runs[: _find_runs(shapes, edges, areas, ways, spans, runs)]
    lights = np.empty((n, times))
    lights[:] = shapes[:, :, INTENSITY].T
    _estimate(runs, shapes, lights, edges, areas, ways, background, dark, bright)
    _, low, high, states = pixels
    link = np.empty(len(own), np.int64)
    restless = np.empty(len(own) + _count(runs) + 1, np.int64)
    spontaneous, n = _find_restless(runs, low, high, dark, bright, ids, own, link, head, restless)
    restless = restless[:n]
    values, hides = np.empty((n, times)), np.full(n + 1, -1)
    _fill(restless, background, values)
    _render(runs, shapes, lights, edges, areas, ways, ids, hides, values, np.empty(times))
    awake = restless.copy()
    awake = awake[: _find_awake(restless, spontaneous, values, low, high, ids, awake)]
    keys, n = np.empty(256 + 2 * len(own), np.int64), 0
    for begin in range(0, len(awake), _AT_ONCE):
        most = _most_events(awake[begin : begin + _AT_ONCE], restless, values, states) + len(own)
        if n + most > len(keys):
            longer = np.empty(2 * (n + most), np.int64)
            longer[:n] = keys[:n]
            keys = longer
        for k in awake[begin : begin + _AT_ONCE]:
            x, y, first = restless[k] >> 17, restless[k] >> 1 & 0xFFFF, -1
            if k < spontaneous:
                first, head[y, x] = head[y, x], -1
            n = _events(keys, n, x, y, values[k], times_us, pixels, link, first, own, own_ends, refractory_us)
    return keys[:n]


@step
def _prepare(shapes, edges, areas, height, width):  # type: ignore[no-untyped-def]
    """Write the edges of each quadrangle, x, y and radius of each disc, and of each shape the rectangles of pixels that it may
    touch: at each time, at any, and those at every time. Returns the number of rows of all that are at any time."""
    times, rows = len(shapes), 0
    for i in range(shapes.shape[1]):
        some, every = areas[i, times], areas[i, times + 1]
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
            areas[i, k, 0], areas[i, k, 1], areas[i, k, 2], areas[i, k, 3] = left, top, right, bottom
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
def _find_runs(shapes, edges, areas, ways, spans, runs):  # type: ignore[no-untyped-def]
    """Write the runs, shape by shape, and `ways`; returns their number.

    `ways` (n, 2, 4, 2): in the first and the last row of each shape, how far each edge may come in, and go out, after the first
    time. In a row between, it is at most what is between. Of a disc only the first is used.
    """
    n, times = 0, len(shapes)
    for i in range(shapes.shape[1]):
        left, top, right, bottom = areas[i, times]
        if not (left < right and top < bottom):
            continue
        every = areas[i, times + 1]
        if shapes[0, i, KIND] == DISC:
            ways[i, 0, 0, 0] = _disc_move(shapes, i)
            _disc_spans(shapes[0, i], ways[i, 0, 0, 0], left, right, top, bottom, spans)
        else:
            for end, y in enumerate((top, bottom - 1)):
                _find_ways(edges[i], left, y, ways[i, end])
                _find_ways(edges[i], right - 1, y, ways[i, end])
            at_top, at_bottom = 0.0, 0.0
            for edge in range(4):
                at_top = max(at_top, ways[i, 0, edge, 0], ways[i, 0, edge, 1])
                at_bottom = max(at_bottom, ways[i, 1, edge, 0], ways[i, 1, edge, 1])
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
def _estimate(runs, shapes, lights, edges, areas, ways, background, dark, bright):  # type: ignore[no-untyped-def]
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
        every = areas[i, lights.shape[1] + 1]
        # Where the rectangles of the shape end, its contour may end abruptly.
        left, right = (every[0], every[2]) if every[1] <= runs[r, _ROW] < every[3] else (past, past)
        if shapes[0, i, KIND] == DISC:
            _bound_disc(shapes[0, i], ways[i, 0, 0, 0], dark[y], bright[y], y, begin, past, low, high)
        else:
            row = _share(areas[i, lights.shape[1]], runs[r, _ROW])
            _bound_quadrangle(edges[i], ways[i], row, dark[y], bright[y], y, begin, whole_begin, left, right, low, high)
            _bound_quadrangle(edges[i], ways[i], row, dark[y], bright[y], y, whole_past, past, left, right, low, high)
        for x in range(np.uint64(whole_begin), np.uint64(whole_past)):
            dark[y, x], bright[y, x] = low, high


@step
def _bound_disc(shape, move, dark, bright, y, begin, past, low, high):  # type: ignore[no-untyped-def]
    """Blend the bounds of a disc of intensity `low` to `high`, which may move so far, into those of pixels of a row."""
    for x in range(np.uint64(begin), np.uint64(past)):
        within = shape[X + 1] - np.hypot(x - shape[X], y - shape[Y]) + 0.5
        least, most = np.float32(min(max(within - move, 0.0), 1.0)), np.float32(min(max(within + move, 0.0), 1.0))
        to_low, to_high = low - dark[x], high - bright[x]
        dark[x] += min(least * to_low, most * to_low)
        bright[x] += max(least * to_high, most * to_high)


@step
def _bound_quadrangle(edges, ways, row, dark, bright, y, begin, past, left, right, low, high):  # type: ignore[no-untyped-def]
    """Blend the bounds of a quadrangle of intensity `low` to `high` into those of pixels of a row, which is a part of the way
    from its first row to its last. It may be nowhere in pixels that are not from `left` to `right`."""
    if begin >= past:
        return
    a, b, c, d = (edges[0, 0, 0], edges[1, 0, 0], edges[2, 0, 0], edges[3, 0, 0])
    a0, b0 = edges[0, 1, 0] * y + edges[0, 2, 0] + 0.5, edges[1, 1, 0] * y + edges[1, 2, 0] + 0.5
    c0, d0 = edges[2, 1, 0] * y + edges[2, 2, 0] + 0.5, edges[3, 1, 0] * y + edges[3, 2, 0] + 0.5
    a_in, a_out = _between(ways, 0, row)
    b_in, b_out = _between(ways, 1, row)
    c_in, c_out = _between(ways, 2, row)
    d_in, d_out = _between(ways, 3, row)
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
def _share(area, y):  # type: ignore[no-untyped-def]
    """Which part of the way from the first row of a rectangle to its last a row is."""
    return (y - area[1]) / max(area[3] - 1 - area[1], 1)


@step
def _between(ways, edge, row):  # type: ignore[no-untyped-def]
    """How far an edge may come in, and go out, in a row."""
    return (
        ways[0, edge, 0] + row * (ways[1, edge, 0] - ways[0, edge, 0]),
        ways[0, edge, 1] + row * (ways[1, edge, 1] - ways[0, edge, 1]),
    )


@step
def _count(runs):  # type: ignore[no-untyped-def]
    """How many pixels are in the runs."""
    pixels = 0
    for r in range(len(runs)):
        pixels += runs[r, _PAST] - runs[r, _BEGIN]
    return pixels


@step
def _find_restless(runs, low, high, dark, bright, ids, own, link, head, restless):  # type: ignore[no-untyped-def]
    """Write the pixels that may make events, as x << 17 | y << 1, and their numbers to `ids`; returns how many have spontaneous
    events, which `link` and `head` list and which come first, and how many they are."""
    n = 0
    for i in range(len(own) - 1, -1, -1):
        x, y = own[i].x, own[i].y
        link[i] = head[y, x]
        head[y, x] = i
        if ids[y, x] < 0:
            restless[n], ids[y, x] = x << 17 | y << 1, n
            n += 1
    spontaneous = n
    for r in range(len(runs)):
        y = np.uint64(runs[r, _ROW])
        for x in range(np.uint64(runs[r, _BEGIN]), np.uint64(runs[r, _PAST])):
            least, most, slack = dark[y, x], bright[y, x], np.float32(_ROUNDING) * bright[y, x]
            quiet = (low[y, x] < least - slack) & (most + slack < high[y, x]) | (least == most)
            is_new = (not quiet) & (ids[y, x] < 0)
            restless[n] = np.int64(x) << 17 | runs[r, _ROW] << 1
            ids[y, x] = n if is_new else ids[y, x]
            n += is_new
    return spontaneous, n


@step
def _fill(restless, background, values):  # type: ignore[no-untyped-def]
    """Write the value of the background to those of each restless pixel."""
    for k in range(len(restless)):
        x, y = np.uint64(restless[k] >> 17), np.uint64(restless[k] >> 1 & 0xFFFF)
        light = background[y, x]
        for j in range(np.uint64(values.shape[1])):
            values[k, j] = light


@step
def _find_awake(restless, spontaneous, values, low, high, ids, awake):  # type: ignore[no-untyped-def]
    """Write the numbers of the restless pixels that leave their bounds, or have spontaneous events; returns how many they are.
    Clears `ids`."""
    n = 0
    for k in range(len(restless)):
        x, y = np.uint64(restless[k] >> 17), np.uint64(restless[k] >> 1 & 0xFFFF)
        ids[y, x] = -1
        least, most, beyond = low[y, x], high[y, x], 0
        for j in range(np.uint64(1), np.uint64(values.shape[1])):
            beyond += not ((least < values[k, j]) & (values[k, j] < most))
        awake[n] = k
        n += (beyond > 0) | (k < spontaneous)
    return n


@step
def _most_events(awake, restless, values, states):  # type: ignore[no-untyped-def]
    """An upper bound for the events of some pixels, without spontaneous ones. Pixels are independent here, so their memory is
    fetched in parallel."""
    most = 0
    for k in awake:
        way, least = 0.0, values[k, 0]
        for j in range(1, values.shape[1]):
            way, least = way + abs(values[k, j] - values[k, j - 1]), min(least, values[k, j])
        most += most_events(states, restless[k] >> 1 & 0xFFFF, restless[k] >> 17, way / least, values.shape[1] - 1)
    return most


@step
def _events(keys, n, x, y, values, times_us, pixels, link, first, own, own_ends, refractory_us):  # type: ignore[no-untyped-def]
    """Append the events of one pixel, whose first spontaneous event is `first`, and return the new count."""
    _, low, high, states = pixels
    least, most = low[y, x], high[y, x]
    level, known = 0.0, -1  # log intensity at a time
    for k in range(1, len(values)):
        past = own_ends[k - 1]
        due = 0 <= first < past
        if not due and (values[k] == values[k - 1] or (least < values[k] and values[k] < most)):
            continue
        before = level if known == k - 1 else logarithm(values[k - 1])
        level, known = logarithm(values[k]), k
        n, first = one_pixel(
            keys, n, x, y, before, level, states, link, first, past, own, times_us[k - 1] - times_us[0] + k,
            float(times_us[k - 1]), float(times_us[k] - times_us[k - 1]), refractory_us,
        )  # fmt: skip
        least, most = quiet_bounds(states, y, x, True)
        least, most = np.float32(least), np.float32(most)
    low[y, x], high[y, x] = least, most
    return n


@step
def _render(runs, shapes, lights, edges, areas, ways, ids, hides, values, part):  # type: ignore[no-untyped-def]
    """Blend the shapes into the `values` of the restless pixels. `hides`: -1 per pixel and once more."""
    for r in range(len(runs)):
        for x in range(runs[r, _WHOLE_BEGIN], runs[r, _WHOLE_PAST]):
            hides[ids[runs[r, _ROW], x]] = r  # the last run that covers the pixel as a whole at all times
    for r in range(len(runs)):
        y, i = runs[r, _ROW], runs[r, _SHAPE]
        row = _share(areas[i, len(part)], y)
        for x in range(runs[r, _BEGIN], runs[r, _PAST]):
            k = ids[y, x]
            if k < 0 or hides[k] > r:
                continue
            if hides[k] == r:
                for j in range(len(part)):
                    values[k, j] = lights[i, j]
            else:
                if shapes[0, i, KIND] == DISC:
                    _cover_by_disc(edges[i, 0], ways[i, 0, 0, 0] == 0.0, x, y, part)
                elif _stays_outside(edges[i], ways[i], row, x, y):
                    continue
                else:
                    _cover_by_quadrangle(edges[i], ways[i], row, x, y, part)
                _blend(part, lights[i], areas[i], x, y, values[k])


@step
def _cover_by_disc(path, is_still, x, y, part):  # type: ignore[no-untyped-def]
    """Write the part of a pixel that a disc covers at each time, as `draw` does. `path`: its x, y and radius at each time."""
    for k in range(1 if is_still else len(part)):
        across, down, radius = x - path[0, k], y - path[1, k], path[2, k]
        square = across * across + down * down
        if square >= (radius + 0.5 + MARGIN) ** 2:
            part[k] = 0.0
        elif square < max(radius - 0.5 - MARGIN, 0.0) ** 2:
            part[k] = 1.0
        else:
            part[k] = min(max(radius - np.hypot(across, down) + 0.5, 0.0), 1.0)
    if is_still:
        for k in range(1, len(part)):
            part[k] = part[0]


@step
def _cover_by_quadrangle(edges, ways, row, x, y, part):  # type: ignore[no-untyped-def]
    """Write the part of a pixel that a quadrangle covers at each time, as `draw` does."""
    for k in range(np.uint64(len(part))):
        part[k] = 1.0
    for edge in range(2):
        there = edge + 2
        if _stays_within(edges, ways, edge, row, x, y):
            if not _stays_within(edges, ways, there, row, x, y):
                _clip(edges[there], x, y, part)
        elif _stays_within(edges, ways, there, row, x, y):
            _clip(edges[edge], x, y, part)
        else:
            _clip_twice(edges[edge], edges[there], x, y, part)


@step
def _stays_within(edges, ways, edge, row, x, y):  # type: ignore[no-untyped-def]
    """Whether a pixel is within an edge of a quadrangle as a whole at every time."""
    here = edges[edge, 0, 0] * x + edges[edge, 1, 0] * y + edges[edge, 2, 0]
    return here - _between(ways, edge, row)[0] >= 0.5 + MARGIN


@step
def _stays_outside(edges, ways, row, x, y):  # type: ignore[no-untyped-def]
    """Whether a pixel is outside an edge of a quadrangle as a whole at every time."""
    for edge in range(4):
        here = edges[edge, 0, 0] * x + edges[edge, 1, 0] * y + edges[edge, 2, 0]
        if here + _between(ways, edge, row)[1] <= -0.5 - MARGIN:
            return True
    return False


@step
def _clip(edge, x, y, part):  # type: ignore[no-untyped-def]
    """Multiply by the part of a pixel within an edge, at each time; the pixel is within the opposite edge."""
    for k in range(np.uint64(len(part))):
        a = edge[0, k] * x + edge[1, k] * y + edge[2, k]
        part[k] *= min(max(a + 0.5, 0.0), 1.0) + 1.0 - 1.0  # rounded as in `_clip_twice`


@step
def _clip_twice(edge, opposite, x, y, part):  # type: ignore[no-untyped-def]
    """Multiply by the part of a pixel within two opposite edges, at each time."""
    for k in range(np.uint64(len(part))):
        a = edge[0, k] * x + edge[1, k] * y + edge[2, k]
        b = opposite[0, k] * x + opposite[1, k] * y + opposite[2, k]
        part[k] *= max(min(max(a + 0.5, 0.0), 1.0) + min(max(b + 0.5, 0.0), 1.0) - 1.0, 0.0)


@step
def _blend(part, lights, areas, x, y, values):  # type: ignore[no-untyped-def]
    """Blend a shape into a pixel; outside its rectangle it covers nothing."""
    every = areas[len(part) + 1]
    if not (every[0] <= x < every[2] and every[1] <= y < every[3]):
        for k in range(len(part)):
            if not (areas[k, 0] <= x < areas[k, 2] and areas[k, 1] <= y < areas[k, 3]):
                part[k] = 0.0
    for k in range(np.uint64(len(part))):
        values[k] = blended(values[k], part[k], lights[k])
