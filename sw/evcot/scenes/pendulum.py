# SPDX-License-Identifier: Apache-2.0
"""A damped pendulum: a bob on a rod, suspended from the middle of the upper edge.

The angle from the vertical is that of small oscillations, angle * exp(-t / damping) * cos(2 pi t / period).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError
from ..ranges import setting
from .shapes import X, Y, discs, quadrangles
from .stage import StageSettings, SteadyStage, film, texture
from .truth import TRUTH, Scene

__all__ = ["BOB", "ROD", "Pendulum", "simulate"]

BOB, ROD = 0, 1


@dataclass(frozen=True)
class Pendulum(StageSettings):
    """One swinging pendulum.

    Raises:
        ConfigError: a value outside its range, or a bob that swings off the sensor.
    """

    NAME: ClassVar[str] = "pendulum"

    length_px: float = setting(180.0, 8.0, 4096.0, "from the pivot to the middle of the bob")
    bob_px: float = setting(16.0, 1.0, 512.0, "radius of the bob")
    rod_px: float = setting(3.0, 0.5, 64.0, "width of the rod")
    angle_deg: float = setting(35.0, 0.1, 80.0, "first angle")
    period_s: float = setting(1.6, 0.05, 100.0, "time of a swing there and back")
    damping_s: float = setting(8.0, 0.1, 10_000.0, "time in which the swing falls to 1/e")
    contrast: float = setting(0.9, 0.05, 5.0, "log intensity between the pendulum, which is darker, and the background")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.length_px + self.bob_px > self.height:
            raise ConfigError(
                f"pendulum.length_px = {self.length_px:g}: with the bob's {self.bob_px:g} must be at most the sensor's "
                f"{self.height} pixels down"
            )


def simulate(settings: Pendulum) -> Scene:
    """See `stage.film`. object_id 0 is the bob, which hides the end of 1, the rod."""
    return film(_Stage(settings), settings)


class _Stage(SteadyStage):
    def __init__(self, settings: Pendulum) -> None:
        self._settings = settings
        self._pivot = (settings.width - 1) / 2, -0.5
        intensity = float(np.exp(-settings.contrast))
        self._first, self._turn = np.radians(settings.angle_deg), 2 * np.pi / settings.period_s
        nowhere = np.zeros((1, 4))
        rod, bob = quadrangles(ROD, nowhere, nowhere, intensity), discs(BOB, [0.0], 0.0, settings.bob_px, intensity)
        self._still = np.concatenate((rod, bob))
        self.background = texture(settings, np.random.default_rng(settings.seed), 3.0, 0.05)

    def _angle(self, t_us: float | NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Size of the swing and angle, in radians, (..., 1)."""
        t_s = np.asarray(t_us)[..., None] * 1e-6
        size = self._first * np.exp(-t_s / self._settings.damping_s)
        return size, size * np.cos(self._turn * t_s)

    def _swing(self, t_us: float | NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Angle and angular velocity, in radians and radians per second, (..., 1)."""
        (size, angle), turn = self._angle(t_us), self._turn
        t_s = np.asarray(t_us)[..., None] * 1e-6
        return angle, -angle / self._settings.damping_s - size * turn * np.sin(turn * t_s)

    def shapes(self, t_us: float | NDArray[np.int64]) -> NDArray[np.float64]:
        settings, (pivot_x, pivot_y) = self._settings, self._pivot
        _, angle = self._angle(t_us)
        sine, cosine, half = np.sin(angle), np.cos(angle), settings.rod_px / 2
        shapes = np.empty((*angle.shape[:-1], *self._still.shape))
        shapes[...] = self._still
        rod, bob = shapes[..., 0, :], shapes[..., 1, :]
        for first, pivot, side, along in (
            (X, pivot_x, cosine * half, sine * settings.length_px),
            (Y, pivot_y, -sine * half, cosine * settings.length_px),
        ):
            rod[..., first : first + 4] = np.concatenate((side, side + along, along - side, -side), axis=-1) + pivot
            bob[..., first] = pivot + along[..., 0]
        return shapes

    def objects(self, t_us: float | NDArray[np.int64]) -> NDArray[np.void]:
        settings, (pivot_x, pivot_y) = self._settings, self._pivot
        angle, speed = (part[..., 0] for part in self._swing(t_us))
        sine, cosine, length = np.sin(angle), np.cos(angle), settings.length_px
        objects = np.zeros((*angle.shape, 2), TRUTH)
        for number, part in ((BOB, 1.0), (ROD, 0.5)):
            mine = objects[..., number]
            mine["object_id"] = number
            mine["x"], mine["y"] = pivot_x + part * length * sine, pivot_y + part * length * cosine
            mine["vx"], mine["vy"] = part * length * cosine * speed, -part * length * sine * speed
        objects["width"] = objects["height"] = 2 * settings.bob_px
        objects["width"][..., ROD] = length * abs(sine) + settings.rod_px * cosine
        objects["height"][..., ROD] = length * cosine + settings.rod_px * abs(sine)
        return objects
