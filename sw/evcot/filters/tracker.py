# SPDX-License-Identifier: Apache-2.0
"""A software tracker behind filters."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..contract import DROPPED
from ..events import Events
from ..tracking import Told, Tracker
from .run import Filtered

__all__ = ["FilteredTracker"]


class FilteredTracker:
    """It sees the events that stay; the log numbers them all. See `tracking.Tracker`."""

    def __init__(self, filters: Filtered, tracker: Tracker) -> None:
        self._filters = filters
        self._tracker = tracker
        self._seen = 0
        # Numbers of the events that stayed, from the one that stayed as number `_first` on: no record to come is of one before.
        self._first = 0
        self._kept: list[NDArray[np.int64]] = []

    def feed(self, events: Events) -> Told:
        """See `Tracker.feed`; the owner of an event that was taken out is `DROPPED`."""
        keep = self._filters.keep(events)
        self._kept.append(self._seen + np.flatnonzero(keep))
        self._seen += len(events)
        owner = np.full(len(events), DROPPED, np.int16)
        records, owner[keep] = self._tracker.feed(events.where(keep))
        return self._numbered(records), owner

    def finish(self) -> NDArray[np.void]:
        """See `Tracker.finish`."""
        return self._numbered(self._tracker.finish())

    def _numbered(self, records: NDArray[np.void]) -> NDArray[np.void]:
        """Records with the events' numbers in front of the filters; after the last that stayed comes what follows all."""
        if len(records):
            numbers = np.concatenate([*self._kept, [self._seen]])
            places = records["event_index"] - self._first
            records["event_index"] = numbers[places]
            self._kept = [numbers[places[-1] : -1]]
            self._first += int(places[-1])
        return records
