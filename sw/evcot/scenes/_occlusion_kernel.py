# SPDX-License-Identifier: Apache-2.0
"""Kernel: the hidden part of each object, sampled on horizontal lines.

On each of `_LINES` lines the covered intervals are exact; there are no samples between the lines, so the error of each straight
edge along the lines is at most half a line: 0.8 % of the object's height.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .._numba_private import step
from ._render_kernel import bounds
from .shapes import DISC, KIND, OBJECT, X, Y

__all__ = ["hidden_at", "hidden_parts"]

_LINES = 64


@njit(cache=True, nogil=True)
def hidden_at(shapes, objects, width, height):  # type: ignore[no-untyped-def]
    """`hidden_parts` of each moment: of (k, n, columns) shapes and (k, m) objects, (k, m)."""
    hidden = np.empty(objects.shape)
    for moment in range(len(shapes)):
        hidden[moment] = hidden_parts(shapes[moment], objects[moment], width, height)
    return hidden


@njit(cache=True, nogil=True)
def hidden_parts(shapes, objects, width, height):  # type: ignore[no-untyped-def]
    """For each object, the part of its area that is behind later shapes of other objects, or outside the sensor; 1 for an
    object without area."""
    hidden = np.ones(len(objects))
    for k in range(len(objects)):
        first, past = 0, 0
        for i in range(len(shapes)):
            if shapes[i, OBJECT] == objects[k]:
                first, past = (i if past == 0 else first), i + 1
        if past:
            hidden[k] = _hidden_part(shapes, first, past, width, height)
    return hidden


@njit(cache=True, nogil=True)
def _hidden_part(shapes, first, past, width, height):  # type: ignore[no-untyped-def]
    left, top, right, bottom = bounds(shapes[first])
    for i in range(first + 1, past):
        a, b, c, d = bounds(shapes[i])
        left, top, right, bottom = min(left, a), min(top, b), max(right, c), max(bottom, d)
    whole = left >= -0.5 and top >= -0.5 and right <= width - 0.5 and bottom <= height - 0.5
    nearer = np.empty(len(shapes) - past, np.int64)
    n = 0
    for i in range(past, len(shapes)):
        a, b, c, d = bounds(shapes[i])
        if a < right and c > left and b < bottom and d > top:
            nearer[n] = i
            n += 1
    if whole and n == 0:
        return 0.0
    own, covers, all_on_line = np.empty((past - first, 2)), np.empty((n, 2)), np.empty((past - first + n, 2))
    area, seen = 0.0, 0.0
    for line in range(_LINES):
        y = top + (line + 0.5) / _LINES * (bottom - top)
        mine, others = 0, 0
        for i in range(first, past):
            mine += _stretch(shapes[i], y, own[mine])
        area += _covered(own[:mine], -np.inf, np.inf)
        if -0.5 <= y <= height - 0.5:
            for i in range(n):
                others += _stretch(shapes[nearer[i]], y, covers[others])
            all_on_line[:mine], all_on_line[mine : mine + others] = own[:mine], covers[:others]
            seen += _covered(all_on_line[: mine + others], -0.5, width - 0.5) - _covered(covers[:others], -0.5, width - 0.5)
    return 1.0 - seen / area if area > 0 else 1.0


@step
def _covered(stretches, low, high):  # type: ignore[no-untyped-def]
    """Length of the union of the intervals within low to high; sorts the intervals."""
    for i in range(1, len(stretches)):
        begin, end = stretches[i, 0], stretches[i, 1]
        at = i
        while at > 0 and stretches[at - 1, 0] > begin:
            stretches[at, 0], stretches[at, 1] = stretches[at - 1, 0], stretches[at - 1, 1]
            at -= 1
        stretches[at, 0], stretches[at, 1] = begin, end
    length, reached = 0.0, low
    for i in range(len(stretches)):
        begin, end = max(stretches[i, 0], reached), min(stretches[i, 1], high)
        if end > begin:
            length += end - begin
            reached = end
    return length


@step
def _stretch(shape, y, stretch):  # type: ignore[no-untyped-def]
    """Write the interval in which a shape covers the line at y to `stretch`, and return True, if it does."""
    low, high = np.inf, -np.inf
    if shape[KIND] == DISC:
        across = shape[X + 1] ** 2 - (y - shape[Y]) ** 2
        if across > 0:
            low, high = shape[X] - np.sqrt(across), shape[X] + np.sqrt(across)
    else:
        for i in range(4):
            j = (i + 1) % 4
            y0, y1 = shape[Y + i], shape[Y + j]
            if (y0 <= y) != (y1 <= y):
                x = shape[X + i] + (y - y0) / (y1 - y0) * (shape[X + j] - shape[X + i])
                low, high = min(low, x), max(high, x)
    if low < high:
        stretch[0], stretch[1] = low, high
        return True
    return False
