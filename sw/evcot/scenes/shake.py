# SPDX-License-Identifier: Apache-2.0
"""A shaking camera in front of a textured wall, and boxes that cross it.

The picture moves by the sum of a few sines of random frequency and phase, independent in x and y; this motion is included in
the truth.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError
from ..ranges import setting
from .shapes import quadrangles
from .stage import MARGIN_PX, StageSettings, SteadyStage, film, texture
from .truth import TRUTH, Scene

__all__ = ["Shake", "simulate"]

_SINES = 4
_SPREAD = 0.5  # of frequencies around the mean


@dataclass(frozen=True)
class Shake(StageSettings):
    """Boxes in straight motion, each in its lane, seen by a shaking camera; one that has left is followed by another.

    Raises:
        ConfigError: a value outside its range, or boxes higher than their lanes.
    """

    NAME: ClassVar[str] = "shake"

    count: int = setting(4, 0, 64, "how many boxes")
    side_px: float = setting(24.0, 2.0, 512.0, "side of a box")
    speed_px_s: float = setting(90.0, 1.0, 20_000.0, "mean speed of a box")
    contrast: float = setting(1.2, 0.05, 5.0, "log intensity between a box and the background")
    shake_px: float = setting(2.5, 0.0, MARGIN_PX - 2.0, "farthest that the picture moves")
    shake_hz: float = setting(6.0, 0.1, 200.0, "mean frequency of the tremor")
    texture_contrast: float = setting(0.3, 0.0, 2.0, "standard deviation of the wall's log intensity")
    grain_px: float = setting(2.5, 1.0, 64.0, "size of the wall's spots")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.count and self.side_px > self.height / self.count:
            raise ConfigError(f"shake.side_px = {self.side_px:g}: must be at most a lane's {self.height / self.count:g} pixels")


def simulate(settings: Shake) -> Scene:
    """See `stage.film`; object_id is the lane from the top, and `count` more for each box that was in it before."""
    return film(_Stage(settings), settings)


class _Stage(SteadyStage):
    def __init__(self, settings: Shake) -> None:
        random = np.random.default_rng(settings.seed)
        self._settings = settings
        self.background = texture(settings, random, settings.grain_px, settings.texture_contrast)
        self._turn = 2 * np.pi * settings.shake_hz * (1 + _SPREAD * random.uniform(-1, 1, (2, _SINES)))
        self._phase = random.uniform(0, 2 * np.pi, (2, _SINES))
        self._size_px = settings.shake_px / _SINES
        direction = np.where(np.arange(settings.count) % 2 == 0, 1.0, -1.0)
        self._speed = direction * settings.speed_px_s * random.uniform(0.7, 1.3, settings.count)
        self._start = random.uniform(0, 1, settings.count) * (settings.width + settings.side_px)
        self._y = (np.arange(settings.count) + 0.5) * settings.height / max(settings.count, 1) - 0.5
        self._intensity = np.exp(settings.contrast * np.where(random.permutation(settings.count) % 2 == 0, 1.0, -1.0))

    def shift(self, t_us: float) -> tuple[float, float]:
        x, y = self._shift(np.asarray(t_us)).tolist()
        return x, y

    def _shift(self, t_us: NDArray[Any]) -> NDArray[np.float64]:
        """`shift` at times of any shape, (..., 2)."""
        return np.asarray(self._size_px * np.sin(self._turn * (t_us[..., None, None] * 1e-6) + self._phase).sum(axis=-1))

    def _boxes(self, t_us: float | NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
        """Numbers and centres: a box has left once it has gone by its own side and the sensor's width."""
        settings, times_us = self._settings, np.asarray(t_us)
        shift = self._shift(times_us)
        way = self._start + self._speed * (times_us[..., None] * 1e-6)
        left, x = np.divmod(way, settings.width + settings.side_px)
        numbers = np.arange(settings.count) + settings.count * abs(left).astype(np.int64)
        return numbers, x - settings.side_px / 2 - 0.5 + shift[..., :1], self._y + shift[..., 1:]

    def shapes(self, t_us: float | NDArray[np.int64]) -> NDArray[np.float64]:
        numbers, x, y = self._boxes(t_us)
        half = self._settings.side_px / 2
        corners_x, corners_y = np.array([-half, half, half, -half]), np.array([-half, -half, half, half])
        return quadrangles(numbers, x[..., None] + corners_x, y[..., None] + corners_y, self._intensity)

    def objects(self, t_us: float | NDArray[np.int64]) -> NDArray[np.void]:
        t_s = np.asarray(t_us)[..., None, None] * 1e-6
        speed = self._size_px * (self._turn * np.cos(self._turn * t_s + self._phase)).sum(axis=-1)
        numbers, x, y = self._boxes(t_us)
        objects = np.zeros(numbers.shape, TRUTH)
        objects["object_id"], objects["x"], objects["y"] = numbers, x, y
        objects["vx"], objects["vy"] = self._speed + speed[..., :1], speed[..., 1:]
        objects["width"] = objects["height"] = self._settings.side_px
        return np.take_along_axis(objects, np.argsort(numbers, axis=-1), axis=-1)
