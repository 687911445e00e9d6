# SPDX-License-Identifier: Apache-2.0
"""Small, fast insects on random paths, in front of waving grass and glinting water."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ..ranges import Range
from .scene import Scene
from .shapes import discs, quadrangles
from .stage import StageSettings, film, texture
from .truth import TRUTH

__all__ = ["Insects", "grass", "simulate"]

_TURN_S = 0.08  # mean time between two turns
_BLADE_PX = 4.0  # width of a blade of grass at its foot
_GLINT_PX = 1.5
_GLINT_CONTRAST = 0.6
_GLINT_HZ = (2.0, 9.0)
_WAVE_HZ = (0.5, 1.6)


@dataclass(frozen=True)
class Insects(StageSettings):
    """Dark dots that fly straight for some time, then turn; grass and glints are not objects of the truth."""

    NAME: ClassVar[str] = "insects"
    RANGES: ClassVar[dict[str, Range]] = {
        "count": (1, 1_000, "how many insects"),
        "radius_px": (0.8, 20.0, "radius of an insect"),
        "speed_px_s": (1.0, 20_000.0, "mean speed"),
        "turn_deg": (0.0, 180.0, "standard deviation of a turn"),
        "contrast": (0.05, 5.0, "log intensity between an insect, which is darker, and the background"),
        "blades": (0, 1_000, "blades of grass, along the lower edge"),
        "wave_px": (0.0, 100.0, "how far the tip of a blade waves to either side"),
        "glints": (0, 1_000, "spots of the background that flicker"),
    }

    count: int = 12
    radius_px: float = 1.6
    speed_px_s: float = 260.0
    turn_deg: float = 50.0
    contrast: float = 1.0
    blades: int = 40
    wave_px: float = 7.0
    glints: int = 60


def simulate(settings: Insects) -> Scene:
    """See `stage.film`. Insects fly in front of the grass; where two overlap, the later is in front."""
    return film(_Stage(settings), settings)


def grass(settings: Insects) -> NDArray[np.float64]:
    """(blades, 4): lowest x, y and highest x, y that each blade of grass ever reaches, in pixels."""
    return _Stage(settings).grass_reach()


class _Stage:
    steady = True

    def __init__(self, settings: Insects) -> None:
        random = np.random.default_rng(settings.seed)
        self._settings = settings
        self.background = texture(settings, random, 2.0, 0.3)
        self._fly(settings, random)
        self._sow(settings, random)
        self._glint_x, self._glint_y = random.uniform(0, 1, (2, settings.glints)) * [[settings.width], [settings.height / 2]]
        self._glint_turn = 2 * np.pi * random.uniform(*_GLINT_HZ, settings.glints)
        self._glint_phase = random.uniform(0, 2 * np.pi, settings.glints)

    def _fly(self, settings: Insects, random: np.random.Generator) -> None:
        """Turns of all insects at common times (k,): displacements from the start (2, k, count), speeds (2, k - 1, count)."""
        turns = int(settings.duration_us * 1e-6 / _TURN_S) + 2
        self._turns_s = np.arange(turns + 1) * _TURN_S
        angle = random.uniform(0, 2 * np.pi, settings.count)
        angle = angle + np.cumsum(np.radians(settings.turn_deg) * random.standard_normal((turns, settings.count)), axis=0)
        pace = settings.speed_px_s * random.uniform(0.6, 1.4, (turns, settings.count))
        self._speeds = pace * np.stack((np.cos(angle), np.sin(angle)))
        self._room = np.array([[settings.width], [settings.height]], float)
        start = random.uniform(0, 1, (2, 1, settings.count)) * self._room[:, None]
        self._ways = np.concatenate((start, start + np.cumsum(self._speeds * _TURN_S, axis=1)), axis=1)

    def _sow(self, settings: Insects, random: np.random.Generator) -> None:
        self._foot_x = random.uniform(0, settings.width, settings.blades)
        self._blade_px = random.uniform(0.12, 0.4, settings.blades) * settings.height
        self._lean_px = random.normal(0, 8.0, settings.blades)
        self._wave_turn = 2 * np.pi * random.uniform(*_WAVE_HZ, settings.blades)
        self._wave_phase = random.uniform(0, 2 * np.pi, settings.blades)
        self._blade_tone = np.exp(random.uniform(-0.6, 0.3, settings.blades))

    def _motion(self, t_us: float | NDArray[np.int64]) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """Positions and velocities along each axis, (..., count): straight since the last turn, reflected at the walls."""
        t_s = np.asarray(t_us) * 1e-6
        leg = np.minimum(np.searchsorted(self._turns_s, t_s, side="right") - 1, self._speeds.shape[1] - 1)
        since_s = (t_s - self._turns_s[leg])[..., None]
        for speeds, ways, room in zip(self._speeds, self._ways, self._room, strict=True):
            speed = speeds[leg]
            way = (ways[leg] + speed * since_s) % (2 * room)
            back = way > room
            yield np.where(back, 2 * room - way, way) - 0.5, np.where(back, -speed, speed)

    def shapes(self, t_us: float | NDArray[np.int64]) -> NDArray[np.float64]:
        settings, t_s = self._settings, np.asarray(t_us)[..., None] * 1e-6
        (x, _), (y, _) = self._motion(t_us)
        insects = discs(np.arange(settings.count), x, y, settings.radius_px, np.exp(-settings.contrast))
        return np.concatenate((self._glints(t_s), self._grass(t_s), insects), axis=-2)

    def _glints(self, t_s: NDArray[np.float64]) -> NDArray[np.float64]:
        light = np.exp(_GLINT_CONTRAST * (1 + np.sin(self._glint_turn * t_s + self._glint_phase)))
        numbers = -1 - np.arange(self._settings.glints)
        return discs(numbers, np.broadcast_to(self._glint_x, light.shape), self._glint_y, _GLINT_PX, light)

    def _grass(self, t_s: NDArray[np.float64]) -> NDArray[np.float64]:
        settings = self._settings
        foot, ground = self._foot_x, np.full(settings.blades, settings.height + 1.0)
        tip = foot + self._lean_px + settings.wave_px * np.sin(self._wave_turn * t_s + self._wave_phase)
        x = np.empty((*tip.shape, 4))
        x[..., 0], x[..., 1], x[..., 2], x[..., 3] = foot - _BLADE_PX / 2, foot + _BLADE_PX / 2, tip + 0.5, tip - 0.5
        y = np.stack((ground, ground, ground - self._blade_px, ground - self._blade_px), axis=1)
        return quadrangles(-1 - settings.glints - np.arange(settings.blades), x, y, self._blade_tone)

    def grass_reach(self) -> NDArray[np.float64]:
        """See `grass`."""
        foot, tip, wave = self._foot_x, self._foot_x + self._lean_px, self._settings.wave_px
        low_x = np.minimum(foot - _BLADE_PX / 2, tip - wave - 0.5)
        high_x = np.maximum(foot + _BLADE_PX / 2, tip + wave + 0.5)
        ground = np.full(len(foot), self._settings.height + 1.0)
        return np.stack((low_x, ground - self._blade_px, high_x, ground), axis=1)

    def objects(self, t_us: float | NDArray[np.int64]) -> NDArray[np.void]:
        (x, vx), (y, vy) = self._motion(t_us)
        objects = np.zeros(x.shape, TRUTH)
        objects["object_id"] = np.arange(self._settings.count)
        objects["x"], objects["y"], objects["vx"], objects["vy"] = x, y, vx, vy
        objects["width"] = objects["height"] = 2 * self._settings.radius_px
        return objects

    def shift(self, _t_us: float) -> tuple[float, float]:
        return 0.0, 0.0
