# SPDX-License-Identifier: Apache-2.0
"""Events and recordings: struct of arrays, validated once, immutable by convention."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .errors import RecordingError

__all__ = ["Events", "Recording"]


@dataclass(frozen=True, eq=False)
class Events:
    """Events in time order, one array per field.

    Attributes:
        t_us: (n,) int64, microseconds, never decreasing.
        x: (n,) uint16, pixels from the left.
        y: (n,) uint16, pixels from the top.
        p: (n,) uint8, 1 where the pixel became brighter, 0 where darker.
    """

    t_us: NDArray[np.int64]
    x: NDArray[np.uint16]
    y: NDArray[np.uint16]
    p: NDArray[np.uint8]

    def __len__(self) -> int:
        return len(self.t_us)

    def __getitem__(self, window: slice) -> Events:
        return Events(self.t_us[window], self.x[window], self.y[window], self.p[window])

    @classmethod
    def empty(cls) -> Events:
        """No events."""
        return cls(np.empty(0, np.int64), np.empty(0, np.uint16), np.empty(0, np.uint16), np.empty(0, np.uint8))


@dataclass(frozen=True, eq=False)
class Recording:
    """Events and the sensor that they come from.

    Attributes:
        events: the events, in time order.
        width, height: sensor size in pixels.
        name: where it comes from, for messages and output folders.

    Raises:
        RecordingError: arrays of different length, time running backwards, or an event outside the sensor; the message
            names the event's index, the value and the rule.
    """

    events: Events
    width: int
    height: int
    name: str = "recording"

    def __post_init__(self) -> None:
        events = self.events
        if not 1 <= self.width <= 65536 or not 1 <= self.height <= 65536:
            raise RecordingError(f"{self.name}: sensor {self.width}x{self.height}: each side must be from 1 to 65536 pixels")
        if not len(events.t_us) == len(events.x) == len(events.y) == len(events.p):
            raise RecordingError(
                f"{self.name}: t, x, y, p hold {len(events.t_us)}, {len(events.x)}, {len(events.y)}, {len(events.p)} values: "
                "all must be the same"
            )
        backwards = np.flatnonzero(np.diff(events.t_us) < 0)
        if len(backwards):
            i = int(backwards[0]) + 1
            raise RecordingError(
                f"{self.name}: event {i}: t = {events.t_us[i]} us follows t = {events.t_us[i - 1]} us: time must not run back"
            )
        for axis, values, size in (("x", events.x, self.width), ("y", events.y, self.height)):
            outside = np.flatnonzero(values >= size)
            if len(outside):
                i = int(outside[0])
                raise RecordingError(f"{self.name}: event {i}: {axis} = {values[i]}: must be below the sensor's {size}")
        wrong = np.flatnonzero(events.p > 1)
        if len(wrong):
            i = int(wrong[0])
            raise RecordingError(f"{self.name}: event {i}: p = {events.p[i]}: must be 0 or 1")

    @property
    def duration_us(self) -> int:
        """Time from the first to the last event."""
        t_us = self.events.t_us
        return int(t_us[-1] - t_us[0]) if len(t_us) else 0
