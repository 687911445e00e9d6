# SPDX-License-Identifier: Apache-2.0
"""Kernel: the hidden part of each object, sampled on horizontal lines.

On each of `_LINES` lines the covered intervals are exact; there are no samples between the lines, so the error of each straight
edge along the lines is at most half a line: 0.8 % of the object's height.
"""

from __future__ import annotations

import numpy as np

from .._numba_private import njit, step
from ._render_kernel import bounds
from .shapes import DISC, KIND, OBJECT, X, Y

__all__ = ["hidden_at", "hidden_parts"]

_LINES = 64


@njit(cache=True, nogil=True)
def hidden_parts(shapes, objects, width, height):  # type: ignore[no-untyped-def]
    """For each object, the part of its area that is behind later shapes of other objects, or outside the sensor; 1 for an
    object without area."""
    return hidden_at(shapes, np.array([len(shapes)]), objects, np.array([len(objects)]), width, height)


@njit(cache=True, nogil=True)
def hidden_at(shapes, shape_ends, objects, object_ends, width, height):  # type: ignore[no-untyped-def]
    """`hidden_parts` of each moment: of (n, columns) shapes and (m,) objects of all moments, one after the other, and the end
    of each moment in these; (m,)."""
    most, begin = 0, 0
    for end in shape_ends:
        most, begin = max(most, end - begin), end
    work = (
        np.empty((2, most), np.int64),
        np.empty(_LINES),
        np.empty((2, _LINES)),
        np.empty((_LINES, most + 1, 3)),
        np.empty((_LINES, most + 1, 3)),
        np.empty((2, _LINES), np.int64),
        np.full((1, 2), np.inf),
        np.empty((most, 4)),
    )
    hidden = np.ones(len(objects))
    _hide(shapes, shape_ends, objects, object_ends, width, height, work, hidden)
    return hidden


@step
def _hide(shapes, shape_ends, objects, object_ends, width, height, work, hidden):  # type: ignore[no-untyped-def]
    """Write what `hidden_at` returns, where it is not 1."""
    begin, k = 0, 0
    for moment in range(len(shape_ends)):
        its = shapes[begin : shape_ends[moment]]
        begin, boxes = shape_ends[moment], work[-1]
        for i in range(len(its)):
            boxes[i, 0], boxes[i, 1], boxes[i, 2], boxes[i, 3] = bounds(its[i])
        while k < object_ends[moment]:
            first, past = 0, 0
            for i in range(len(its)):
                if its[i, OBJECT] == objects[k]:
                    first, past = (i if past == 0 else first), i + 1
            if past:
                hidden[k] = _hidden_part(its, first, past, width, height, work)
            k += 1


@step
def _hidden_part(shapes, first, past, width, height, work):  # type: ignore[no-untyped-def]
    order, ys, ends, own, covers, counts, nothing, boxes = work
    left, top, right, bottom = boxes[first]
    for i in range(first + 1, past):
        a, b, c, d = boxes[i]
        left, top, right, bottom = min(left, a), min(top, b), max(right, c), max(bottom, d)
    whole = left >= -0.5 and top >= -0.5 and right <= width - 0.5 and bottom <= height - 0.5
    n = 0
    for i in range(past, len(shapes)):
        a, b, c, d = boxes[i]
        if a < right and c > left and b < bottom and d > top:
            n = _insert(order[1], n, i, boxes)
    if whole and n == 0:
        return 0.0
    for line in range(_LINES):
        ys[line] = top + (line + 0.5) / _LINES * (bottom - top)
        counts[0, line] = counts[1, line] = 0
    mine = 0
    for i in range(first, past):
        mine = _insert(order[0], mine, i, boxes)
    for i in order[0, :mine]:
        _cut(shapes[i], i, boxes[i], ys, ends, own, counts[0])
    for i in order[1, :n]:
        _cut(shapes[i], i, boxes[i], ys, ends, covers, counts[1])
    area, seen = 0.0, 0.0
    for line in range(_LINES):
        own_px = _merge(own[line], counts[0, line])
        area += own_px
        if -0.5 <= ys[line] <= height - 0.5:
            if counts[1, line] == 0:
                inside = left >= -0.5 and right <= width - 0.5
                seen += own_px if inside else _covered(own[line], nothing, width)
                continue
            _merge(covers[line], counts[1, line])
            seen += _covered(own[line], covers[line], width) - _covered(nothing, covers[line], width)
    return 1.0 - seen / area if area > 0 else 1.0


@step
def _insert(order, n, i, boxes):  # type: ignore[no-untyped-def]
    """Insert a shape into the first n, which are in the order of their left ends; returns the new number."""
    at = n
    while at > 0 and boxes[order[at - 1], 0] > boxes[i, 0]:
        order[at] = order[at - 1]
        at -= 1
    order[at] = i
    return n + 1


@step
def _merge(stretches, n):  # type: ignore[no-untyped-def]
    """Sort n intervals, those of equal begins by their shapes, remove those that the ones before cover, and append (inf, inf);
    returns the length of their union."""
    for i in range(1, n):
        begin, end, shape = stretches[i]
        at = i
        while at > 0 and (stretches[at - 1, 0] > begin or (stretches[at - 1, 0] == begin and stretches[at - 1, 2] > shape)):
            for column in range(3):
                stretches[at, column] = stretches[at - 1, column]
            at -= 1
        stretches[at, 0], stretches[at, 1], stretches[at, 2] = begin, end, shape
    length, reached, kept = 0.0, -np.inf, 0
    for i in range(n):
        begin, end = stretches[i, 0], stretches[i, 1]
        if end > reached:
            stretches[kept, 0], stretches[kept, 1] = begin, end
            length, reached, kept = length + (end - max(begin, reached)), end, kept + 1
    stretches[kept, 0] = stretches[kept, 1] = np.inf
    return length


@step
def _covered(some, others, width):  # type: ignore[no-untyped-def]
    """Length on the sensor of the union of the intervals of two lists, as of `_merge`."""
    length, reached, high, i, j = 0.0, -0.5, width - 0.5, 0, 0
    while True:
        if some[i, 0] <= others[j, 0]:
            begin, end = some[i, 0], some[i, 1]
            i += 1
        else:
            begin, end = others[j, 0], others[j, 1]
            j += 1
        if begin >= high:
            return length
        begin, end = max(begin, reached), min(end, high)
        if end > begin:
            length += end - begin
            reached = end


@step
def _cut(shape, number, box, ys, ends, stretches, counts):  # type: ignore[no-untyped-def]
    """Append the interval in which a shape, of these bounds, covers each line to the `stretches` of that line. `ends`: work
    space."""
    first, past = _lines_between(ys, box[1], box[3])
    low, high = ends[0], ends[1]
    for line in range(np.uint64(first), np.uint64(past)):
        low[line], high[line] = np.inf, -np.inf
    if shape[KIND] == DISC:
        for line in range(first, past):
            across = shape[X + 1] ** 2 - (ys[line] - shape[Y]) ** 2
            if across > 0 and box[1] <= ys[line] <= box[3]:
                low[line], high[line] = shape[X] - np.sqrt(across), shape[X] + np.sqrt(across)
    else:
        for i in range(4):
            j = (i + 1) % 4
            x0, y0, y1 = shape[X + i], shape[Y + i], shape[Y + j]
            way = shape[X + j] - x0
            if y0 == y1:
                continue
            begin, end = _lines_between(ys, min(y0, y1), max(y0, y1))
            for line in range(np.uint64(begin), np.uint64(end)):
                y = ys[line]
                crosses = (y0 <= y) ^ (y1 <= y)
                x = x0 + (y - y0) / (y1 - y0) * way
                least, most = min(low[line], x), max(high[line], x)
                low[line] = least if crosses else low[line]
                high[line] = most if crosses else high[line]
    for line in range(np.uint64(first), np.uint64(past)):
        begin, end, n = low[line], high[line], counts[line]
        if n > 0:
            last = stretches[line, n - 1]
            if end <= last[1] and (begin > last[0] or (begin == last[0] and number > last[2])):
                continue  # `_merge` would remove it
        if begin < end:
            stretch = stretches[line, n]
            stretch[0], stretch[1], stretch[2] = begin, end, number
            counts[line] = n + 1


@step
def _lines_between(ys, top, bottom):  # type: ignore[no-untyped-def]
    """The lines, half open, from the first that may be below a height to the last that may be above another."""
    if not ys[_LINES - 1] > ys[0]:
        return 0, _LINES
    lines_per_px = (_LINES - 1) / (ys[_LINES - 1] - ys[0])
    begin, past = (top - ys[0]) * lines_per_px - 1.0, (bottom - ys[0]) * lines_per_px + 2.0
    return int(min(max(begin, 0.0), _LINES)), int(min(max(past, 0.0), _LINES))
