# SPDX-License-Identifier: Apache-2.0
"""Film a stage: shapes moving in front of a background, rendered as often as their motion requires, seen by a `PixelCamera`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import ClassVar, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from ..events import Events, Recording
from ..ranges import Range, check_ranges
from ._occlusion_kernel import hidden_at
from ._render_kernel import changes, draw, shift_texture
from .pixel import PixelCamera, PixelModel
from .scene import Scene
from .truth import TRUTH, Truth, on_sensor

__all__ = ["MARGIN_PX", "Stage", "StageSettings", "film", "texture"]

MARGIN_PX = 16  # of a background, on every side: limit of camera shake

_MOVE_PX = 0.5  # maximum displacement between two frames
_AIM = 0.9  # fraction of that to aim for, so that a step rarely has to be repeated
_STEP_MAX_US = 5_000
_AT_ONCE = 1_000  # samples of the truth

STAGE_RANGES: dict[str, Range] = {
    "width": (64, 4096, "pixels of the sensor across"),
    "height": (64, 4096, "pixels of the sensor down"),
    "duration_us": (1_000, 1_000_000_000, "length of the scene"),
    "seed": (0, 2**63 - 1, "seed of everything random"),
    "truth_step_us": (1, 1_000_000, "time between two samples of the truth"),
}


@dataclass(frozen=True)
class StageSettings:
    """Settings common to all filmed scenes; limits and meanings in `STAGE_RANGES`.

    Raises:
        ConfigError: a value outside its range.
    """

    NAME: ClassVar[str] = "scene"
    RANGES: ClassVar[dict[str, Range]] = {}

    width: int = 346
    height: int = 260
    duration_us: int = 4_000_000
    seed: int = 1
    truth_step_us: int = 1_000
    pixel: PixelModel = field(default_factory=lambda: PixelModel(mismatch=0.03, refractory_us=300, noise_hz=0.1))

    def __post_init__(self) -> None:
        check_ranges(self.NAME, self, STAGE_RANGES | self.RANGES)


class Stage(Protocol):
    """Interface of a scene to be filmed.

    Attributes:
        background: (height + 2 MARGIN_PX, width + 2 MARGIN_PX) linear intensity.
        steady: whether it always has as many shapes and objects, and is a `SteadyStage`.
    """

    background: NDArray[np.float64]
    steady: bool

    def shapes(self, t_us: float) -> NDArray[np.float64]:
        """The shapes in front of the background, the farthest first; see `shapes`."""

    def objects(self, t_us: float) -> NDArray[np.void]:
        """Position, size and velocity of each object, of dtype `TRUTH`, by `object_id`; the other fields are not set."""

    def shift(self, t_us: float) -> tuple[float, float]:
        """Displacement of the background, pixels right and down, at most MARGIN_PX - 1."""


class SteadyStage(Stage, Protocol):
    """`shapes` and `objects` take (k,) times, too; what they return has another axis in front."""

    def shapes(self, t_us: float | NDArray[np.int64]) -> NDArray[np.float64]: ...

    def objects(self, t_us: float | NDArray[np.int64]) -> NDArray[np.void]: ...


def film(stage: Stage, settings: StageSettings) -> Scene:
    """Events in [0, duration_us) and truth every `truth_step_us`; equal settings give identical results."""
    width, height, end_us = settings.width, settings.height, settings.duration_us
    camera = PixelCamera(settings.pixel, width, height, settings.seed)
    canvas = _Canvas(stage, width, height)
    camera.step(canvas.frame, 0)
    blocks, t_us, step_us = [], 0, 1_000.0
    while t_us < end_us:
        step_us = min(step_us, _STEP_MAX_US, end_us - t_us)
        next_us = t_us + max(int(step_us), 1)
        changed, moved_px = canvas.look(next_us)
        if moved_px > _MOVE_PX and next_us > t_us + 1:
            step_us = (next_us - t_us) * _AIM * _MOVE_PX / moved_px
            continue
        blocks.append(camera.step(canvas.frame, next_us, canvas.draw(changed)))
        step_us = (next_us - t_us) * min(_AIM * _MOVE_PX / max(moved_px, 1e-9), 2.0)
        t_us = next_us
    events = Events.joined(blocks)
    events = events[: int(np.searchsorted(events.t_us, end_us))]
    truth = Truth(_samples(stage, range(0, end_us, settings.truth_step_us), (width, height)))
    return Scene(Recording(events, width, height, settings.NAME), truth, settings.seed)


def _samples(stage: Stage, times_us: Iterable[int], sensor: tuple[int, int]) -> NDArray[np.void]:
    """`Truth.samples` of a stage."""
    every_us = np.fromiter(times_us, np.int64)
    moments = [np.empty(0, TRUTH)]
    for begin in range(0, len(every_us), _AT_ONCE if stage.steady else 1):
        now_us = every_us[begin : begin + (_AT_ONCE if stage.steady else 1)]
        if stage.steady:
            steady = cast(SteadyStage, stage)
            objects, shapes = steady.objects(now_us), steady.shapes(now_us)
        else:
            objects, shapes = stage.objects(int(now_us[0]))[None], stage.shapes(int(now_us[0]))[None]
        objects["t_us"] = now_us[:, None]
        ids = np.array(objects["object_id"], np.int64)  # contiguous, so Numba compiles the kernel only once
        objects["occluded"] = hidden_at(shapes, ids, *sensor)
        moments.append(objects.ravel())
    samples = np.concatenate(moments)
    samples["visible"] = on_sensor(samples, sensor)
    return samples


class _Canvas:
    """A frame that is redrawn only where something has moved."""

    def __init__(self, stage: Stage, width: int, height: int) -> None:
        self._stage = stage
        self._size = width, height
        self._shapes = self._next = stage.shapes(0)
        self._shift = self._next_shift = stage.shift(0)
        self._everywhere = np.array([[0, 0, width, height]], np.int64)
        self._background = np.empty((height, width))
        self._scratch, self._linear, self.frame = (np.zeros((height, width)) for _ in range(3))
        self._move_background()
        self.draw(self._everywhere)

    def look(self, t_us: int) -> tuple[NDArray[np.int64], float]:
        """The rectangles that change until `t_us`, and the largest displacement, in pixels."""
        self._next, self._next_shift = self._stage.shapes(t_us), self._stage.shift(t_us)
        changed, moved_px = changes(self._shapes, self._next, *self._size)
        if self._next_shift != self._shift:
            changed = self._everywhere
            moved_px = max(moved_px, *(abs(now - was) for was, now in zip(self._shift, self._next_shift, strict=True)))
        return changed, moved_px

    def draw(self, changed: NDArray[np.int64]) -> NDArray[np.int64]:
        """Update the frame to the time of the last call of `look`; returns where it has changed, as `draw` of the kernel."""
        if self._next_shift != self._shift:
            self._shift = self._next_shift
            self._move_background()
        self._shapes = self._next
        stretches: NDArray[np.int64] = draw(changed, self._shapes, self._background, self._scratch, self._linear, self.frame)
        return stretches

    def _move_background(self) -> None:
        right, down = self._shift
        shift_texture(self._stage.background, MARGIN_PX - right, MARGIN_PX - down, self._background)


def texture(
    settings: StageSettings, random: np.random.Generator, grain_px: float, contrast: float, level: float = 1.0
) -> NDArray[np.float64]:
    """A background of random spots about `grain_px` wide: `level` times exp(contrast * normal deviate)."""
    from scipy.ndimage import gaussian_filter

    spots = gaussian_filter(random.standard_normal((settings.height + 2 * MARGIN_PX, settings.width + 2 * MARGIN_PX)), grain_px)
    return np.asarray(level * np.exp(contrast * spots / spots.std()))
