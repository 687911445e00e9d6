# SPDX-License-Identifier: Apache-2.0
"""Estimates of the adaptive tracker about a scene: noise, hot pixels, and the number, size and speed of its objects.

See docs/adaptive.md, "What is estimated".
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...events import Events, check_pixels
from ...recordings.formats.source import Sensor
from .config import AdaptiveConfig
from .tracker import AdaptiveTracker

__all__ = [
    "SAMPLE_US",
    "SEEN_EVENTS",
    "SEEN_US",
    "Estimates",
    "Histogram",
    "Objects",
    "ObservedTracker",
    "Spread",
    "at_once",
    "estimate",
    "line",
]

SEEN_US, SEEN_EVENTS = 60_000_000, 20_000_000  # of a recording: what comes later is not looked at
SAMPLE_US = 50_000  # between two looks at the tracker
_LEAST_SAMPLES = 20  # of objects: fewer tell nothing
_LATEST = 0.99  # of the time, that many objects at most are alive
_LOW, _HIGH = 0.1, 0.9  # of the time that objects are seen
_HOT = 0.5  # of the looks after the first second, in which a hot pixel was ignored
_HOT_US = 1_000_000
_PER_DECADE = 100  # bins of a histogram
_LOWEST, _DECADES = 1e-2, 8


@dataclass(frozen=True)
class Spread:
    """What 10 %, 50 % and 90 % of the values lie below."""

    low: float
    median: float
    high: float


@dataclass(frozen=True)
class Objects:
    """What objects are like, as often as each was seen.

    Attributes:
        half_px: half sides, the mean of both axes.
        long_px: the longer half side.
        speed_px_s: speed.
        pixels_per_px: pixels that one sends while it travels one pixel.
    """

    half_px: Spread
    long_px: Spread
    speed_px_s: Spread
    pixels_per_px: Spread


@dataclass(frozen=True)
class Estimates:
    """What was seen of a scene.

    Attributes:
        sensor: (width, height) in pixels.
        seen_us: length of the stream that was looked at.
        events: in it.
        noise_hz: events per pixel and second of the background; None if there was too little to tell.
        hot_pixels: (x, y) of those that never rest.
        alive: objects alive at once, as a rule.
        alive_most: the same at 99 % of all times.
        objects: None if too few were seen to tell.
    """

    sensor: Sensor
    seen_us: int = 0
    events: int = 0
    noise_hz: float | None = None
    hot_pixels: tuple[tuple[int, int], ...] = ()
    alive: int = 0
    alive_most: int = 0
    objects: Objects | None = None

    def __str__(self) -> str:
        """A line for people."""
        size, speed = (self.objects.long_px, self.objects.speed_px_s) if self.objects else (None, None)
        return line(self.sensor, self.seen_us, self.noise_hz, len(self.hot_pixels), self.alive_most, size, speed)


def line(
    sensor: Sensor, seen_us: int, noise_hz: float | None, hot: int, most: int, half_px: Spread | None, speed_px_s: Spread | None
) -> str:
    """What was seen of a scene, for people; None is unknown.

    Args:
        hot: number of pixels that never rest.
        most: objects at once.
        half_px: their longer half sides.
    """
    said = [f"auto: {sensor[0]}x{sensor[1]}", f"{seen_us / 1e6:.3g} s"]
    said.append("noise unknown" if noise_hz is None else f"noise {noise_hz:.2g} Hz/pixel")
    said.append(f"{hot} hot pixel{'' if hot == 1 else 's'}")
    if half_px is None or speed_px_s is None:
        return ", ".join([*said, "no object seen for long enough"])
    sizes, speeds = f"{2 * half_px.low:.0f} to {2 * half_px.high:.0f} px", f"{speed_px_s.low:.0f} to {speed_px_s.high:.0f} px/s"
    return ", ".join([*said, f"up to {most} object{'' if most == 1 else 's'} of {sizes}", speeds])


def at_once(looks: NDArray[np.int64], share: float = _LATEST) -> int:
    """How many objects are alive at once, at most, for a share of the time.

    Args:
        looks: (n,) number of looks at which there were 0, 1, 2 … of them.
    """
    return int(np.searchsorted(np.cumsum(looks), share * looks.sum()))


class Histogram:
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
        return Spread(self.quantile(_LOW), self.quantile(0.5), self.quantile(_HIGH))


class ObservedTracker:
    """The adaptive tracker, looked at every `SAMPLE_US` of the stream. See `tracks.tracking.Tracker`.

    What it returns is what the tracker returns, and what is estimated does not depend on how events are split into runs.
    """

    def __init__(self, config: AdaptiveConfig, width: int, height: int) -> None:
        self._tracker = AdaptiveTracker(config, width, height)
        self._sensor = width, height
        self._first_us: int | None = None
        self._next_us = self._last_us = 0
        self._events = 0
        self._hot = np.zeros((height, width), np.int32)
        self._hot_looks = 0
        self._noise = Histogram()
        self._alive = np.zeros(config.max_objects + 1, np.int64)
        self._spreads = {name: Histogram() for name in ("half_px", "long_px", "speed_px_s", "pixels_per_px")}

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
                self._look()
                self._next_us += SAMPLE_US * ((int(events.t_us[begin]) - self._next_us) // SAMPLE_US + 1)
        self._events += len(events)
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

    def _look(self) -> None:
        noise_hz = self._tracker.noise_hz
        if noise_hz is not None:
            self._noise.add(np.array([noise_hz]))
        seen = self._tracker.sightings()
        self._alive[len(seen)] += 1
        if len(seen):
            self._spreads["half_px"].add(0.5 * (seen["half_x"] + seen["half_y"]))
            self._spreads["long_px"].add(np.maximum(seen["half_x"], seen["half_y"]))
            self._spreads["speed_px_s"].add(seen["speed_px_s"])
            self._spreads["pixels_per_px"].add(seen["pixels_per_px"])
        if self._next_us - (self._first_us or 0) >= _HOT_US:
            self._hot += self._tracker.restless()
            self._hot_looks += 1

    def estimates(self) -> Estimates:
        """What was seen so far."""
        rows, columns = np.nonzero(self._hot > _HOT * self._hot_looks)
        spreads = {name: values.spread() for name, values in self._spreads.items()}
        seen = {name: spread for name, spread in spreads.items() if spread is not None}
        return Estimates(
            self._sensor,
            self._last_us - self._first_us if self._first_us is not None else 0,
            self._events,
            self._noise.quantile(0.5) if self._noise.any else None,
            tuple(zip(columns.tolist(), rows.tolist(), strict=True)),
            at_once(self._alive, 0.5),
            at_once(self._alive),
            Objects(**seen) if seen else None,
        )


def estimate(blocks: Iterable[Events], sensor: Sensor, config: AdaptiveConfig | None = None) -> Estimates:
    """What is seen in the first part of a recording, `SEEN_US` or `SEEN_EVENTS`, by one pass of the adaptive tracker.

    Args:
        blocks: its events in time order.
    """
    check_pixels(*sensor)
    observed = ObservedTracker(config or AdaptiveConfig(), *sensor)
    end_us: int | None = None
    left = SEEN_EVENTS
    for block in blocks:
        if len(block) and end_us is None:
            end_us = int(block.t_us[0]) + SEEN_US
        n = min(int(np.searchsorted(block.t_us, end_us)) if end_us is not None else 0, left)
        observed.feed(block[:n])
        left -= n
        if n < len(block):
            break
    return observed.estimates()
