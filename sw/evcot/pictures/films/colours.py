# SPDX-License-Identifier: Apache-2.0
"""The colours of films: Okabe and Ito's palette, lightened for a dark background."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["EVENTS", "GROUND", "INK", "RGB", "SIDES", "hexadecimal", "palette", "shades"]

RGB = tuple[int, int, int]

GROUND: RGB = (11, 14, 18)
EVENTS: tuple[RGB, RGB] = ((224, 139, 189), (47, 199, 154))  # OFF, ON
INK: RGB = (230, 233, 237)
SIDES: tuple[RGB, ...] = ((86, 180, 233), (255, 155, 71), (240, 228, 66), (255, 255, 255))

_EVENT_SHADES, _LINE_SHADES = 96, 12


def hexadecimal(rgb: RGB) -> str:
    """The colour as "#rrggbb"."""
    return "#{:02x}{:02x}{:02x}".format(*rgb)


def shades(rgb: RGB, cover: NDArray[np.float64]) -> NDArray[np.uint8]:
    """(n, 3): a colour blended with the background by the opacities `cover`, (n,)."""
    return np.round(cover[:, np.newaxis] * rgb + (1 - cover[:, np.newaxis]) * GROUND).astype(np.uint8)


def palette() -> NDArray[np.uint8]:
    """(256, 3): the colours of a picture, for formats with a palette."""
    events = [shades(rgb, np.linspace(0, 1, _EVENT_SHADES)) for rgb in EVENTS]
    lines = [shades(rgb, np.linspace(1, 0, _LINE_SHADES, endpoint=False)) for rgb in (*SIDES, INK)]
    rows = np.concatenate([*events, *lines])
    return np.concatenate([rows, np.tile(np.array([GROUND], np.uint8), (256 - len(rows), 1))])
