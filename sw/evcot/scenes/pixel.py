# SPDX-License-Identifier: Apache-2.0
"""Pixel model of an event camera: a pixel emits an event when log intensity has changed by a threshold, dI = pK."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError
from ..events import Events, check_sensor
from ..ranges import check_ranges, setting
from ._batch_kernel import batch_events
from ._order import unpacked, without_intervals
from ._pixel_kernel import LOG_INTENSITY_MAX, are_within, begin, levels_of, pixel_events
from ._render_kernel import draw
from ._spontaneous import Spontaneous

__all__ = ["PixelCamera", "PixelModel"]

_LOWEST = 0.1  # of a threshold: below, mismatch is clipped
_SPAN_MAX_US = 1 << 30


@dataclass(frozen=True)
class PixelModel:
    """Settings of the pixels.

    Thresholds of the pixels are normally distributed around the nominal ones, ON and OFF independently, and at least a tenth of
    them. Background activity and leak are Poisson processes; a hot pixel fires periodically, always with one polarity. Every
    event starts the refractory time and resets the stored value: with a refractory time, to the log intensity at its end
    (changes in between are lost); without, by one threshold, or, for a spontaneous event, to the current log intensity.

    Raises:
        ConfigError: a value outside its range.
    """

    on_threshold: float = setting(0.2, 0.01, 5.0, "rise of log intensity, to base e, that makes an ON event")
    off_threshold: float = setting(0.2, 0.01, 5.0, "fall of log intensity, to base e, that makes an OFF event")
    mismatch: float = setting(0.0, 0.0, 0.5, "standard deviation of thresholds over the pixels, as a part of the threshold")
    refractory_us: int = setting(0, 0, 1_000_000, "time after an event in which a pixel makes no other")
    noise_hz: float = setting(0.0, 0.0, 1_000.0, "background activity: events per pixel and second, of either polarity")
    leak_hz: float = setting(0.0, 0.0, 1_000.0, "leak: ON events per pixel and second")
    hot_pixels: int = setting(0, 0, 1_000_000, "how many pixels fire all the time")
    hot_hz: float = setting(10_000.0, 0.001, 1_000_000.0, "events per second of a hot pixel")

    def __post_init__(self) -> None:
        check_ranges("pixel", self)


class PixelCamera:
    """Converts frames to events.

    Attributes:
        on_threshold, off_threshold: (height, width) thresholds of the pixels.
        hot: (hot_pixels, 2) int64, x and y of the hot pixels.
    """

    def __init__(self, model: PixelModel, width: int, height: int, seed: int, *, linear: bool = False) -> None:
        """
        Args:
            linear: frames hold linear intensity instead of log intensity; the logarithm is taken only in pixels that may make
                an event.

        Raises:
            ConfigError: more hot pixels than pixels, or a negative seed.
            RecordingError: a sensor without pixels, or larger than an event's address.
        """
        check_sensor("camera", width, height)
        if model.hot_pixels > width * height:
            raise ConfigError(f"pixel.hot_pixels = {model.hot_pixels}: must be at most the sensor's {width * height} pixels")
        if seed < 0:
            raise ConfigError(f"camera.seed = {seed}: must not be negative")
        thresholds, spontaneous = (np.random.default_rng(part) for part in np.random.SeedSequence(seed).spawn(2))
        self._refractory_us = model.refractory_us
        self._linear = linear
        self._shape = height, width
        self.on_threshold, self.off_threshold = (
            np.maximum(nominal * (1 + model.mismatch * thresholds.standard_normal(self._shape)), _LOWEST * nominal)
            for nominal in (model.on_threshold, model.off_threshold)
        )
        self._own = Spontaneous(self._shape, model.noise_hz, model.leak_hz, model.hot_pixels, model.hot_hz, spontaneous)
        self.hot = self._own.hot
        self._t_us: int | None = None
        self._everywhere = np.array([[0, 0, width, height]], np.int64)
        self._head = np.full(self._shape, -1, np.int64)
        self._maps: tuple[NDArray[Any], ...] | None = None  # of `batch_events`
        self._shown: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None  # shapes and background not yet in `_pixels`

    def step(self, frame: NDArray[np.float64], t_us: int, changed: NDArray[np.int64] | None = None) -> Events:
        """The events after the previous frame up to this one, in time order; none for the first frame.

        Args:
            frame: (height, width) float64, log intensity to base e, or, of a linear camera, positive intensity.
            t_us: time of the frame, later than that of the previous one.
            changed: (n, 4) int64 left, top, right, bottom, half open: where the frame may differ from the previous one. The
                rest of the frame is not read, so that the cost depends on motion, not on sensor size. None: everywhere.

        Raises:
            ConfigError: a frame of another size, a rectangle outside it, a time that does not advance or advances by more than
                2**30 us, or a log intensity that is not a number from -100 to 100.
        """
        last_us = self._t_us
        keys = self.keys(frame, t_us, changed)
        events = unpacked(keys)
        if last_us is not None:
            np.add(events.t_us, last_us, out=events.t_us)
        return events

    def keys(self, frame: NDArray[np.float64], t_us: int, changed: NDArray[np.int64] | None = None) -> NDArray[np.int64]:
        """The same as sorted keys (see `_order`), with times relative to the previous frame."""
        if frame.shape != self._shape or frame.dtype != np.float64:
            raise ConfigError(f"frame: {frame.dtype} {frame.shape}: must be float64 {self._shape}")
        if changed is None:
            changed = self._everywhere
        elif not are_within(changed, self._shape[1], self._shape[0]):
            raise ConfigError(f"changed: must lie within the sensor's {self._shape[1]}x{self._shape[0]} pixels")
        if self._t_us is None:
            self._begin(frame, t_us)
            return np.empty(0, np.int64)
        span_us = t_us - self._t_us
        if not 0 < span_us <= _SPAN_MAX_US:
            raise ConfigError(f"t_us = {t_us}: must be from 1 to {_SPAN_MAX_US} us after the last frame's {self._t_us}")
        if self._shown is not None:
            draw(self._everywhere, *self._shown, self._pixels[0])
            self._shown = None
        own, _ = self._own.between(np.array([self._t_us, t_us]) - self._begin_us)
        keys, fault = pixel_events(
            changed, frame, self._linear, self._pixels, self._head, own, float(self._t_us), float(span_us),
            float(self._refractory_us),
        )  # fmt: skip
        if fault >= 0:
            self._refuse(frame, fault % self._shape[1], fault // self._shape[1])
        self._t_us = t_us
        return np.sort(keys)

    def keys_of_shapes(
        self, shapes: NDArray[np.float64], times_us: NDArray[np.int64], background: NDArray[np.float64]
    ) -> NDArray[np.int64]:
        """What `keys` of a linear camera gives for several frames, which show shapes in front of a background, one after the
        other; with times relative to the last frame before.

        Args:
            shapes: (k + 1, n, columns) float64, the same shapes in that frame and in each of these; see `shapes`.
            times_us: (k + 1,) the times of all these frames.
            background: (height, width) positive intensity.
        """
        if self._maps is None:
            dark, bright = np.empty((2, *self._shape), np.float32)
            self._maps = np.full(self._shape, -1, np.int32), dark, bright
        own, own_ends = self._own.between(times_us - self._begin_us)
        keys = batch_events(
            shapes, times_us, background, self._pixels, self._maps, self._head, own, own_ends, float(self._refractory_us)
        )
        self._shown = shapes[-1], background
        self._t_us = int(times_us[-1])
        return cast("NDArray[np.int64]", without_intervals(np.sort(keys), times_us))

    def _begin(self, frame: NDArray[np.float64], t_us: int) -> None:
        """Initialise the pixels to a steady state on this frame."""
        frame = np.ascontiguousarray(frame)
        levels = levels_of(frame, self._linear)
        sound = abs(levels) <= LOG_INTENSITY_MAX
        if not sound.all():
            y, x = np.argwhere(~sound)[0].tolist()
            self._refuse(frame, x, y)
        self._pixels = begin(frame, levels, self._linear, self.on_threshold, self.off_threshold)
        self._t_us = self._begin_us = t_us

    def _refuse(self, frame: NDArray[np.float64], x: int, y: int) -> None:
        limit, level = f"{LOG_INTENSITY_MAX:g}", levels_of(frame[y : y + 1, x : x + 1], self._linear)[0, 0]
        raise ConfigError(f"frame: log intensity {level:g} at ({x}, {y}): must be from -{limit} to {limit}")
