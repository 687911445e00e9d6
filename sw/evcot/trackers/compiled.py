# SPDX-License-Identifier: Apache-2.0
"""Common base of the trackers with a compiled loop: checks of the input, and records taken from a buffer of fixed length."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import RecordingError
from ..events import Events
from ..tracks.log import TRACK
from ..tracks.tracking import check_order

__all__ = ["SPARE_RECORDS", "UNSET_US", "CompiledTracker"]

SPARE_RECORDS = 4096  # in the buffer of the compiled loop, beside those of two packets
UNSET_US = -(1 << 62)  # a time before all events


class CompiledTracker(ABC):
    """A streaming tracker: feed events in runs of any length; the result does not depend on how they are split into runs.

    Besides the returned arrays, memory is constant. A tracker that derives from it defines how its compiled loop continues
    (`_continue`) and how a packet is closed (`_close`).
    """

    def __init__(self, width: int, height: int, run: NDArray[np.void], records_per_packet: int) -> None:
        """A tracker before its first event.

        Args:
            width, height: of the sensor, px.
            run: (1,) the part of the loop's state with `index`, `last_us`, `packet_end_us` and `records`.
            records_per_packet: most records of one packet.
        """
        self._width, self._height = width, height
        self._run = run
        self._buffer = np.zeros(2 * records_per_packet + SPARE_RECORDS, TRACK)

    @abstractmethod
    def _continue(self, events: Events, begin: int, owner: NDArray[np.int16]) -> int:
        """Track events from `begin` on until all are done or the buffer could overflow; returns the number done."""

    @abstractmethod
    def _close(self, t_us: int) -> None:
        """Close the open packet at `t_us`."""

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
        run: Any = self._run
        check_order(events, int(run["last_us"][0]), int(run["index"][0]))
        outside = (events.x >= self._width) | (events.y >= self._height)
        if outside.any():
            at = int(np.argmax(outside))
            place, size = f"({events.x[at]}, {events.y[at]})", f"{self._width}x{self._height}"
            raise RecordingError(f"event {int(run['index'][0]) + at}: {place}: must lie on the sensor, {size}")
        events = events.read_only()
        owner = np.empty(len(events), np.int16)
        parts: list[NDArray[np.void]] = []
        done = 0
        while done < len(events):
            done = self._continue(events, done, owner)
            parts.append(self._take())
        return np.concatenate(parts) if parts else np.empty(0, TRACK), owner

    def finish(self) -> NDArray[np.void]:
        """Close the last packet at the end of the stream; (m,) records of dtype `TRACK`.

        It ends with the last event: time does not advance beyond it.
        """
        if self._run["packet_end_us"][0] != UNSET_US:
            self._close(int(self._run["last_us"][0]))
        return self._take()

    def _take(self) -> NDArray[np.void]:
        records = int(self._run["records"][0])
        self._run["records"] = 0
        return self._buffer[:records].copy()
