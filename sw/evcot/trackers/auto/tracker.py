# SPDX-License-Identifier: Apache-2.0
"""The automatic tracker, for streams of events and for recordings. See docs/auto.md for the algorithm."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...errors import RecordingError
from ...events import Events, Recording
from ...tracks.log import TRACK, TrackLog
from ...tracks.tracking import check_order, track_recording
from .config import AutoConfig
from .kernel import feed
from .layout import UNSET_US, make_rules, make_world
from .life import RECORDS_PER_PACKET, close_packet
from .restless import restless

__all__ = ["AutoTracker", "track"]

SPARE_RECORDS = 4096  # in the buffer of the compiled loop, beside those of two packets


class AutoTracker:
    """A streaming tracker: feed events in runs of any length; the result does not depend on how they are split into runs.

    Besides the returned arrays, memory is constant.
    """

    def __init__(self, config: AutoConfig, width: int, height: int) -> None:
        self.config = config
        self._rules = make_rules(config, width, height)
        self._world = make_world(config.max_objects, width, height)
        self._buffer = np.zeros(2 * RECORDS_PER_PACKET * config.max_objects + SPARE_RECORDS, TRACK)

    def feed(self, events: Events) -> tuple[NDArray[np.void], NDArray[np.int16]]:
        """Track a run of events.

        Args:
            events: (n,) events in time order, none before an event fed earlier, all on the sensor.

        Returns:
            (m,) records of dtype `TRACK`, of the packets that these events closed, and (n,) int16 owners: the slot with the
            largest share of each event, -1 if unassigned.

        Raises:
            RecordingError: the run starts before the last event of the previous one, or an event is not on the sensor.
        """
        run = self._world.run
        check_order(events, int(run["last_us"][0]), int(run["index"][0]))
        outside = (events.x >= self._rules.width) | (events.y >= self._rules.height)
        if outside.any():
            at = int(np.argmax(outside))
            place, size = f"({events.x[at]}, {events.y[at]})", f"{self._rules.width}x{self._rules.height}"
            raise RecordingError(f"event {int(run['index'][0]) + at}: {place}: must lie on the sensor, {size}")
        owner = np.empty(len(events), np.int16)
        parts: list[NDArray[np.void]] = []
        done = 0
        while done < len(events):
            done = feed(self._rules, self._world, events.t_us, events.x, events.y, done, owner, self._buffer)
            parts.append(self._take())
        return np.concatenate(parts) if parts else np.empty(0, TRACK), owner

    def finish(self) -> NDArray[np.void]:
        """Close the last packet at the end of the stream; (m,) records of dtype `TRACK`.

        It ends with the last event: time does not advance beyond it.
        """
        run = self._world.run
        if run["packet_end_us"][0] != UNSET_US:
            last_us = int(run["last_us"][0])
            lasted_us = last_us - int(run["packet_end_us"][0] - run["packet_us"][0])
            close_packet(self._rules, self._world, last_us, lasted_us, self._buffer)
        return self._take()

    @property
    def noise_hz(self) -> float | None:
        """Events per pixel and second of the background, as estimated so far; None until there were enough."""
        noise_hz = float(self._world.run["noise"][0])
        return noise_hz if noise_hz >= 0.0 else None

    def restless(self) -> NDArray[np.bool_]:
        """The pixels that are ignored because they never rest, (height, width)."""
        run = self._world.run
        return restless(self._world.seen, int(run["last_us"][0]), int(run["first_us"][0]))

    @property
    def settled(self) -> int:
        """See `tracking.Tracker`: the events before the open packet."""
        return int(self._world.run["settled"][0])

    def _take(self) -> NDArray[np.void]:
        records = int(self._world.run["records"][0])
        self._world.run["records"] = 0
        return self._buffer[:records].copy()


def track(recording: Recording, config: AutoConfig, keep: NDArray[np.bool_] | None = None) -> TrackLog:
    """Run the automatic tracker over a recording, or over a selection of its events.

    Args:
        keep: (n,) bool, mask of the events that the tracker sees; None for all. Event indices in the log are the recording's.

    In the log `radius` is the mean of the box's half sides on the sensor, `support` the events that the object accumulated,
    and `n_ev` those in the packet.
    """
    return track_recording("auto", AutoTracker(config, recording.width, recording.height), recording, keep)
