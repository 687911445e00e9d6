# SPDX-License-Identifier: Apache-2.0
"""Vehicle shapes seen from behind and above: faces of a body and a cabin, in fractions of width, height and length."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["FACES", "SHADOW", "outline"]

SHADOW = 0  # the face that is not part of the vehicle's box
FACES = 10

_GLASS, _DARK, _SHADE = -0.9, -0.7, -0.45  # log intensity, as a fraction of the contrast
_ROOF_SHINE = 0.25


def _across_face(half: float, low: tuple[float, float], half_high: float, high: tuple[float, float]) -> list[list[float]]:
    """A face across the vehicle, between two transverse lines at (up, along)."""
    return [[-half, *low], [half, *low], [half_high, *high], [-half_high, *high]]


def _side_face(across: float, *points: tuple[float, float]) -> list[list[float]]:
    return [[across, *point] for point in points]


def _faces(body: float) -> list[list[list[float]]]:
    """The faces of a vehicle whose body has this fraction of its height, the farthest first."""
    cabin = (body, 0.12), (body, 0.75), (1.0, 0.65), (1.0, 0.25)
    sides = (0.08, 0.0), (body, 0.0), (body, 1.0), (0.08, 1.0)
    return [
        _across_face(0.56, (0.0, -0.12), 0.56, (0.0, 1.0)),
        _side_face(-0.5, *sides),
        _side_face(0.5, *sides),
        _across_face(0.5, (body, 0.0), 0.5, (body, 1.0)),
        _across_face(0.5, (0.08, 0.0), 0.5, (body, 0.0)),
        _across_face(0.5, (0.08, 0.0), 0.5, (0.3 * body, 0.0)),
        _side_face(-0.45, *cabin),
        _side_face(0.45, *cabin),
        _across_face(0.4, (1.0, 0.25), 0.4, (1.0, 0.65)),
        _across_face(0.45, (body, 0.12), 0.4, (1.0, 0.25)),
    ]


def outline(
    is_box: NDArray[np.bool_], paint: NDArray[np.float64], contrast: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners of all faces, (n, FACES, 4, 3): across from the middle, up and along from the rear; and their log intensities,
    (n, FACES)."""
    car, box = np.array(_faces(0.6)), np.array(_faces(1.0))
    corners = np.where(is_box[:, None, None, None], box, car)
    glass, dark, shade = (np.full(len(paint), part * contrast) for part in (_GLASS, _DARK, _SHADE))
    side, roof = paint - 0.1 * contrast, paint + _ROOF_SHINE * contrast
    tones = (shade, side, side, roof, paint, dark, glass, glass, roof, glass)
    return corners, np.stack(tones, axis=1)
