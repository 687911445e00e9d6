# SPDX-License-Identifier: Apache-2.0
"""Shapes of scenes: filled discs and convex quadrangles, each of uniform brightness.

Shapes are rows of an (n, 11) float64 array, the farthest first: KIND, OBJECT, INTENSITY, then four x and four y in event
coordinates (the centre of pixel (x, y) lies at (x, y)). A disc has its centre in the first point and its radius in the second
x. OBJECT is the `object_id` of the truth, or negative for what is not an object; rows of one object must be contiguous.
INTENSITY is linear; that of the background is around 1.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["COLUMNS", "DISC", "INTENSITY", "KIND", "OBJECT", "QUADRANGLE", "X", "Y", "discs", "quadrangles"]

KIND, OBJECT, INTENSITY, X, Y = 0, 1, 2, 3, 7
COLUMNS = 11
DISC, QUADRANGLE = 0.0, 1.0


def discs(objects: ArrayLike, x: ArrayLike, y: ArrayLike, radius_px: ArrayLike, intensity: ArrayLike) -> NDArray[np.float64]:
    """One disc per entry of `x`, (..., n); the others are broadcast to that."""
    shapes = np.zeros((*(np.shape(x) or (1,)), COLUMNS))
    shapes[..., KIND], shapes[..., OBJECT], shapes[..., INTENSITY] = DISC, objects, intensity
    shapes[..., X], shapes[..., Y], shapes[..., X + 1] = x, y, radius_px
    return shapes


def quadrangles(
    objects: ArrayLike, x: NDArray[np.float64], y: NDArray[np.float64], intensity: ArrayLike
) -> NDArray[np.float64]:
    """One convex quadrangle per row of `x` and `y`, (..., n, 4), with its corners in order."""
    shapes = np.empty((*x.shape[:-1], COLUMNS))
    shapes[..., KIND], shapes[..., OBJECT], shapes[..., INTENSITY] = QUADRANGLE, objects, intensity
    shapes[..., X : X + 4], shapes[..., Y : Y + 4] = x, y
    return shapes
