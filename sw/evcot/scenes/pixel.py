# SPDX-License-Identifier: Apache-2.0
"""Pixel model of an event camera: a pixel emits an event when log intensity has changed by a threshold, dI = pK.

Pixels also emit spontaneous events, which do not depend on how time is divided into steps.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit
from ..errors import ConfigError
from ..events import Events, check_sensor
from ..ranges import check_ranges, setting
from ._batch_kernel import batch_events
from ._order import unpacked, without_intervals
from ._pixel_kernel import LOG_INTENSITY_MAX, are_within, begin, levels_of, pixel_events
from ._render_kernel import draw

__all__ = ["OWN", "PixelCamera", "PixelModel", "Spontaneous"]

OWN = np.dtype([("t_us", "f8"), ("x", "i8"), ("y", "i8"), ("p", "i8")])

_CHUNK = 4096


class Spontaneous:
    """Background activity and leak, which are Poisson processes over the sensor, and hot pixels, which fire periodically.

    Attributes:
        hot: (hot_pixels, 2) int64, x and y.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        noise_hz: float,
        leak_hz: float,
        hot_pixels: int,
        hot_hz: float,
        random: np.random.Generator,
    ) -> None:
        height, width = self._shape = shape
        places = random.choice(width * height, hot_pixels, replace=False).astype(np.int64)
        self.hot = np.stack((places % width, places // width), axis=1)
        self._hot_p = random.integers(0, 2, hot_pixels)
        self._period_us = 1e6 / hot_hz
        self._phase_us = random.uniform(0, self._period_us, hot_pixels)
        self._rate_hz = (noise_hz + leak_hz) * width * height
        self._leak_share = leak_hz / (noise_hz + leak_hz) if self._rate_hz else 0.0
        self._random = random
        self._ahead = np.empty(0, OWN)
        self._last_us = 0.0

    def between(self, times_us: NDArray[np.int64]) -> tuple[NDArray[np.void], NDArray[np.int64]]:
        """The events in (a, b] of each interval from a time to the next, of dtype `OWN`, by time, relative to a; and the end of
        each interval in them. Of equal times, events of hot pixels come last. Each call must continue where the previous one
        ended."""
        own, ends = _with_beats(
            self._background(int(times_us[-1])), self.hot, self._hot_p, self._phase_us, self._period_us, times_us
        )
        if len(self.hot):
            own = own[np.argsort(own["t_us"], kind="stable")]
        own["t_us"] -= np.repeat(times_us[:-1], np.diff(ends, prepend=0))
        return own, ends

    def _background(self, to_us: int) -> NDArray[np.void]:
        """Background events up to `to_us`, drawn ahead in chunks; later ones are kept."""
        chunks = [self._ahead]
        while self._rate_hz and self._last_us <= to_us:
            chunks.append(self._chunk())
            self._last_us = float(chunks[-1]["t_us"][-1])
        drawn = np.concatenate(chunks) if len(chunks) > 1 else self._ahead
        due = int(np.searchsorted(drawn["t_us"], to_us, side="right"))
        self._ahead = drawn[due:]
        return drawn[:due]

    def _chunk(self) -> NDArray[np.void]:
        height, width = self._shape
        chunk = np.empty(_CHUNK, OWN)
        chunk["t_us"] = self._last_us + np.cumsum(self._random.exponential(1e6 / self._rate_hz, _CHUNK))
        chunk["x"] = self._random.integers(0, width, _CHUNK)
        chunk["y"] = self._random.integers(0, height, _CHUNK)
        leak = self._random.random(_CHUNK) < self._leak_share
        chunk["p"] = np.where(leak, 1, self._random.integers(0, 2, _CHUNK))
        return chunk


@njit(cache=True, nogil=True, error_model="numpy")
def _with_beats(background, hot, polarity, phase_us, period_us, times_us):  # type: ignore[no-untyped-def]
    """Background events and then those of hot pixels, for each interval, and the end of each interval in them."""
    beats = np.empty((len(hot), len(times_us)), np.int64)  # of each hot pixel, the first after each time
    for i in range(len(hot)):
        for k in range(len(times_us)):
            beats[i, k] = max(int(np.floor((times_us[k] - phase_us[i]) / period_us)) + 1, 0)
    own = np.empty(len(background) + (beats[:, -1] - beats[:, 0]).sum(), background.dtype)
    ends = np.empty(len(times_us) - 1, np.int64)
    n, taken = 0, 0
    for k in range(len(ends)):
        from_us, to_us = times_us[k], times_us[k + 1]
        while taken < len(background) and background[taken].t_us <= to_us:
            own[n] = background[taken]
            n, taken = n + 1, taken + 1
        for i in range(len(hot)):
            for beat in range(beats[i, k], beats[i, k + 1]):
                own[n].t_us = min(max(phase_us[i] + beat * period_us, from_us), to_us)
                own[n].x, own[n].y, own[n].p = hot[i, 0], hot[i, 1], polarity[i]
                n += 1
        ends[k] = n
    return own, ends


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
