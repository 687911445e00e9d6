# SPDX-License-Identifier: Apache-2.0
"""Known paths of objects that bounce off the sensor's edges: all over it, or each along its own row."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["Bouncing"]


class Bouncing:
    """Straight motion, reflected where an object's box meets the edge of the sensor.

    Args:
        sensor: (width, height) in pixels.
        size_px: (n, 2) width and height of the objects.
        speed_px_s: (n,)
        crossing: all over the sensor; otherwise along rows, from the top to the bottom.
    """

    def __init__(
        self,
        sensor: tuple[int, int],
        size_px: NDArray[np.float64],
        speed_px_s: NDArray[np.float64],
        crossing: bool,
        random: np.random.Generator,
    ) -> None:
        count = len(size_px)
        self._low = size_px.T / 2 - 0.5
        self._room = np.array(sensor, float)[:, None] - size_px.T
        self._start = random.uniform(0, 1, (2, count)) * self._room
        if crossing:
            angle = random.uniform(0, 2 * np.pi, count)
            self._speed = speed_px_s * np.stack((np.cos(angle), np.sin(angle)))
        else:
            rows = (np.arange(count) + 0.5) * sensor[1] / count
            self._start[1] = np.clip(rows - size_px[:, 1] / 2, 0, self._room[1])
            self._speed = np.stack((speed_px_s * random.choice((-1.0, 1.0), count), np.zeros(count)))

    def at(self, t_us: NDArray[np.int64], which: NDArray[np.int64] | int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Centres and velocities, (2, n), of objects at times."""
        start, speed, room, low = (each[:, which] for each in (self._start, self._speed, self._room, self._low))
        if np.ndim(which) == 0:
            start, speed, room, low = (each[:, None] for each in (start, speed, room, low))
        way = (start + speed * (t_us * 1e-6)) % (2 * room)
        back = way > room
        return low + np.where(back, 2 * room - way, way), np.where(back, -speed, speed)
