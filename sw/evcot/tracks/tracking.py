# SPDX-License-Identifier: Apache-2.0
"""What every tracker is to the rest: events go in, in runs; what became of its clusters, and who took each event, comes out."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..errors import RecordingError
from ..events import Events, Recording
from .log import DROPPED, TRACK, TrackLog

__all__ = ["KeptTracker", "Told", "Tracker", "check_order", "log_of", "track_recording"]

_RUN_EVENTS = 1 << 18

_Whole = TypeVar("_Whole", Events, NDArray[np.bool_])

Told = tuple[NDArray[np.void], NDArray[np.int16]]
"""(m,) records of dtype `TRACK`, and (n,) owners of the events that were fed."""

Keep = Callable[[Events], NDArray[np.bool_]]


class Tracker(Protocol):
    """A tracker as a stream: the result does not depend on where the runs are cut, and memory does not grow."""

    def feed(self, events: Events) -> Told:
        """Track a run of events, in time order and not before those that were fed earlier."""
        ...

    def finish(self) -> NDArray[np.void]:
        """What is still to be told when no more events come."""
        ...


class KeptTracker:
    """A tracker that sees the events that someone in front lets stay; the log numbers them all. See `Tracker`.

    Args:
        keep: which of the next run of events stay, (n,) bool.
        tracker: what sees them; it has seen nothing yet.
    """

    def __init__(self, keep: Keep, tracker: Tracker) -> None:
        self._keep = keep
        self._tracker = tracker
        self._seen = 0
        # Numbers of the events that stayed, from the one that stayed as number `_first` on: no record to come is of one before.
        self._first = 0
        self._kept: list[NDArray[np.int64]] = []

    def feed(self, events: Events) -> Told:
        """See `Tracker.feed`; the owner of an event that was taken out is `DROPPED`."""
        keep = self._keep(events)
        self._kept.append(self._seen + np.flatnonzero(keep))
        self._seen += len(events)
        owner = np.full(len(events), DROPPED, np.int16)
        records, owner[keep] = self._tracker.feed(events.where(keep))
        return self._numbered(records), owner

    def finish(self) -> NDArray[np.void]:
        """See `Tracker.finish`."""
        return self._numbered(self._tracker.finish())

    def _numbered(self, records: NDArray[np.void]) -> NDArray[np.void]:
        """Records with the events' numbers in front; after the last that stayed comes what follows all."""
        if len(records):
            numbers = np.concatenate([*self._kept, [self._seen]])
            places = records["event_index"] - self._first
            records["event_index"] = numbers[places]
            self._kept = [numbers[places[-1] : -1]]
            self._first += int(places[-1])
        return records


def check_order(events: Events, last_us: int | None, index: int) -> None:
    """Raise RecordingError for a run that begins before the last event of the one before; `index`: of its first event."""
    if len(events) and last_us is not None and events.t_us[0] < last_us:
        raise RecordingError(f"event {index}: t = {events.t_us[0]} us follows t = {last_us} us: time must not run back")


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
    if keep is not None:
        runs = _runs(keep)
        tracker = KeptTracker(lambda _: next(runs), tracker)
    return log_of(engine, tracker, _runs(recording.events))


def _runs(whole: _Whole) -> Iterator[_Whole]:
    return (whole[begin : begin + _RUN_EVENTS] for begin in range(0, len(whole), _RUN_EVENTS))
