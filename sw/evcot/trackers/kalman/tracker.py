# SPDX-License-Identifier: Apache-2.0
"""The Kalman tracker, for streams of events and for recordings. See docs/kalman.md for the algorithm."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...events import Events, Recording
from ...tracks.log import TrackLog
from ...tracks.tracking import PacketBegin, track_recording
from ..compiled import CompiledTracker
from .config import KalmanConfig
from .kernel import feed
from .layout import make_rules, make_world
from .life import RECORDS_PER_PACKET, close_packet

__all__ = ["KalmanTracker", "track"]


class KalmanTracker(CompiledTracker):
    """The Kalman tracker as a stream; see `CompiledTracker`."""

    def __init__(self, config: KalmanConfig, width: int, height: int) -> None:
        self.config = config
        self._rules = make_rules(config, width, height)
        self._world = make_world(config.max_objects, width, height)
        self._packet = PacketBegin(config.packet_us)
        super().__init__(width, height, self._world.run, RECORDS_PER_PACKET * config.max_objects)

    def feed(self, events: Events) -> tuple[NDArray[np.void], NDArray[np.int16]]:
        output = super().feed(events)
        self._packet.fed(events, int(self._run["packet_end_us"][0]))
        return output

    @property
    def settled(self) -> int:
        """See `tracking.Tracker`: the events before the open packet."""
        return self._packet.index

    def _continue(self, events: Events, begin: int, owner: NDArray[np.int16]) -> int:
        return feed(self._rules, self._world, events.t_us, events.x, events.y, begin, owner, self._buffer)

    def _close(self, t_us: int) -> None:
        lasted_us = t_us - int(self._run["packet_end_us"][0]) + self._rules.packet_us
        close_packet(self._rules, self._world, t_us, lasted_us, self._buffer)


def track(recording: Recording, config: KalmanConfig, keep: NDArray[np.bool_] | None = None) -> TrackLog:
    """Run the Kalman tracker over a recording, or over a selection of its events.

    Args:
        keep: (n,) bool, mask of the events that the tracker sees; None for all. Event indices in the log are the recording's.

    In the log `radius` is the mean of the box's half sides on the sensor, `support` the events that the object accumulated,
    and `n_ev` those in the packet.
    """
    return track_recording("kalman", KalmanTracker(config, recording.width, recording.height), recording, keep)
