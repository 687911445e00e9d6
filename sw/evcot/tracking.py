# SPDX-License-Identifier: Apache-2.0
"""What every tracker is to the rest: events go in, in runs; what became of its clusters, and who took each event, comes out."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .events import Events
from .tracklog import TRACK, TrackLog

__all__ = ["Told", "Tracker", "log_of"]

Told = tuple[NDArray[np.void], NDArray[np.int16]]
"""(m,) records of dtype `TRACK`, and (n,) owners of the events that were fed."""


class Tracker(Protocol):
    """A tracker as a stream: the result does not depend on where the runs are cut, and memory does not grow."""

    def feed(self, events: Events) -> Told:
        """Track a run of events, in time order and not before those that were fed earlier."""
        ...

    def finish(self) -> NDArray[np.void]:
        """What is still to be told when no more events come."""
        ...


def log_of(engine: str, tracker: Tracker, blocks: Iterable[Events]) -> TrackLog:
    """Feed a recording, block by block, to a tracker that has seen nothing yet."""
    told = [tracker.feed(block) for block in blocks]
    records = [np.empty(0, TRACK), *(records for records, _ in told), tracker.finish()]
    return TrackLog(engine, np.concatenate(records), np.concatenate([np.empty(0, np.int16), *(owner for _, owner in told)]))
