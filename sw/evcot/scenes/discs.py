# SPDX-License-Identifier: Apache-2.0
"""Discs that bounce off the walls: crossing each other, the later ones in front, or each in its own lane."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError
from ..ranges import setting
from ._flight_kernel import bounce
from .shapes import X, Y, discs
from .stage import StageSettings, SteadyStage, film, texture
from .truth import TRUTH, Scene

__all__ = ["Discs", "Ways", "simulate"]

Ways = Literal["crossing", "separate"]


@dataclass(frozen=True)
class Discs(StageSettings):
    """`count` discs of random brightness, speed and direction. `ways`: all over the sensor, or each along its own lane.

    Raises:
        ConfigError: a value outside its range, or discs larger than the sensor or their lanes.
    """

    NAME: ClassVar[str] = "discs"

    count: int = setting(6, 1, 256, "how many discs")
    radius_px: float = setting(9.0, 1.0, 512.0, "radius of a disc")
    speed_px_s: float = setting(150.0, 1.0, 20_000.0, "mean speed")
    speed_spread: float = setting(0.5, 0.0, 0.9, "farthest from the mean, as a part of it")
    contrast: float = setting(0.9, 0.05, 5.0, "log intensity between a disc and the background")
    ways: Ways = "crossing"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.ways not in get_args(Ways):
            raise ConfigError(f"discs.ways = {self.ways!r}: must be one of {', '.join(get_args(Ways))}")
        room = min(self.width, self.height / (self.count if self.ways == "separate" else 1))
        if 2 * self.radius_px > room:
            raise ConfigError(f"discs.radius_px = {self.radius_px:g}: must be at most {room / 2:g}, so that a disc has room")


def simulate(settings: Discs) -> Scene:
    """See `stage.film`; object_id is the disc's depth order, from the farthest, 0, to the nearest."""
    return film(_Stage(settings), settings)


class _Stage(SteadyStage):
    def __init__(self, settings: Discs) -> None:
        random = np.random.default_rng(settings.seed)
        count, radius = settings.count, settings.radius_px
        self._radius = radius
        self._numbers = np.arange(count)
        self.background = texture(settings, random, 3.0, 0.05)
        brighter = random.permutation(count) % 2 == 0
        intensity = np.exp(np.where(brighter, 1.0, -1.0) * settings.contrast)
        self._still = discs(self._numbers, np.zeros(count), 0.0, radius, intensity)
        speed = settings.speed_px_s * (1 + settings.speed_spread * random.uniform(-1, 1, count))
        angle = random.uniform(0, 2 * np.pi, count)
        self._low = np.full(2, radius - 0.5)
        self._room = np.array([settings.width - 2 * radius, settings.height - 2 * radius])
        self._start = random.uniform(0, 1, (2, 1, count)) * self._room[:, None, None]
        if settings.ways == "separate":
            angle = np.where(np.cos(angle) > 0, 0.0, np.pi)
            self._start[1, 0] = (np.arange(count) + 0.5) * settings.height / count - radius
        self._speed = speed * np.stack((np.cos(angle), np.where(angle == np.pi, 0.0, np.sin(angle))))[:, None]

    def _motion(self, t_us: float | NDArray[np.int64]) -> Iterator[NDArray[np.float64]]:
        """Centres and velocities, (2, ..., count): straight motion, reflected at the walls."""
        for motion in bounce(np.atleast_1d(t_us) * 1e-6, np.zeros(1), self._start, self._speed, self._room, self._low):
            yield motion.reshape(2, *np.shape(t_us), -1)

    def shapes(self, t_us: float | NDArray[np.int64]) -> NDArray[np.float64]:
        places, _ = self._motion(t_us)
        shapes = np.empty((*places.shape[1:], self._still.shape[1]))
        shapes[...] = self._still
        shapes[..., X], shapes[..., Y] = places
        return shapes

    def objects(self, t_us: float | NDArray[np.int64]) -> NDArray[np.void]:
        (x, y), (vx, vy) = self._motion(t_us)
        objects = np.zeros(x.shape, TRUTH)
        objects["object_id"] = self._numbers
        objects["x"], objects["y"], objects["vx"], objects["vy"] = x, y, vx, vy
        objects["width"] = objects["height"] = 2 * self._radius
        return objects
