# SPDX-License-Identifier: Apache-2.0
"""A tracker of a stream of which it does not see every part."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events
from evcot.tracks.log import DROPPED
from evcot.tracks.tracking import Told, Tracker

__all__ = ["GapTracker"]


class GapTracker:
    """A tracker whose records number the events of the whole stream, those too that it was too late to see. See `Tracker`.

    Args:
        tracker: what sees the rest; it has seen nothing yet.
    """

    def __init__(self, tracker: Tracker) -> None:
        self._tracker = tracker
        self._fed = 0
        # Of every gap that still matters: events that the tracker had been fed before it, and how many were missing after it.
        self._gaps = [(0, 0)]

    def skip(self, count: int) -> NDArray[np.int16]:
        """So many events are not seen; their owners."""
        if count:
            self._gaps.append((self._fed, self._gaps[-1][1] + count))
        return np.full(count, DROPPED, np.int16)

    def feed(self, events: Events) -> Told:
        """See `Tracker.feed`."""
        records, owner = self._tracker.feed(events)
        self._fed += len(events)
        return self._numbered(records), owner

    def finish(self) -> NDArray[np.void]:
        """See `Tracker.finish`."""
        return self._numbered(self._tracker.finish())

    def _numbered(self, records: NDArray[np.void]) -> NDArray[np.void]:
        """Records with the stream's numbers. Places never decrease, so that gaps before the last one can be forgotten."""
        if len(records) and len(self._gaps) > 1:
            fed, missing = (np.array(column) for column in zip(*self._gaps, strict=True))
            gap = np.searchsorted(fed, records["event_index"], "right") - 1
            records["event_index"] += missing[gap]
            self._gaps = self._gaps[gap[-1] :]
        elif len(records):
            records["event_index"] += self._gaps[0][1]
        return records
