# SPDX-License-Identifier: Apache-2.0
"""Estimates of the adaptive tracker about a scene: noise, hot pixels, and the number, size and speed of its objects.

See docs/adaptive.md, "What is estimated".
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...events import Events
from ...recordings.formats.source import Sensor
from .config import AdaptiveConfig
from .tracker import AdaptiveTracker

__all__ = ["SAMPLE_US", "Estimates", "ObservedTracker", "Spread"]

SAMPLE_US = 50_000  # between two samples of the tracker's state
_LEAST_SAMPLES = 20  # of objects: fewer tell nothing
_LATEST = 0.99  # of the time, that many objects at most are alive
_LOW, _HIGH = 0.1, 0.9  # of the samples of objects
_HOT = 0.5  # of the samples after the first second, in which a hot pixel was ignored
_HOT_US = 1_000_000
_PER_DECADE = 100  # bins of a histogram
_LOWEST, _DECADES = 1e-2, 8


@dataclass(frozen=True)
class Spread:
    """What 10 % and 90 % of the values lie below."""

    low: float
    high: float


@dataclass(frozen=True)
class Estimates:
    """Estimates about a scene. As a string, they are a line for people.

    Attributes:
        sensor: (width, height) in pixels.
        seen_us: length of the stream so far.
        noise_hz: events per pixel and second of the background, the median; None if there was too little to tell.
        hot: number of pixels that never rest.
        alive_most: objects at once, exceeded in 1 % of the samples.
        half_px: longer half sides of the objects; None if too few were seen to tell.
        speed_px_s: their speeds; None likewise.
    """

    sensor: Sensor
    seen_us: int = 0
    noise_hz: float | None = None
    hot: int = 0
    alive_most: int = 0
    half_px: Spread | None = None
    speed_px_s: Spread | None = None

    def __str__(self) -> str:
        said = [f"adaptive: {self.sensor[0]}x{self.sensor[1]}", f"{self.seen_us / 1e6:.3g} s"]
        said.append("noise unknown" if self.noise_hz is None else f"noise {self.noise_hz:.2g} Hz/pixel")
        said.append(f"{self.hot} hot pixel{'' if self.hot == 1 else 's'}")
        size, speed = self.half_px, self.speed_px_s
        if size is None or speed is None:
            return ", ".join([*said, "no object seen for long enough"])
        said.append(f"up to {self.alive_most} object{'' if self.alive_most == 1 else 's'}")
        said[-1] += f" of {2 * size.low:.0f} to {2 * size.high:.0f} px"
        return ", ".join([*said, f"{speed.low:.0f} to {speed.high:.0f} px/s"])


class _Histogram:
    """Counts of positive values in bins of equal ratio: memory does not grow with the stream."""

    def __init__(self) -> None:
        self._counts = np.zeros(_DECADES * _PER_DECADE, np.int64)

    def add(self, values: NDArray[np.float64]) -> None:
        """Count values, (n,)."""
        bins = (np.log10(np.maximum(values, _LOWEST) / _LOWEST) * _PER_DECADE).astype(np.int64)
        np.add.at(self._counts, np.minimum(bins, len(self._counts) - 1), 1)

    @property
    def any(self) -> bool:
        """Whether any was counted."""
        return bool(self._counts.any())

    def quantile(self, share: float) -> float:
        """The value that a share of all lies below."""
        at = int(np.searchsorted(np.cumsum(self._counts), share * self._counts.sum()))
        return float(_LOWEST * 10.0 ** ((at + 0.5) / _PER_DECADE))

    def spread(self) -> Spread | None:
        """None if there are too few to tell."""
        if self._counts.sum() < _LEAST_SAMPLES:
            return None
        return Spread(self.quantile(_LOW), self.quantile(_HIGH))


class ObservedTracker:
    """The adaptive tracker, whose state is sampled every `SAMPLE_US` of the stream. See `tracks.tracking.Tracker`.

    What it returns is what the tracker returns, and what is estimated does not depend on how events are split into runs.
    """

    def __init__(self, config: AdaptiveConfig, width: int, height: int) -> None:
        self._tracker = AdaptiveTracker(config, width, height)
        self._sensor = width, height
        self._first_us: int | None = None
        self._next_us = self._last_us = 0
        self._hot = np.zeros((height, width), np.int32)
        self._hot_samples = 0
        self._noise = _Histogram()
        self._alive = np.zeros(config.max_objects + 1, np.int64)
        self._half_px, self._speed_px_s = _Histogram(), _Histogram()

    def feed(self, events: Events) -> tuple[NDArray[np.void], NDArray[np.int16]]:
        """See `AdaptiveTracker.feed`."""
        if not len(events):
            return self._tracker.feed(events)
        if self._first_us is None:
            self._first_us = int(events.t_us[0])
            self._next_us = self._first_us + SAMPLE_US
        parts = []
        begin = 0
        while begin < len(events):
            end = int(np.searchsorted(events.t_us, self._next_us))
            if end > begin:
                parts.append(self._tracker.feed(events[begin:end]))
                begin = end
            if begin < len(events):
                self._sample()
                self._next_us += SAMPLE_US * ((int(events.t_us[begin]) - self._next_us) // SAMPLE_US + 1)
        self._last_us = int(events.t_us[-1])
        records, owners = zip(*parts, strict=True)
        return np.concatenate(records), np.concatenate(owners)

    def finish(self) -> NDArray[np.void]:
        """See `AdaptiveTracker.finish`."""
        return self._tracker.finish()

    @property
    def settled(self) -> int:
        """See `tracks.tracking.Tracker`."""
        return self._tracker.settled

    def _sample(self) -> None:
        noise_hz = self._tracker.noise_hz
        if noise_hz is not None:
            self._noise.add(np.array([noise_hz]))
        seen = self._tracker.sightings()
        self._alive[len(seen)] += 1
        if len(seen):
            self._half_px.add(np.maximum(seen["half_x"], seen["half_y"]))
            self._speed_px_s.add(seen["speed_px_s"])
        if self._next_us - (self._first_us or 0) >= _HOT_US:
            self._hot += self._tracker.restless()
            self._hot_samples += 1

    def estimates(self) -> Estimates:
        """The estimates so far."""
        samples = np.cumsum(self._alive)
        return Estimates(
            self._sensor,
            self._last_us - self._first_us if self._first_us is not None else 0,
            self._noise.quantile(0.5) if self._noise.any else None,
            int(np.count_nonzero(self._hot > _HOT * self._hot_samples)),
            int(np.searchsorted(samples, _LATEST * samples[-1])),
            self._half_px.spread(),
            self._speed_px_s.spread(),
        )
