# SPDX-License-Identifier: Apache-2.0
"""A golden model behind filters that follow the noise: the tracker for any recording, and for a live stream."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..events import Events
from ..filters.config import FilterConfig
from ..filters.following import FollowingChain
from ..hardware.config import CotConfig, MotionConfig
from ..hardware.golden import GoldenTracker
from ..recordings.formats.source import Sensor
from ..tracks.log import Kind
from ..tracks.tracking import TrackerOutput
from .adaptive.estimates import SAMPLE_US, Histogram, at_once, line

__all__ = ["FollowingTracker"]

_SIGHTING = np.dtype([("sample", "i8"), ("slot", "i8"), ("half_px", "f8"), ("speed_px_s", "f8")])


class FollowingTracker(GoldenTracker):
    """The model, as the hardware would be with `activity_support` rewritten every 20 ms. See `tracking.Tracker`.

    Args:
        config: without filters.
        filters: those before it.
        sensor: (width, height) in pixels.

    `str` of it says what it has seen of the scene so far.
    """

    def __init__(self, config: CotConfig | MotionConfig, filters: FilterConfig, sensor: Sensor) -> None:
        registers, shape = filters.registers(config.tick_us), filters.shape(*sensor)
        self._chain = FollowingChain(registers, shape, filters.activity_noise_hz, config.tick_us)
        super().__init__(config, before=self._chain)
        self._sensor, self._within_us = sensor, filters.activity_us
        self._first_us: int | None = None
        self._last_us = 0
        self._sightings = _Sightings(config.shape.n_slots)

    def feed(self, events: Events) -> TrackerOutput:
        """See `tracking.Tracker`."""
        records, owner = super().feed(events)
        self._sightings.add(records)
        if len(events):
            self._first_us = int(events.t_us[0]) if self._first_us is None else self._first_us
            self._last_us = int(events.t_us[-1])
        return records, owner

    def __str__(self) -> str:
        lasted_us = 0 if self._first_us is None else self._last_us - self._first_us
        hot, seen = int(np.count_nonzero(self._chain.restless)), self._sightings
        half_px, speed_px_s = seen.half_px.spread(), seen.speed_px_s.spread()
        said = line(self._sensor, lasted_us, self._chain.noise_hz, hot, at_once(seen.alive), half_px, speed_px_s)
        support = self._chain.support
        if support is None:
            return said
        return f"{said} -> at the end an event needs {support} of 8 neighbours within {self._within_us / 1e3:g} ms"


class _Sightings:
    """Boxes and speeds of the tracks, once in each `SAMPLE_US` in which they move; memory does not grow.

    Attributes:
        alive: how often 1, 2 … of them moved at once.
    """

    def __init__(self, n_slots: int) -> None:
        self.half_px, self.speed_px_s = Histogram(), Histogram()
        self.alive = np.zeros(n_slots + 1, np.int64)
        self._open = np.zeros(0, _SIGHTING)

    def add(self, records: NDArray[np.void]) -> None:
        moved = records[records["kind"] == Kind.MOVED]
        if not len(moved):
            return
        seen = np.empty(len(moved), _SIGHTING)
        seen["sample"], seen["slot"] = moved["t_us"] // SAMPLE_US, moved["slot"]
        seen["half_px"] = 0.5 * np.maximum(moved["width"], moved["height"])
        seen["speed_px_s"] = np.hypot(moved["vx"], moved["vy"])
        seen = np.concatenate([self._open, seen])[::-1]
        _, last = np.unique(seen["sample"] * len(self.alive) + seen["slot"], return_index=True)
        seen = seen[last]
        ended = seen["sample"] < seen["sample"][-1]
        self._open, seen = seen[~ended], seen[ended]
        self.alive += np.bincount(np.unique(seen["sample"], return_counts=True)[1], minlength=len(self.alive))
        self.half_px.add(seen["half_px"])
        self.speed_px_s.add(seen["speed_px_s"])
