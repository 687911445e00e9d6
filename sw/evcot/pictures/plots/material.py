# SPDX-License-Identifier: Apache-2.0
"""Input data of a figure: events per pixel, and track logs over a window of time."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...events import Events, check_pixels
from ...recordings.formats.source import Sensor
from ...tracks.log import TrackLog
from ...tracks.timeline import alive, lifetimes, sample
from ..panels import TimeAxis

__all__ = ["Log", "Material", "density"]

_SAMPLES = 2_000  # number of sample times in a window


@dataclass(frozen=True)
class Log:
    """A track log and its display name."""

    name: str
    log: TrackLog


@dataclass(frozen=True)
class Material:
    """Events and logs in a window of time.

    Attributes:
        counts: (height, width) events per pixel.
        logs: one or more.
        from_us, to_us: start and end of the window, in the recording's time.
        zero_us: origin of the time axis.
    """

    counts: NDArray[np.int64]
    logs: tuple[Log, ...]
    from_us: int
    to_us: int
    zero_us: int

    @cached_property
    def times_us(self) -> NDArray[np.int64]:
        """Sample times, evenly spaced over the window."""
        return np.unique(np.linspace(self.from_us, max(self.to_us, self.from_us + 1), _SAMPLES).astype(np.int64))

    @cached_property
    def axis(self) -> TimeAxis:
        """Times as positions on the axis."""
        return TimeAxis(self.zero_us, self.to_us - self.from_us)

    def paths(self, log: Log) -> dict[int, NDArray[np.void]]:
        """Track id -> states in the window in order of time, of dtype `timeline.SAMPLE`; tracks in order of birth."""
        states = sample(log.log, self.times_us)
        states = states[np.argsort(states["track_id"], kind="stable")]
        ids, begin = np.unique(states["track_id"], return_index=True)
        return dict(zip(ids.tolist(), np.split(states, begin[1:]), strict=False)) if len(ids) else {}

    def lives(self, log: Log) -> NDArray[np.void]:
        """The lives that overlap the window, of dtype `timeline.LIFE`, in order of birth."""
        lives = lifetimes(log.log, self.to_us)
        touching: NDArray[np.void] = lives[(lives["birth_us"] <= self.to_us) & (lives["end_us"] >= self.from_us)]
        return touching

    def alive(self, log: Log) -> NDArray[np.int64]:
        """Number of visible tracks at each of `times_us`."""
        return alive(log.log, self.times_us)


def density(blocks: Iterable[Events], sensor: Sensor) -> tuple[NDArray[np.int64], int, int]:
    """(height, width) events per pixel, and the times of the first and the last event; (0, 0) without events."""
    width, height = sensor
    check_pixels(width, height)
    counts = np.zeros(width * height, np.int64)
    first_us: int | None = None
    last_us = 0
    for block in blocks:
        if len(block):
            counts += np.bincount(block.y.astype(np.int64) * width + block.x, minlength=width * height)
            first_us = int(block.t_us[0]) if first_us is None else first_us
            last_us = int(block.t_us[-1])
    return counts.reshape(height, width), first_us or 0, last_us
