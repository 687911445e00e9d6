# SPDX-License-Identifier: Apache-2.0
"""Kernels: render shapes into a frame of log intensity, and find the regions to be redrawn.

Contours are anti-aliased: a pixel's coverage rises from 0 at half a pixel outside to 1 at half a pixel inside, measured across
the edge; intensities are mixed by coverage, before the logarithm.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .._numba_private import step
from .shapes import DISC, INTENSITY, KIND, OBJECT, QUADRANGLE, X, Y

__all__ = ["bounds", "changes", "draw", "shift_texture"]

_APART = 8  # unchanged pixels between two stretches of a row: fewer are part of one
_MARGIN = 1e-3  # px, of shortcuts: rounding never decides
_SQRT_HALF = 0x3FE6A09E667F3BCD  # the bits of sqrt(1/2)
_LN2_HIGH, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
_LOG = (  # coefficients of (log((1 + s) / (1 - s)) - 2 s) / s in powers of s^2
    6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01, 2.222219843214978396e-01,
    1.818357216161805012e-01, 1.531383769920937332e-01, 1.479819860511658591e-01,
)  # fmt: skip


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

    Returns (n, 4) pixel rectangles (left, top, right, bottom, half open), of every object that was or is on the sensor, and the
    largest displacement, in pixels, of any side of an object's bounds, excluding objects that appear or vanish.
    """
    least = min(before[:, OBJECT].min() if len(before) else 0.0, after[:, OBJECT].min() if len(after) else 0.0)
    most = max(before[:, OBJECT].max() if len(before) else 0.0, after[:, OBJECT].max() if len(after) else 0.0)
    boxes = np.empty((2, int(most - least) + 1, 4))
    boxes[:, :, :2], boxes[:, :, 2:] = np.inf, -np.inf
    alone = np.full((2, boxes.shape[1]), -1)  # the shape of each object; -2 if there are several
    for moment, shapes in enumerate((before, after)):
        for i in range(len(shapes)):
            k = int(shapes[i, OBJECT] - least)
            box, alone[moment, k] = boxes[moment, k], i if alone[moment, k] == -1 else -2
            left, top, right, bottom = bounds(shapes[i])
            box[0], box[1] = min(box[0], left), min(box[1], top)
            box[2], box[3] = max(box[2], right), max(box[3], bottom)
    rectangles, n, moved = np.empty((boxes.shape[1] + height, 4), np.int64), 0, 0.0
    edges = np.empty((2, 4, 3))
    for k in range(boxes.shape[1]):
        was, now = boxes[0, k], boxes[1, k]
        if was[0] <= was[2] and now[0] <= now[2]:
            for side in range(4):
                moved = max(moved, abs(now[side] - was[side]))
        left, top, right, bottom = _pixels(
            min(was[0], now[0]), min(was[1], now[1]), max(was[2], now[2]), max(was[3], now[3]), width, height
        )
        if not (left < right and top < bottom):
            continue
        if n + height + boxes.shape[1] > len(rectangles):
            longer = np.empty((2 * (n + height + boxes.shape[1]), 4), np.int64)
            longer[:n] = rectangles[:n]
            rectangles = longer
        i, j = alone[0, k], alone[1, k]
        if i >= 0 and j >= 0 and before[i, KIND] == QUADRANGLE and after[j, KIND] == QUADRANGLE:
            _edges(before[i], edges[0])
            _edges(after[j], edges[1])
            for y in range(top, bottom):
                low_was, high_was, _, _ = _stretch(edges[0], y, left, right)
                low_is, high_is, _, _ = _stretch(edges[1], y, left, right)
                begin, past = int(min(low_was, low_is)), int(max(high_was, high_is))
                if begin < past:
                    rectangles[n, 0], rectangles[n, 1], rectangles[n, 2], rectangles[n, 3] = begin, y, past, y + 1
                    n += 1
        else:
            rectangles[n, 0], rectangles[n, 1], rectangles[n, 2], rectangles[n, 3] = left, top, right, bottom
            n += 1
    return rectangles[:n], moved


@njit(cache=True, nogil=True)
def draw(rectangles, shapes, background, scratch, linear, frame):  # type: ignore[no-untyped-def]
    """Redraw rectangles of a frame: `background` (linear) and shapes, the farthest first, into `linear` and its logarithm,
    `frame`. `scratch`: work space of the frame's size, which only this function writes.

    Returns (n, 4) int64 stretches of rows, as rectangles, that hold every pixel that has changed.
    """
    height, width = frame.shape
    for r in range(len(rectangles)):
        left, top, right, bottom = rectangles[r]
        scratch[top:bottom, left:right] = background[top:bottom, left:right]
    edges = np.empty((4, 3))
    for i in range(len(shapes)):
        left, top, right, bottom = bounds(shapes[i])
        first_x, first_y, past_x, past_y = _pixels(left, top, right, bottom, width, height)
        if first_x < past_x and first_y < past_y:
            if shapes[i, KIND] == DISC:
                _blend_disc(shapes[i], scratch, first_x, first_y, past_x, past_y)
            else:
                _edges(shapes[i], edges)
                _blend_quadrangle(shapes[i], edges, scratch, first_x, first_y, past_x, past_y)
    stretches, n = np.empty((256, 4), np.int64), 0
    for r in range(len(rectangles)):
        left, top, right, bottom = rectangles[r]
        most = (right - left) // _APART + 2
        for y in range(top, bottom):
            if n + most > len(stretches):
                longer = np.empty((2 * (n + most), 4), np.int64)
                longer[:n] = stretches[:n]
                stretches = longer
            past = -_APART
            for x in range(left, right):
                light = scratch[y, x]
                if np.isnan(light):  # done, in another rectangle
                    continue
                scratch[y, x] = np.nan
                if light != linear[y, x]:
                    linear[y, x] = light
                    if past < left or x - past >= _APART:
                        stretches[n, 0], stretches[n, 1], stretches[n, 3] = x, y, y + 1
                        n += 1
                    past = x + 1
                    stretches[n - 1, 2] = past
    for i in range(n):
        left, y, right = stretches[i, 0], stretches[i, 1], stretches[i, 2]
        _logarithms(linear[y, left:right], frame[y, left:right])
    return stretches[:n]


@njit(cache=True, nogil=True, error_model="numpy")
def _logarithms(values, logarithms):  # type: ignore[no-untyped-def]
    """Natural logarithms of positive normal numbers, to less than an ulp: fdlibm's method, in a loop that is vectorised.

    A value is 2^k z with z from sqrt(1/2) to sqrt(2); with f = z - 1 and s = f / (2 + f), log z = log((1 + s) / (1 - s)).
    """
    for i in range(len(values)):
        bits = np.float64(values[i]).view(np.int64)
        k = (bits - _SQRT_HALF) >> 52
        f = np.int64(bits - (k << 52)).view(np.float64) - 1.0
        s = f / (2.0 + f)
        w = s * s
        q = w * w
        odd = w * (_LOG[0] + q * (_LOG[2] + q * (_LOG[4] + q * _LOG[6])))
        even = q * (_LOG[1] + q * (_LOG[3] + q * _LOG[5]))
        half = 0.5 * f * f
        logarithms[i] = k * _LN2_HIGH - ((half - (s * (half + odd + even) + k * _LN2_LOW)) - f)


@step
def _blend_disc(shape, picture, first_x, first_y, past_x, past_y):  # type: ignore[no-untyped-def]
    """Blend a disc into a rectangle of a picture."""
    radius, light = shape[X + 1], shape[INTENSITY]
    inside = max(radius - 0.5 - _MARGIN, 0.0) ** 2
    for y in range(first_y, past_y):
        down = y - shape[Y]
        for x in range(first_x, past_x):
            across = x - shape[X]
            part = 1.0
            if across * across + down * down >= inside:
                part = min(max(radius - np.hypot(across, down) + 0.5, 0.0), 1.0)
            picture[y, x] += part * (light - picture[y, x])


@step
def _blend_quadrangle(shape, edges, picture, first_x, first_y, past_x, past_y):  # type: ignore[no-untyped-def]
    """Blend a quadrangle into a rectangle of a picture. Of a row, only the pixels are looked at that it may cover; those in the
    middle, which it covers as a whole, are its light."""
    light = shape[INTENSITY]
    for y in range(first_y, past_y):
        low, high, whole_low, whole_high = _stretch(edges, y, first_x, past_x)
        begin, past = int(low), int(high)
        whole_begin, whole_past = max(begin, int(np.ceil(whole_low))), min(past, int(np.floor(whole_high)) + 1)
        if whole_begin < whole_past:
            for x in range(whole_begin, whole_past):
                picture[y, x] += 1.0 * (light - picture[y, x])
        else:
            whole_begin = whole_past = past
        for x in range(begin, whole_begin):
            _blend_pixel(light, edges, picture, x, y)
        for x in range(whole_past, past):
            _blend_pixel(light, edges, picture, x, y)


@step
def _stretch(edges, y, first_x, past_x):  # type: ignore[no-untyped-def]
    """Of the pixels from `first_x` to `past_x` of a row: begin and end of those that a quadrangle may cover; the first and the
    last that it covers as a whole. Without such pixels the end is not behind the begin, the last before the first."""
    low, high = float(first_x), float(past_x)
    whole_low, whole_high = low, high
    for edge in range(4):
        a, rest = edges[edge, 0], edges[edge, 1] * y + edges[edge, 2] + 0.5
        if a > _MARGIN:
            low, whole_low = max(low, -rest / a - 1.0), max(whole_low, (1.0 + _MARGIN - rest) / a)
        elif a < -_MARGIN:
            high, whole_high = min(high, -rest / a + 2.0), min(whole_high, (1.0 + _MARGIN - rest) / a)
        else:  # the edge lies along the row
            if rest < -1.0 - past_x * _MARGIN:
                high = low
            if rest < 2.0 + past_x * _MARGIN:
                whole_high = whole_low - 1.0
    return low, high, whole_low, whole_high


@step
def _blend_pixel(light, edges, picture, x, y):  # type: ignore[no-untyped-def]
    """Blend a quadrangle into a pixel."""
    part = 1.0
    for pair in range(2):
        here = edges[pair, 0] * x + edges[pair, 1] * y + edges[pair, 2]
        there = edges[pair + 2, 0] * x + edges[pair + 2, 1] * y + edges[pair + 2, 2]
        part *= max(min(max(here + 0.5, 0.0), 1.0) + min(max(there + 0.5, 0.0), 1.0) - 1.0, 0.0)
    if part > 0.0:
        picture[y, x] += part * (light - picture[y, x])


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
