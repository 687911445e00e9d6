# SPDX-License-Identifier: Apache-2.0
"""The simulated hardware with the interface of a software tracker."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events
from evcot.hardware.config import CotConfig, MotionConfig
from evcot.hardware.golden import to_track_records
from evcot.ticks import TickCounter
from evcot.tracks.log import TRACK
from evcot.tracks.tracking import TrackerOutput

from ..rtl.build import BuiltModel
from .device import Device

__all__ = ["DeviceTracker"]


class DeviceTracker:
    """A compiled module with times in microseconds, tick 0 at the first event. See `evcot.tracks.tracking.Tracker`.

    It returns what `evcot.hardware.golden.GoldenTracker` returns for the same events. Filters of the configuration are in the
    hardware, in front of the tracker.

    Args:
        model: a model that `build_device` returned for the same config, to avoid the look-up.

    Raises:
        ConfigError, ToolchainError: as `Device`.
    """

    def __init__(self, config: CotConfig | MotionConfig, *, model: BuiltModel | None = None) -> None:
        self._device = Device(config, model=model)
        self._clock = TickCounter(config.tick_us)
        self._seen = 0

    def feed(self, events: Events) -> TrackerOutput:
        """See `Tracker.feed`.

        Raises:
            RecordingError: a wait before an event that would take too many clocks; nothing of this run was fed.
        """
        decided = self._device.stream(self._clock.count(events))
        records = to_track_records(decided.records, self._device.config, events.t_us, self._seen, self._clock.t0_us)
        self._seen += len(events)
        return records, decided.owner

    def finish(self) -> NDArray[np.void]:
        """Returns no records: time does not advance after the last event."""
        return np.empty(0, TRACK)

    @property
    def settled(self) -> int:
        """See `Tracker.settled`: all events."""
        return self._seen
