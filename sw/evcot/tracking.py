# SPDX-License-Identifier: Apache-2.0
"""What every tracker is to the rest: events go in, in runs; what became of its clusters, and who took each event, comes out."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .contract import DROPPED
from .events import Events, Recording
from .tracklog import TRACK, TrackLog

__all__ = ["Told", "Tracker", "log_of", "track_recording"]

_RUN_EVENTS = 1 << 18

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


def track_recording(engine: str, tracker: Tracker, recording: Recording, keep: NDArray[np.bool_] | None = None) -> TrackLog:
    """Feed a recording, or the events in it that someone let stay, to a tracker that has seen nothing yet.

    Args:
        keep: (n,) bool, which events the tracker sees; None: all. The log numbers events as the recording does.
    """
    if keep is None:
        return log_of(engine, tracker, _runs(recording.events))
    log = log_of(engine, tracker, _runs(recording.events.where(keep)))
    owner = np.full(len(keep), DROPPED, np.int16)
    owner[keep] = log.owner
    # After the last event that stayed comes what follows the recording.
    numbers = np.append(np.flatnonzero(keep), len(keep))
    log.records["event_index"] = numbers[log.records["event_index"]]
    return TrackLog(engine, log.records, owner)


def _runs(events: Events) -> Iterator[Events]:
    return (events[begin : begin + _RUN_EVENTS] for begin in range(0, len(events), _RUN_EVENTS))
