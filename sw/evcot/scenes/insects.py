# SPDX-License-Identifier: Apache-2.0
"""Small, fast insects on random paths, in front of waving grass and glinting water."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ..ranges import setting
from ._flight_kernel import bounce, insects_at
from .shapes import discs, quadrangles
from .stage import StageSettings, SteadyStage, film, texture
from .truth import TRUTH, Scene

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

    count: int = setting(12, 1, 1_000, "how many insects")
    radius_px: float = setting(1.6, 0.8, 20.0, "radius of an insect")
    speed_px_s: float = setting(260.0, 1.0, 20_000.0, "mean speed")
    turn_deg: float = setting(50.0, 0.0, 180.0, "standard deviation of a turn")
    contrast: float = setting(1.0, 0.05, 5.0, "log intensity between an insect, which is darker, and the background")
    blades: int = setting(40, 0, 1_000, "blades of grass, along the lower edge")
    wave_px: float = setting(7.0, 0.0, 100.0, "how far the tip of a blade waves to either side")
    glints: int = setting(60, 0, 1_000, "spots of the background that flicker")


def simulate(settings: Insects) -> Scene:
    """See `stage.film`. Insects fly in front of the grass; where two overlap, the later is in front."""
    return film(_Stage(settings), settings)


def grass(settings: Insects) -> NDArray[np.float64]:
    """(blades, 4): lowest x, y and highest x, y that each blade of grass ever reaches, in pixels."""
    return _Stage(settings).grass_reach()


class _Stage(SteadyStage):
    def __init__(self, settings: Insects) -> None:
        random = np.random.default_rng(settings.seed)
        self._settings = settings
        self.background = texture(settings, random, 2.0, 0.3)
        self._fly(settings, random)
        self._sow(settings, random)
        self._glint_x, self._glint_y = random.uniform(0, 1, (2, settings.glints)) * [[settings.width], [settings.height / 2]]
        glint_turn = 2 * np.pi * random.uniform(*_GLINT_HZ, settings.glints)
        glint_phase = random.uniform(0, 2 * np.pi, settings.glints)
        self._wave = np.stack((np.append(glint_turn, self._wave_turn), np.append(glint_phase, self._wave_phase)))
        self._still = self._stand(settings)

    def _fly(self, settings: Insects, random: np.random.Generator) -> None:
        """Set the arguments of `bounce`: all insects turn at common times."""
        turns = int(settings.duration_us * 1e-6 / _TURN_S) + 2
        angle = random.uniform(0, 2 * np.pi, settings.count)
        angle = angle + np.cumsum(np.radians(settings.turn_deg) * random.standard_normal((turns, settings.count)), axis=0)
        pace = settings.speed_px_s * random.uniform(0.6, 1.4, (turns, settings.count))
        speeds = pace * np.stack((np.cos(angle), np.sin(angle)))
        room = np.array([settings.width, settings.height], float)
        start = random.uniform(0, 1, (2, 1, settings.count)) * room[:, None, None]
        ways = np.concatenate((start, start + np.cumsum(speeds * _TURN_S, axis=1)), axis=1)
        self._flight = np.arange(turns + 1) * _TURN_S, ways, speeds, room, np.full(2, -0.5)

    def _sow(self, settings: Insects, random: np.random.Generator) -> None:
        self._foot_x = random.uniform(0, settings.width, settings.blades)
        self._blade_px = random.uniform(0.12, 0.4, settings.blades) * settings.height
        lean_px = random.normal(0, 8.0, settings.blades)
        self._wave_turn = 2 * np.pi * random.uniform(*_WAVE_HZ, settings.blades)
        self._wave_phase = random.uniform(0, 2 * np.pi, settings.blades)
        self._tip_x = self._foot_x + lean_px  # on average
        self._blade_tone = np.exp(random.uniform(-0.6, 0.3, settings.blades))

    def _stand(self, settings: Insects) -> NDArray[np.float64]:
        """All shapes, the glints first and the insects last, with what never changes filled in."""
        glints = discs(-1 - np.arange(settings.glints), self._glint_x, self._glint_y, _GLINT_PX, 0.0)
        foot, ground = self._foot_x, np.full(settings.blades, settings.height + 1.0)
        x = np.stack((foot - _BLADE_PX / 2, foot + _BLADE_PX / 2, foot, foot), axis=1)
        y = np.stack((ground, ground, ground - self._blade_px, ground - self._blade_px), axis=1)
        grass = quadrangles(-1 - settings.glints - np.arange(settings.blades), x, y, self._blade_tone)
        nowhere = np.zeros(settings.count)
        insects = discs(np.arange(settings.count), nowhere, nowhere, settings.radius_px, np.exp(-settings.contrast))
        return np.concatenate((glints, grass, insects))

    def _motion(self, times_us: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Positions and velocities, (2, k, count): straight since the last turn, reflected at the walls."""
        motion: tuple[NDArray[np.float64], NDArray[np.float64]] = bounce(times_us * 1e-6, *self._flight)
        return motion

    def shapes(self, t_us: float | NDArray[np.int64]) -> NDArray[np.float64]:
        times_s = np.array(t_us, np.float64, ndmin=1) * 1e-6
        shapes: NDArray[np.float64] = insects_at(
            times_s, self._still, self._wave, _GLINT_CONTRAST, self._tip_x, self._settings.wave_px, self._flight
        )
        return shapes if isinstance(t_us, np.ndarray) else shapes[0]

    def grass_reach(self) -> NDArray[np.float64]:
        """See `grass`."""
        foot, tip, wave = self._foot_x, self._tip_x, self._settings.wave_px
        low_x = np.minimum(foot - _BLADE_PX / 2, tip - wave - 0.5)
        high_x = np.maximum(foot + _BLADE_PX / 2, tip + wave + 0.5)
        ground = np.full(len(foot), self._settings.height + 1.0)
        return np.stack((low_x, ground - self._blade_px, high_x, ground), axis=1)

    def objects(self, t_us: float | NDArray[np.int64]) -> NDArray[np.void]:
        (x, y), (vx, vy) = (part.reshape(2, *np.shape(t_us), -1) for part in self._motion(np.atleast_1d(t_us)))
        objects = np.zeros(x.shape, TRUTH)
        objects["object_id"] = np.arange(self._settings.count)
        objects["x"], objects["y"], objects["vx"], objects["vy"] = x, y, vx, vy
        objects["width"] = objects["height"] = 2 * self._settings.radius_px
        return objects
