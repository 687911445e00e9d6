# SPDX-License-Identifier: Apache-2.0
"""Film a stage: shapes moving in front of a background, rendered as often as their motion requires, seen by a `PixelCamera`."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ..events import Recording
from ..ranges import check_ranges, setting
from ._occlusion_kernel import hidden_at
from ._order import KEY_T_SHIFT, unpacked
from ._render_kernel import changes, displacement, draw, shift_texture
from .pixel import PixelCamera, PixelModel
from .truth import TRUTH, Scene, Truth, on_sensor

__all__ = ["MARGIN_PX", "Moments", "Stage", "StageSettings", "SteadyStage", "film", "texture"]

MARGIN_PX = 16  # of a background, on every side: limit of camera shake

_MOVE_PX = 0.5  # maximum displacement between two frames
_AIM = 0.9  # fraction of that to aim for, so that a step rarely has to be repeated
_STEP_MAX_US = 5_000
_BATCH = 31  # frames whose events are computed at once: with the one before, a multiple of a vector's length
_AT_ONCE = 100  # samples of the truth


@dataclass(frozen=True)
class StageSettings:
    """Settings common to all filmed scenes.

    Raises:
        ConfigError: a value outside its range.
    """

    NAME: ClassVar[str] = "scene"

    width: int = setting(346, 64, 4096, "pixels of the sensor across")
    height: int = setting(260, 64, 4096, "pixels of the sensor down")
    duration_us: int = setting(4_000_000, 1_000, 1_000_000_000, "length of the scene")
    seed: int = setting(1, 0, 2**63 - 1, "seed of everything random")
    truth_step_us: int = setting(1_000, 1, 1_000_000, "time between two samples of the truth")
    pixel: PixelModel = field(default_factory=lambda: PixelModel(mismatch=0.03, refractory_us=300, noise_hz=0.1))

    def __post_init__(self) -> None:
        check_ranges(self.NAME, self)


class Moments(NamedTuple):
    """The shapes and objects of some moments, one after the other.

    Attributes:
        shapes: (n, columns), see `shapes`.
        shape_ends: (k,) end of each moment's shapes.
        objects: (m,) of dtype `TRUTH`, as of `Stage.objects`.
        object_ends: (k,) end of each moment's objects.
    """

    shapes: NDArray[np.float64]
    shape_ends: NDArray[np.int64]
    objects: NDArray[np.void]
    object_ends: NDArray[np.int64]


class Stage(Protocol):
    """Interface of a scene to be filmed.

    Attributes:
        background: (height + 2 MARGIN_PX, width + 2 MARGIN_PX) linear intensity.
    """

    background: NDArray[np.float64]

    def shapes(self, t_us: float) -> NDArray[np.float64]:
        """The shapes in front of the background, the farthest first; see `shapes`."""

    def objects(self, t_us: float) -> NDArray[np.void]:
        """Position, size and velocity of each object, of dtype `TRUTH`, by `object_id`; the other fields are not set."""

    def moments(self, times_us: NDArray[np.int64]) -> Moments:
        """What `shapes` and `objects` return, at each of some times."""

    def shift(self, t_us: float) -> tuple[float, float]:
        """Displacement of the background, pixels right and down, at most MARGIN_PX - 1."""


class SteadyStage(ABC):
    """A stage whose number of shapes and of objects never changes. `shapes` and `objects` also take (k,) times, and then return
    arrays with another axis in front."""

    @abstractmethod
    def shapes(self, t_us: float | NDArray[np.int64]) -> NDArray[np.float64]:
        """See `Stage`."""

    @abstractmethod
    def objects(self, t_us: float | NDArray[np.int64]) -> NDArray[np.void]:
        """See `Stage`."""

    def moments(self, times_us: NDArray[np.int64]) -> Moments:
        """See `Stage`."""
        shapes, objects = self.shapes(times_us), self.objects(times_us)
        moment = np.arange(1, len(times_us) + 1)
        return Moments(
            shapes.reshape(-1, shapes.shape[-1]), moment * shapes.shape[1], objects.ravel(), moment * objects.shape[1]
        )

    def shift(self, _t_us: float) -> tuple[float, float]:
        """See `Stage`: the background stands still."""
        return 0.0, 0.0


def film(stage: Stage, settings: StageSettings) -> Scene:
    """Events in [0, duration_us) and truth every `truth_step_us`; equal settings give identical results."""
    width, height, end_us = settings.width, settings.height, settings.duration_us
    camera = PixelCamera(settings.pixel, width, height, settings.seed, linear=True)
    canvas = _Canvas(stage, width, height)
    camera.step(canvas.picture, 0)
    blocks: list[NDArray[np.int64]] = []
    batch, times_us = [canvas.shapes], [0]  # the last frame of which there are events, and those after it

    def develop() -> None:
        """Append the events of the batch, of which only the last frame then remains."""
        if len(batch) > 1:
            shapes = np.concatenate(batch).reshape(len(batch), *batch[0].shape)
            keys = camera.keys_of_shapes(shapes, np.array(times_us), canvas.background)
            blocks.append(keys + (times_us[0] << KEY_T_SHIFT))
            del batch[:-1], times_us[:-1]

    step_us = 1_000.0
    while (t_us := times_us[-1]) < end_us:
        step_us = min(step_us, _STEP_MAX_US, end_us - t_us)
        next_us = t_us + max(int(step_us), 1)
        moved_px = canvas.look(next_us)
        if moved_px > _MOVE_PX and next_us > t_us + 1:
            step_us = (next_us - t_us) * _AIM * _MOVE_PX / moved_px
            continue
        if not canvas.is_alike:
            develop()
            blocks.append(camera.keys(canvas.picture, next_us, canvas.draw()) + (t_us << KEY_T_SHIFT))
            batch.clear()
            times_us.clear()
        batch.append(canvas.advance())
        times_us.append(next_us)
        if len(batch) > _BATCH:
            develop()
        step_us = (next_us - t_us) * min(_AIM * _MOVE_PX / max(moved_px, 1e-9), 2.0)
    develop()
    events = unpacked(np.concatenate(blocks))
    events = events[: int(np.searchsorted(events.t_us, end_us))]
    truth = Truth(_samples(stage, range(0, end_us, settings.truth_step_us), (width, height)))
    return Scene(Recording(events, width, height, settings.NAME), truth, settings.seed)


def _samples(stage: Stage, times_us: Iterable[int], sensor: tuple[int, int]) -> NDArray[np.void]:
    """`Truth.samples` of a stage."""
    every_us = np.fromiter(times_us, np.int64)
    blocks = [np.empty(0, TRUTH)]
    for begin in range(0, len(every_us), _AT_ONCE):
        now_us = every_us[begin : begin + _AT_ONCE]
        shapes, shape_ends, objects, object_ends = stage.moments(now_us)
        objects["t_us"] = np.repeat(now_us, np.diff(object_ends, prepend=0))
        ids = np.array(objects["object_id"], np.int64)  # contiguous, so Numba compiles the kernel only once
        objects["occluded"] = hidden_at(shapes, shape_ends, ids, object_ends, *sensor)
        blocks.append(objects)
    samples = np.concatenate(blocks)
    samples["visible"] = on_sensor(samples, sensor)
    return samples


class _Canvas:
    """A picture that is redrawn only where something has moved.

    Attributes:
        shapes: those of the current frame.
        is_alike: whether those of the next one are the same, perhaps elsewhere, and the background is at rest.
        picture: (height, width) linear intensity; defined where the last call of `draw` has drawn.
    """

    def __init__(self, stage: Stage, width: int, height: int) -> None:
        self._stage = stage
        self._size = width, height
        self.shapes = self._next = stage.shapes(0)
        self._shift = self._next_shift = stage.shift(0)
        self.is_alike = True
        self._everywhere = np.array([[0, 0, width, height]], np.int64)
        self._background = np.empty((height, width))
        self._background_shift: tuple[float, float] | None = None
        self.picture = np.empty((height, width))
        draw(self._everywhere, self.shapes, self.background, self.picture)

    def look(self, t_us: int) -> float:
        """Make a time that of the next frame; the largest displacement until then, in pixels."""
        self._next, self._next_shift = self._stage.shapes(t_us), self._stage.shift(t_us)
        moved_px, self.is_alike = displacement(self.shapes, self._next, *self._size)
        if self._next_shift != self._shift:
            self.is_alike = False
            moved_px = max(moved_px, *(abs(now - was) for was, now in zip(self._shift, self._next_shift, strict=True)))
        return float(moved_px)

    def draw(self) -> NDArray[np.int64]:
        """Draw the next frame where it may differ from the current one; these rectangles."""
        if self._next_shift != self._shift:  # everything is redrawn, and perhaps once only from this background
            self._draw_background(self._next_shift, self.picture)
            draw(self._everywhere[:0], self._next, self.picture, self.picture)
            return self._everywhere
        changed: NDArray[np.int64] = changes(self.shapes, self._next, *self._size)
        draw(changed, self._next, self.background, self.picture)
        return changed

    def advance(self) -> NDArray[np.float64]:
        """Make the next frame the current one; its shapes."""
        self.shapes, self._shift = self._next, self._next_shift
        return self.shapes

    @property
    def background(self) -> NDArray[np.float64]:
        """(height, width) linear intensity behind the shapes of the current frame."""
        if self._background_shift != self._shift:
            self._draw_background(self._shift, self._background)
            self._background_shift = self._shift
        return self._background

    def _draw_background(self, shift: tuple[float, float], picture: NDArray[np.float64]) -> None:
        right, down = shift
        shift_texture(self._stage.background, MARGIN_PX - right, MARGIN_PX - down, picture)


def texture(
    settings: StageSettings, random: np.random.Generator, grain_px: float, contrast: float, level: float = 1.0
) -> NDArray[np.float64]:
    """A background of random spots about `grain_px` wide: `level` times exp(contrast * normal deviate)."""
    from scipy.ndimage import gaussian_filter

    spots = gaussian_filter(random.standard_normal((settings.height + 2 * MARGIN_PX, settings.width + 2 * MARGIN_PX)), grain_px)
    return np.asarray(level * np.exp(contrast * spots / spots.std()))
