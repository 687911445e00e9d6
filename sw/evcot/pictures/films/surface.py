# SPDX-License-Identifier: Apache-2.0
"""Decaying time surface of events: a pixel shows its latest event, faded by age."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ...events import Events, check_pixels
from ...recordings.formats.source import Sensor
from .colours import EVENTS, shades

__all__ = ["Surface"]

_LEVELS = 256
_CUT = 5.0  # time constants after which an event is invisible
_NEVER = np.iinfo(np.int64).min // 2


class Surface:
    """The time surface of a sensor; see the module.

    Args:
        decay_us: time constant with which events fade.
    """

    def __init__(self, sensor: Sensor, decay_us: float) -> None:
        width, height = sensor
        check_pixels(width, height)
        self._decay_us = decay_us
        self._t_us = np.full((height, width), _NEVER, np.int64)
        self._p = np.zeros((height, width), np.uint8)
        cover = np.exp(-_CUT * np.arange(_LEVELS + 1) / _LEVELS)
        cover[-1] = 0
        self._table = np.array([shades(rgb, cover) for rgb in EVENTS])

    def add(self, events: Events) -> None:
        """Add events, in order of time."""
        _add(events.t_us, events.x, events.y, events.p, self._t_us, self._p)

    def picture(self, now_us: int) -> NDArray[np.uint8]:
        """(height, width, 3): the image at a time."""
        image = np.empty((*self._t_us.shape, 3), np.uint8)
        _paint(self._t_us, self._p, now_us, _LEVELS / (_CUT * self._decay_us), self._table, image)
        return image


@njit(cache=True, nogil=True)
def _add(t_us, x, y, p, latest_us, latest_p):  # type: ignore[no-untyped-def]
    """Store each event as the latest of its pixel."""
    for i in range(len(t_us)):
        latest_us[y[i], x[i]] = t_us[i]
        latest_p[y[i], x[i]] = p[i]


@njit(cache=True, nogil=True)
def _paint(latest_us, latest_p, now_us, scale, table, image):  # type: ignore[no-untyped-def]
    """Colours by polarity and age."""
    faded = np.float64(table.shape[1] - 1)
    for row in range(image.shape[0]):
        for column in range(image.shape[1]):
            level = min((now_us - latest_us[row, column]) * scale, faded)
            for channel in range(3):
                image[row, column, channel] = table[latest_p[row, column], np.int64(level), channel]
