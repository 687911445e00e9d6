# SPDX-License-Identifier: Apache-2.0
"""Tracker for a stream from which parts have been dropped."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events
from evcot.tracks.log import DROPPED
from evcot.tracks.tracking import Tracker, TrackerOutput

__all__ = ["GapTracker"]


class GapTracker:
    """Wraps a tracker so that its records number the events of the whole stream, dropped ones included. See `Tracker`.

    Args:
        tracker: a new tracker, which gets the events that were not dropped.
    """

    def __init__(self, tracker: Tracker) -> None:
        self._tracker = tracker
        self._fed = 0
        # Of every gap that still matters, and the last one before what is not settled: events that the tracker had been
        # fed before it, and how many were missing after it.
        self._gaps = [(0, 0)]

    def skip(self, count: int) -> NDArray[np.int16]:
        """Count dropped events; returns their owners."""
        if count:
            fed, missing = self._gaps[-1]
            if fed == self._fed:
                self._gaps.pop()
            self._gaps.append((self._fed, missing + count))
        return np.full(count, DROPPED, np.int16)

    def feed(self, events: Events) -> TrackerOutput:
        """See `Tracker.feed`."""
        records, owner = self._tracker.feed(events)
        self._fed += len(events)
        self._number(records)
        self._forget()
        return records, owner

    def finish(self) -> NDArray[np.void]:
        """See `Tracker.finish`."""
        records = self._tracker.finish()
        self._number(records)
        return records

    @property
    def settled(self) -> int:
        """See `Tracker.settled`."""
        return self._tracker.settled + self._gaps[0][1]

    def _number(self, records: NDArray[np.void]) -> None:
        """Convert the event numbers of records to those of the stream."""
        if len(records):
            fed, missing = (np.array(column) for column in zip(*self._gaps, strict=True))
            records["event_index"] += missing[np.searchsorted(fed, records["event_index"], "right") - 1]

    def _forget(self) -> None:
        """Discard gaps that no future record can refer to."""
        settled = self._tracker.settled
        while len(self._gaps) > 1 and self._gaps[1][0] <= settled:
            self._gaps.pop(0)
