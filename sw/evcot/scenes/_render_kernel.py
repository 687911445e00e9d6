# SPDX-License-Identifier: Apache-2.0
"""Kernels: render shapes into a frame of log intensity, and find the regions to be redrawn.

Contours are anti-aliased: a pixel's coverage rises from 0 at half a pixel outside to 1 at half a pixel inside, measured across
the edge; intensities are mixed by coverage, before the logarithm.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .._numba_private import step
from .shapes import DISC, INTENSITY, KIND, OBJECT, X, Y

__all__ = ["bounds", "changes", "draw", "shift_texture"]


@njit(cache=True, nogil=True)
def bounds(shape):  # type: ignore[no-untyped-def]
    """left, top, right, bottom of a shape's contour."""
    if shape[KIND] == DISC:
        x, y, radius = shape[X], shape[Y], shape[X + 1]
        return x - radius, y - radius, x + radius, y + radius
    return shape[X : X + 4].min(), shape[Y : Y + 4].min(), shape[X : X + 4].max(), shape[Y : Y + 4].max()


@step
def _pixels(left, top, right, bottom, width, height):  # type: ignore[no-untyped-def]
    """The pixels touched by a contour within these bounds: left, top, right, bottom, half open; right < left if none."""
    left = min(max(left - 0.5, 0.0), float(width))
    top = min(max(top - 0.5, 0.0), float(height))
    right = min(max(right + 0.5, -1.0), float(width) - 1)
    bottom = min(max(bottom + 0.5, -1.0), float(height) - 1)
    return int(np.ceil(left)), int(np.ceil(top)), int(np.floor(right)) + 1, int(np.floor(bottom)) + 1


@njit(cache=True, nogil=True)
def changes(before, after, width, height):  # type: ignore[no-untyped-def]
    """The regions where shapes may have changed the picture, and the largest displacement.

    Returns (n, 4) pixel rectangles (left, top, right, bottom, half open), one per object that was or is on the sensor, and the
    largest displacement, in pixels, of any side of an object's bounds, excluding objects that appear or vanish.
    """
    least = min(before[:, OBJECT].min() if len(before) else 0.0, after[:, OBJECT].min() if len(after) else 0.0)
    most = max(before[:, OBJECT].max() if len(before) else 0.0, after[:, OBJECT].max() if len(after) else 0.0)
    boxes = np.empty((2, int(most - least) + 1, 4))
    boxes[:, :, :2], boxes[:, :, 2:] = np.inf, -np.inf
    for moment, shapes in enumerate((before, after)):
        for i in range(len(shapes)):
            box = boxes[moment, int(shapes[i, OBJECT] - least)]
            left, top, right, bottom = bounds(shapes[i])
            box[0], box[1] = min(box[0], left), min(box[1], top)
            box[2], box[3] = max(box[2], right), max(box[3], bottom)
    rectangles, n, moved = np.empty((boxes.shape[1], 4), np.int64), 0, 0.0
    for k in range(boxes.shape[1]):
        was, now = boxes[0, k], boxes[1, k]
        if was[0] <= was[2] and now[0] <= now[2]:
            for side in range(4):
                moved = max(moved, abs(now[side] - was[side]))
        left, top, right, bottom = _pixels(
            min(was[0], now[0]), min(was[1], now[1]), max(was[2], now[2]), max(was[3], now[3]), width, height
        )
        if left < right and top < bottom:
            rectangles[n, 0], rectangles[n, 1], rectangles[n, 2], rectangles[n, 3] = left, top, right, bottom
            n += 1
    return rectangles[:n], moved


@njit(cache=True, nogil=True)
def draw(rectangles, shapes, background, scratch, linear, frame):  # type: ignore[no-untyped-def]
    """Redraw rectangles of a frame: `background` (linear) and shapes, the farthest first, into `linear` and its logarithm,
    `frame`. `scratch`: work space of the frame's size."""
    height, width = frame.shape
    places, edges = np.empty((len(shapes), 4), np.int64), np.empty((len(shapes), 4, 3))
    for i in range(len(shapes)):
        left, top, right, bottom = bounds(shapes[i])
        places[i, 0], places[i, 1], places[i, 2], places[i, 3] = _pixels(left, top, right, bottom, width, height)
        if shapes[i, KIND] != DISC:
            _edges(shapes[i], edges[i])
    for r in range(len(rectangles)):
        left, top, right, bottom = rectangles[r]
        scratch[top:bottom, left:right] = background[top:bottom, left:right]
        for i in range(len(shapes)):
            first_x, first_y = max(places[i, 0], left), max(places[i, 1], top)
            past_x, past_y = min(places[i, 2], right), min(places[i, 3], bottom)
            if first_x < past_x and first_y < past_y:
                _blend(shapes[i], edges[i], scratch, first_x, first_y, past_x, past_y)
        for y in range(top, bottom):
            for x in range(left, right):
                if scratch[y, x] != linear[y, x]:
                    linear[y, x] = scratch[y, x]
                    frame[y, x] = np.log(scratch[y, x])


@step
def _blend(shape, edges, picture, first_x, first_y, past_x, past_y):  # type: ignore[no-untyped-def]
    """Blend a shape into a rectangle of a picture."""
    if shape[KIND] == DISC:
        for y in range(first_y, past_y):
            for x in range(first_x, past_x):
                depth = shape[X + 1] - np.hypot(x - shape[X], y - shape[Y])
                part = min(max(depth + 0.5, 0.0), 1.0)
                picture[y, x] += part * (shape[INTENSITY] - picture[y, x])
        return
    for y in range(first_y, past_y):
        for x in range(first_x, past_x):
            part = 1.0
            for pair in range(2):
                here = edges[pair, 0] * x + edges[pair, 1] * y + edges[pair, 2]
                there = edges[pair + 2, 0] * x + edges[pair + 2, 1] * y + edges[pair + 2, 2]
                part *= max(min(max(here + 0.5, 0.0), 1.0) + min(max(there + 0.5, 0.0), 1.0) - 1.0, 0.0)
            if part > 0.0:
                picture[y, x] += part * (shape[INTENSITY] - picture[y, x])


@step
def _edges(shape, edges):  # type: ignore[no-untyped-def]
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
        length = np.hypot(dx, dy)
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
    for y in range(picture.shape[0]):
        for x in range(picture.shape[1]):
            upper = texture[row + y, column + x] * (1 - u) + texture[row + y, column + x + 1] * u
            lower = texture[row + y + 1, column + x] * (1 - u) + texture[row + y + 1, column + x + 1] * u
            picture[y, x] = upper * (1 - v) + lower * v
