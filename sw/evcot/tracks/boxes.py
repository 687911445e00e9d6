# SPDX-License-Identifier: Apache-2.0
"""Geometry of the boxes of tracks: any rows with x, y, width, height and angle, as `log.TRACK` and `timeline.SAMPLE`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["box_corners", "upright_sides"]


def upright_sides(rows: NDArray[np.void]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Width and height, (k,) each, of the upright rectangle around each box; of an upright box its own, exactly."""
    width, height = np.array(rows["width"], np.float64), np.array(rows["height"], np.float64)
    turned = rows["angle"] != 0
    if turned.any():
        cos, sin = (np.abs(part(rows["angle"][turned])) for part in (np.cos, np.sin))
        wide, high = width[turned], height[turned]
        width[turned], height[turned] = cos * wide + sin * high, sin * wide + cos * high
    return width, height


def box_corners(rows: NDArray[np.void]) -> NDArray[np.float64]:
    """(k, 4, 2) x, y of the corners of each box, in turn; the first is the upper left one of a box that is not turned."""
    half = np.stack((rows["width"], rows["height"]), axis=-1) / 2
    offsets = half[:, None] * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    cos, sin = np.cos(rows["angle"])[:, None], np.sin(rows["angle"])[:, None]
    x, y = offsets[..., 0], offsets[..., 1]
    corners = np.stack((cos * x - sin * y, sin * x + cos * y), axis=-1)
    return np.asarray(corners + np.stack((rows["x"], rows["y"]), axis=-1)[:, None], np.float64)
