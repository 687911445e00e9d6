# SPDX-License-Identifier: Apache-2.0
"""Kernels: render shapes into a picture of linear intensity, and find the regions to be redrawn.

Contours are anti-aliased: a pixel's coverage rises from 0 at half a pixel outside to 1 at half a pixel inside, measured across
the edge; intensities are mixed by coverage.
"""

from __future__ import annotations

import numpy as np

from .._numba_private import njit, step
from .shapes import COLUMNS, DISC, INTENSITY, KIND, OBJECT, QUADRANGLE, X, Y

__all__ = [
    "HIGH", "LOW", "MARGIN", "STILL", "WHOLE_HIGH", "WHOLE_LOW", "blended", "bounds", "changes", "displacement", "draw",
    "edges_of", "pixels_within", "row_spans", "shift_texture",
]  # fmt: skip

MARGIN = 1e-3  # px, of shortcuts: rounding never decides
STILL = (0.0, 0.0)  # slack of `row_spans`
LOW, HIGH, WHOLE_LOW, WHOLE_HIGH = range(4)  # see `row_spans`


@njit(cache=True, nogil=True)
def bounds(shape):  # type: ignore[no-untyped-def]
    """left, top, right, bottom of a shape's contour."""
    if shape[KIND] == DISC:
        x, y, radius = shape[X], shape[Y], shape[X + 1]
        return x - radius, y - radius, x + radius, y + radius
    left, top, right, bottom = np.inf, np.inf, -np.inf, -np.inf
    for i in range(4):
        left, right = min(left, shape[X + i]), max(right, shape[X + i])
        top, bottom = min(top, shape[Y + i]), max(bottom, shape[Y + i])
    return left, top, right, bottom


@step
def pixels_within(left, top, right, bottom, width, height):  # type: ignore[no-untyped-def]
    """The pixels touched by a contour within these bounds: left, top, right, bottom, half open; right < left if none."""
    left = min(max(left - 0.5, 0.0), float(width))
    top = min(max(top - 0.5, 0.0), float(height))
    right = min(max(right + 0.5, -1.0), float(width) - 1)
    bottom = min(max(bottom + 0.5, -1.0), float(height) - 1)
    return int(np.ceil(left)), int(np.ceil(top)), int(np.floor(right)) + 1, int(np.floor(bottom)) + 1


@njit(cache=True, nogil=True)
def changes(before, after, width, height):  # type: ignore[no-untyped-def]
    """(n, 4) pixel rectangles (left, top, right, bottom, half open) where shapes may have changed the picture, of every object
    that was or is on the sensor."""
    (least, most), (low, high) = _numbers(before), _numbers(after)
    least, most = min(least, low), max(most, high)
    objects = int(most - least) + 1
    boxes = np.empty((2, objects, 4))
    first, count = np.zeros((2, objects), np.int64), np.zeros((2, objects), np.int64)  # its first shape, and how many
    _bound(before, least, boxes[0], first[0], count[0])
    _bound(after, least, boxes[1], first[1], count[1])
    rectangles = np.empty((_most_rectangles(boxes, height), 4), np.int64)
    work = np.empty((2, 4, 3)), np.empty((2, 4, height))
    return rectangles[: _changes(before, after, boxes, first, count, rectangles, work, width, height)]


@step
def _numbers(shapes):  # type: ignore[no-untyped-def]
    """The lowest and the highest number of an object; zeros without shapes."""
    if not len(shapes):
        return 0.0, 0.0
    low = high = shapes[0, OBJECT]
    for i in range(1, len(shapes)):
        low, high = min(low, shapes[i, OBJECT]), max(high, shapes[i, OBJECT])
    return low, high


@step
def _bound(shapes, least, boxes, first, count):  # type: ignore[no-untyped-def]
    """Write the bounds of each object, counted from `least`, the index of its first shape, and how many it has."""
    for k in range(len(boxes)):
        boxes[k, 0] = boxes[k, 1] = np.inf
        boxes[k, 2] = boxes[k, 3] = -np.inf
    for i in range(len(shapes)):
        k = int(shapes[i, OBJECT] - least)
        if count[k] == 0:
            first[k] = i
        count[k] += 1
        left, top, right, bottom = bounds(shapes[i])
        boxes[k, 0], boxes[k, 1] = min(boxes[k, 0], left), min(boxes[k, 1], top)
        boxes[k, 2], boxes[k, 3] = max(boxes[k, 2], right), max(boxes[k, 3], bottom)


@step
def _most_rectangles(boxes, height):  # type: ignore[no-untyped-def]
    """An upper bound for the number of rectangles of `_changes`: a row each, of all objects."""
    rows = 0.0
    for k in range(boxes.shape[1]):
        top, bottom = min(boxes[0, k, 1], boxes[1, k, 1]), max(boxes[0, k, 3], boxes[1, k, 3])
        rows += max(min(bottom, height) - max(top, -1.0), 0.0) + 3.0
    return int(rows)


@step
def _changes(before, after, boxes, first, count, rectangles, work, width, height):  # type: ignore[no-untyped-def]
    """Write what `changes` returns; returns the number of rectangles."""
    edges, spans = work
    n = 0
    for k in range(boxes.shape[1]):
        left, top, right, bottom = pixels_within(
            min(boxes[0, k, 0], boxes[1, k, 0]), min(boxes[0, k, 1], boxes[1, k, 1]),
            max(boxes[0, k, 2], boxes[1, k, 2]), max(boxes[0, k, 3], boxes[1, k, 3]), width, height,
        )  # fmt: skip
        if not (left < right and top < bottom):
            continue
        i, j = first[0, k], first[1, k]
        if count[0, k] == 1 and count[1, k] == 1 and before[i, KIND] == QUADRANGLE and after[j, KIND] == QUADRANGLE:
            edges_of(before[i], edges[0])
            edges_of(after[j], edges[1])
            row_spans(edges[0], STILL, left, right, top, bottom, spans[0])
            row_spans(edges[1], STILL, left, right, top, bottom, spans[1])
            for row in range(bottom - top):
                begin, past = (
                    int(min(spans[0, LOW, row], spans[1, LOW, row])),
                    int(max(spans[0, HIGH, row], spans[1, HIGH, row])),
                )
                if begin < past:
                    rectangles[n, 0], rectangles[n, 1], rectangles[n, 2], rectangles[n, 3] = (
                        begin,
                        top + row,
                        past,
                        top + row + 1,
                    )
                    n += 1
        else:
            rectangles[n, 0], rectangles[n, 1], rectangles[n, 2], rectangles[n, 3] = left, top, right, bottom
            n += 1
    return n


@njit(cache=True, nogil=True)
def displacement(before, after, width, height):  # type: ignore[no-untyped-def]
    """The largest displacement, in pixels, of any contour across itself, where it is on the sensor, excluding objects that
    appear or vanish; and whether the shapes are the same ones in the same order."""
    edges, moved, alike = np.empty((4, 3)), 0.0, len(before) == len(after)
    for i in range(len(before) if alike else 0):
        alike = alike and before[i, OBJECT] == after[i, OBJECT] and before[i, KIND] == after[i, KIND]
    if alike:
        for i in range(len(after) - 1, -1, -1):  # the last are often the nearest, which move fastest
            if _most_way(before[i], after[i]) > moved:
                moved = max(moved, _moved(before[i], after[i], edges, width, height))
        return moved, True
    least = most = 0
    for i in range(len(before)):
        least, most = min(least, int(before[i, OBJECT])), max(most, int(before[i, OBJECT]))
    first, count = np.zeros(most - least + 1, np.int64), np.zeros(most - least + 1, np.int64)
    for i in range(len(before)):
        k = int(before[i, OBJECT]) - least
        first[k] = i if count[k] == 0 else first[k]
        count[k] += 1
    start = 0
    for j in range(len(after)):
        start = j if j == 0 or after[j, OBJECT] != after[j - 1, OBJECT] else start
        k = int(after[j, OBJECT]) - least
        if 0 <= k < len(count) and j - start < count[k]:
            i = first[k] + j - start
            moved = max(moved, _moved(before[i], after[j], edges, width, height))
    return moved, False


@step
def _most_way(was, now):  # type: ignore[no-untyped-def]
    """An upper bound for `_moved`: no part of a contour moves farther than all coordinates together."""
    way = 0.0
    for k in range(X, COLUMNS):
        way += abs(now[k] - was[k])
    return way * (1.0 + MARGIN)


@step
def _moved(was, now, edges, width, height):  # type: ignore[no-untyped-def]
    """The largest displacement of a contour across itself, in pixels, where it is on the sensor now."""
    if was[KIND] != now[KIND]:
        return 0.0
    left, top, right, bottom = bounds(was)
    a, b, c, d = bounds(now)
    left, top, right, bottom = pixels_within(min(left, a), min(top, b), max(right, c), max(bottom, d), width, height)
    if not (left < right and top < bottom):
        return 0.0
    moved = 0.0
    if now[KIND] == DISC:
        grown = abs(now[X + 1] - was[X + 1])
        moved = max(abs(now[X] - was[X]), abs(now[Y] - was[Y])) + grown
        reach = now[X + 1] + 1.0
        there = -reach < now[X] < width - 1 + reach and -reach < now[Y] < height - 1 + reach
        return moved if there else 0.0
    edges_of(was, edges)
    for edge in range(4):
        a, b, c = edges[edge]
        x, y = now[X + edge], now[Y + edge]
        dx, dy = now[X + (edge + 1) % 4] - x, now[Y + (edge + 1) % 4] - y
        low, high = _within(x, dx, -0.5, width - 0.5, 0.0, 1.0)
        low, high = _within(y, dy, -0.5, height - 0.5, low, high)
        if low <= high and a * a + b * b > 0.0:
            for along in (low, high):
                moved = max(moved, abs(a * (x + along * dx) + b * (y + along * dy) + c))
    return moved


@step
def _within(begin, way, least, most, low, high):  # type: ignore[no-untyped-def]
    """The part of `low` to `high` at which begin + part * way is from `least` to `most`; (1, 0), or such, if there is none."""
    if abs(way) < 1e-12:
        return (low, high) if least <= begin <= most else (1.0, 0.0)
    first, last = (least - begin) / way, (most - begin) / way
    return max(low, min(first, last)), min(high, max(first, last))


@njit(cache=True, nogil=True)
def draw(rectangles, shapes, background, picture):  # type: ignore[no-untyped-def]
    """Redraw rectangles of a picture of linear intensity: `background`, and shapes, the farthest first. What the shapes cover
    outside the rectangles is undefined afterwards."""
    edges, spans = np.empty((4, 3)), np.empty((4, len(picture)))
    _draw(rectangles, shapes, background, picture, edges, spans)


@step
def _draw(rectangles, shapes, background, picture, edges, spans):  # type: ignore[no-untyped-def]
    height, width = picture.shape
    for r in range(len(rectangles)):
        for y in range(np.uint64(rectangles[r, 1]), np.uint64(rectangles[r, 3])):
            for x in range(np.uint64(rectangles[r, 0]), np.uint64(rectangles[r, 2])):
                picture[y, x] = background[y, x]
    for i in range(len(shapes)):
        left, top, right, bottom = bounds(shapes[i])
        first_x, first_y, past_x, past_y = pixels_within(left, top, right, bottom, width, height)
        if first_x < past_x and first_y < past_y:
            if shapes[i, KIND] == DISC:
                _blend_disc(shapes[i], picture, first_x, first_y, past_x, past_y)
            else:
                edges_of(shapes[i], edges)
                row_spans(edges, STILL, first_x, past_x, first_y, past_y, spans)
                _blend_quadrangle(shapes[i], edges, spans, picture, first_y, past_y)


@step
def _blend_disc(shape, picture, first_x, first_y, past_x, past_y):  # type: ignore[no-untyped-def]
    """Blend a disc into a rectangle of a picture."""
    radius, light = shape[X + 1], shape[INTENSITY]
    inside = max(radius - 0.5 - MARGIN, 0.0) ** 2
    for y in range(first_y, past_y):
        down = y - shape[Y]
        for x in range(first_x, past_x):
            across = x - shape[X]
            part = 1.0
            if across * across + down * down >= inside:
                part = min(max(radius - np.sqrt(across * across + down * down) + 0.5, 0.0), 1.0)
            picture[y, x] = blended(picture[y, x], part, light)


@step
def blended(below, part, light):  # type: ignore[no-untyped-def]
    """The intensity of a pixel of which a shape covers a part."""
    return light if part == 1.0 else below + part * (light - below)


@step
def _blend_quadrangle(shape, edges, spans, picture, first_y, past_y):  # type: ignore[no-untyped-def]
    """Blend a quadrangle into rows of a picture. Of a row, only the pixels are looked at that it may cover; those in the
    middle, which it covers as a whole, are its light."""
    light = shape[INTENSITY]
    for y in range(first_y, past_y):
        row = y - first_y
        begin, past = int(spans[LOW, row]), int(spans[HIGH, row])
        whole_begin = max(begin, int(np.ceil(spans[WHOLE_LOW, row])))
        whole_past = min(past, int(np.floor(spans[WHOLE_HIGH, row])) + 1)
        if whole_begin < whole_past:
            for x in range(whole_begin, whole_past):
                picture[y, x] = light
        else:
            whole_begin = whole_past = past
        _blend_pixels(light, edges, picture, y, begin, whole_begin)
        _blend_pixels(light, edges, picture, y, whole_past, past)


@step
def row_spans(edges, slack, first_x, past_x, first_y, past_y, spans):  # type: ignore[no-untyped-def]
    """Of the pixels from `first_x` to `past_x` of each row: begin and end of those that a quadrangle may cover; the first and
    the last that it covers as a whole. Without such pixels the end is not behind the begin, the last before the first.
    `slack`: how far the edges may move, at the first row and more at each further one, in pixels.

    Loops over rows are vectorised: their unsigned indices do not count from the end.
    """
    rows = np.uint64(past_y - first_y)
    for row in range(rows):
        spans[LOW, row] = spans[WHOLE_LOW, row] = first_x
        spans[HIGH, row] = spans[WHOLE_HIGH, row] = past_x
    for edge in range(4):
        a, b, c = edges[edge, 0], edges[edge, 1], edges[edge, 2]
        if a > MARGIN:
            for row in range(rows):
                rest, moves = b * (row + first_y) + c + 0.5, slack[0] + row * slack[1]
                spans[LOW, row] = max(spans[LOW, row], -(rest + moves) / a)
                spans[WHOLE_LOW, row] = max(spans[WHOLE_LOW, row], (1.0 + MARGIN - (rest - moves)) / a)
        elif a < -MARGIN:
            for row in range(rows):
                rest, moves = b * (row + first_y) + c + 0.5, slack[0] + row * slack[1]
                spans[HIGH, row] = min(spans[HIGH, row], -(rest + moves) / a + (1.0 + MARGIN))
                spans[WHOLE_HIGH, row] = min(spans[WHOLE_HIGH, row], (1.0 + MARGIN - (rest - moves)) / a)
        else:  # the edge lies along the row
            for row in range(rows):
                rest, moves = b * (row + first_y) + c + 0.5, slack[0] + row * slack[1]
                if rest + moves < -1.0 - past_x * MARGIN:
                    spans[HIGH, row] = spans[LOW, row]
                if rest - moves < 2.0 + past_x * MARGIN:
                    spans[WHOLE_HIGH, row] = spans[WHOLE_LOW, row] - 1.0


@step
def _blend_pixels(light, edges, picture, y, begin, past):  # type: ignore[no-untyped-def]
    """Blend a quadrangle into pixels of a row."""
    if begin >= past:
        return
    a0, a1, a2, a3 = edges[0, 0], edges[1, 0], edges[2, 0], edges[3, 0]
    b0, b1, b2, b3 = edges[0, 1] * y, edges[1, 1] * y, edges[2, 1] * y, edges[3, 1] * y
    c0, c1, c2, c3 = edges[0, 2], edges[1, 2], edges[2, 2], edges[3, 2]
    last = past - 1
    wide = min(min(a0 * begin, a0 * last) + b0 + c0, min(a2 * begin, a2 * last) + b2 + c2) >= 0.5 + MARGIN
    high = min(min(a1 * begin, a1 * last) + b1 + c1, min(a3 * begin, a3 * last) + b3 + c3) >= 0.5 + MARGIN
    row = np.uint64(y)
    for x in range(np.uint64(begin), np.uint64(past)):
        part = 1.0
        if not wide:  # else all these pixels are within the first and the third edge
            here, there = a0 * x + b0 + c0, a2 * x + b2 + c2
            part = max(min(max(here + 0.5, 0.0), 1.0) + min(max(there + 0.5, 0.0), 1.0) - 1.0, 0.0)
        if not high:
            here, there = a1 * x + b1 + c1, a3 * x + b3 + c3
            part *= max(min(max(here + 0.5, 0.0), 1.0) + min(max(there + 0.5, 0.0), 1.0) - 1.0, 0.0)
        picture[row, x] = blended(picture[row, x], part, light)


@step
def edges_of(shape, edges):  # type: ignore[no-untyped-def]
    """Write (a, b, c) of each edge to `edges`: a x + b y + c is the distance of a point inside the edge, in pixels. Corners may
    be in either orientation."""
    area = 0.0
    for i in range(4):
        j = (i + 1) % 4
        area += shape[X + i] * shape[Y + j] - shape[X + j] * shape[Y + i]
    turn = 1.0 if area > 0 else -1.0
    for i in range(4):
        j = (i + 1) % 4
        dx, dy = shape[X + j] - shape[X + i], shape[Y + j] - shape[Y + i]
        length = np.sqrt(dx * dx + dy * dy)
        if length < 1e-9:
            edges[i, 0], edges[i, 1], edges[i, 2] = 0.0, 0.0, 1.0  # a degenerate edge clips nothing
            continue
        a, b = -turn * dy / length, turn * dx / length
        edges[i, 0], edges[i, 1], edges[i, 2] = a, b, -a * shape[X + i] - b * shape[Y + i]


@njit(cache=True, nogil=True)
def shift_texture(texture, left, top, picture):  # type: ignore[no-untyped-def]
    """Copy the part of a texture with its corner at (left, top), which may be fractional, by bilinear interpolation."""
    column, row = int(np.floor(left)), int(np.floor(top))
    u, v = left - column, top - row
    width = picture.shape[1]
    for y in range(picture.shape[0]):
        above, below = texture[row + y, column : column + width + 1], texture[row + y + 1, column : column + width + 1]
        line = picture[y]
        for x in range(width):
            upper = above[x] * (1 - u) + above[x + 1] * u
            lower = below[x] * (1 - u) + below[x + 1] * u
            line[x] = upper * (1 - v) + lower * v
