# SPDX-License-Identifier: Apache-2.0
"""Points in polygons and crossings of lines; exact for coordinates with few binary digits, such as whole and half pixels.

A polygon includes its border. A line has a right and a left side, seen in its direction from begin to end in the picture (y
points down); the line itself belongs to the left. A step from one side to the other crosses the line if the line's begin and
end are on different sides of the straight line through the step, by the same rule: so a step through the common end of two
lines crosses exactly one of them.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from .._numba_private import step

__all__ = ["crosses", "crossings", "holds", "inside", "offset"]


@step
def offset(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> float:
    """Twice the signed area of the triangle (a, b, point): positive to the right of the way from a to b in the picture."""
    return (bx - ax) * (y - ay) - (by - ay) * (x - ax)


@step
def holds(corners, first, last, x, y):  # type: ignore[no-untyped-def]
    """Whether the polygon with corners[first:last], (k, 2), contains a point: even-odd rule, the border is inside."""
    within = False
    bx, by = corners[last - 1]
    for i in range(first, last):
        ax, ay = bx, by
        bx, by = corners[i]
        side = offset(ax, ay, bx, by, x, y)
        if side == 0 and min(ax, bx) <= x <= max(ax, bx) and min(ay, by) <= y <= max(ay, by):
            return True
        if (ay > y) != (by > y) and (side > 0) == (by < ay):
            within = not within
    return within


@step
def crosses(line, px, py, qx, qy):  # type: ignore[no-untyped-def]
    """1 if the step from p to q crosses line (begin x, y, end x, y) from left to right, -1 from right to left, else 0."""
    ax, ay, bx, by = line
    from_right = offset(ax, ay, bx, by, px, py) > 0
    to_right = offset(ax, ay, bx, by, qx, qy) > 0
    if from_right == to_right or (offset(px, py, qx, qy, ax, ay) > 0) == (offset(px, py, qx, qy, bx, by) > 0):
        return 0
    return 1 if to_right else -1


@njit(cache=True, nogil=True)
def _inside(corners, x, y, out):  # type: ignore[no-untyped-def]
    for i in range(len(x)):
        out[i] = holds(corners, 0, len(corners), x[i], y[i])


@njit(cache=True, nogil=True)
def _crossings(line, x, y, out):  # type: ignore[no-untyped-def]
    for i in range(len(out)):
        out[i] = crosses(line, x[i], y[i], x[i + 1], y[i + 1])


def inside(corners: ArrayLike, x: ArrayLike, y: ArrayLike) -> NDArray[np.bool_]:
    """Whether a polygon, (k, 2) corners in order, contains each of (n,) points."""
    xs, ys = np.asarray(x, np.float64), np.asarray(y, np.float64)
    out = np.empty(len(xs), np.bool_)
    _inside(np.asarray(corners, np.float64), xs, ys, out)
    return out


def crossings(line: ArrayLike, x: ArrayLike, y: ArrayLike) -> NDArray[np.int8]:
    """Crossings of a line (begin x, y, end x, y) by the (n - 1,) steps of a path: 1 to its right, -1 to its left, else 0."""
    xs, ys = np.asarray(x, np.float64), np.asarray(y, np.float64)
    out = np.empty(max(len(xs) - 1, 0), np.int8)
    _crossings(np.asarray(line, np.float64), xs, ys, out)
    return out
