# SPDX-License-Identifier: Apache-2.0
"""The interface of a tracker: events are fed in runs; records of its clusters and the owner of each event are returned."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..digest import EventsDigest
from ..errors import RecordingError
from ..events import Events, Recording
from .log import DROPPED, TRACK, TrackLog
from .record import ClassNames, no_verdicts

__all__ = [
    "FilteredTracker",
    "PacketBegin",
    "Tracker",
    "TrackerOutput",
    "check_order",
    "class_names_of",
    "log_of",
    "signed_log_of",
    "take_verdicts",
    "track_recording",
]

_RUN_EVENTS = 1 << 18

_Whole = TypeVar("_Whole", Events, NDArray[np.bool_])

TrackerOutput = tuple[NDArray[np.void], NDArray[np.int16]]
"""(m,) records of dtype `TRACK`, and (n,) owners of the events fed."""

EventSelector = Callable[[Events], NDArray[np.bool_]]


class Tracker(Protocol):
    """A streaming tracker: the result does not depend on how events are split into runs, and memory does not grow."""

    def feed(self, events: Events) -> TrackerOutput:
        """Track a run of events, in time order and not before those fed earlier."""
        ...

    def finish(self) -> NDArray[np.void]:
        """End the stream; returns the remaining records, (m,) of dtype `TRACK`."""
        ...

    @property
    def settled(self) -> int:
        """Number of leading events that are settled: no future record refers to one of them by its index."""
        ...


class PacketBegin:
    """Keeps the index of the first event of the open packet, for a tracker that reports packet by packet.

    Args:
        packet_us: length of a packet.
    """

    def __init__(self, packet_us: int) -> None:
        self._packet_us = packet_us
        self._end_us: int | None = None
        self._seen = 0
        self.index = 0

    def fed(self, events: Events, end_us: int) -> None:
        """Update with a run of events; `end_us` is the end of the packet that is open after them."""
        if len(events) and end_us != self._end_us:
            self._end_us = end_us
            self.index = self._seen + int(np.searchsorted(events.t_us, end_us - self._packet_us))
        self._seen += len(events)


class FilteredTracker:
    """A tracker behind an event filter: it sees only the events that pass; the log numbers all events. See `Tracker`.

    Memory holds the indices of the events that are not settled: those of a packet, for trackers that report packet by packet.

    Args:
        keep: returns the mask of the events of the next run that pass, (n,) bool.
        tracker: a tracker before its first event.
    """

    def __init__(self, keep: EventSelector, tracker: Tracker) -> None:
        self._keep = keep
        self.tracker = tracker
        self._seen = 0
        # Indices of the passed events that are not settled, run by run; the tracker's own index of the first is `_first`.
        self._first = 0
        self._kept: deque[NDArray[np.int64]] = deque()

    def feed(self, events: Events) -> TrackerOutput:
        """See `Tracker.feed`; the owner of an event that was filtered out is `DROPPED`."""
        keep = self._keep(events)
        if keep.any():
            self._kept.append(self._seen + np.flatnonzero(keep))
        self._seen += len(events)
        owner = np.full(len(events), DROPPED, np.int16)
        records, owner[keep] = self.tracker.feed(events.where(keep))
        self._number(records)
        self._forget()
        return records, owner

    def finish(self) -> NDArray[np.void]:
        """See `Tracker.finish`."""
        records = self.tracker.finish()
        self._number(records)
        return records

    @property
    def settled(self) -> int:
        """See `Tracker.settled`."""
        return int(self._kept[0][0]) if self._kept else self._seen

    def _number(self, records: NDArray[np.void]) -> None:
        """Map the records' event indices to those before the filter; past the last event that passed, to the end."""
        if len(records):
            numbers = np.concatenate([*self._kept, [self._seen]])
            records["event_index"] = numbers[records["event_index"] - self._first]

    def _forget(self) -> None:
        """Discard the indices of settled events."""
        settled = self.tracker.settled - self._first
        self._first += settled
        while self._kept and len(self._kept[0]) <= settled:
            settled -= len(self._kept.popleft())
        if settled:
            self._kept[0] = self._kept[0][settled:].copy()


def check_order(events: Events, last_us: int | None, index: int) -> None:
    """Raise RecordingError if a run begins before the last event of the previous one; `index`: that of its first event."""
    if len(events) and last_us is not None and events.t_us[0] < last_us:
        raise RecordingError(f"event {index}: t = {events.t_us[0]} us follows t = {last_us} us: time must not run back")


def log_of(engine: str, tracker: Tracker, blocks: Iterable[Events]) -> TrackLog:
    """Feed a recording, block by block, to a tracker before its first event; returns the log."""
    outputs = [tracker.feed(block) for block in blocks]
    records = [np.empty(0, TRACK), *(records for records, _ in outputs), tracker.finish()]
    owner = np.concatenate([np.empty(0, np.int16), *(owner for _, owner in outputs)])
    return TrackLog(
        engine, np.concatenate(records), owner, verdicts=take_verdicts(tracker), class_names=class_names_of(tracker)
    )


def take_verdicts(tracker: Tracker) -> NDArray[np.void]:
    """The verdicts since the last call of a tracker with a classifier, (k,) of dtype `record.VERDICT`; none of another one."""
    take: Callable[[], NDArray[np.void]] = getattr(tracker, "take_verdicts", no_verdicts)
    return take()


def class_names_of(tracker: Tracker) -> ClassNames:
    """The names of the classes of a tracker with a classifier; none of another one."""
    names: ClassNames = getattr(tracker, "class_names", {})
    return names


def signed_log_of(engine: str, tracker: Tracker, blocks: Iterable[Events]) -> TrackLog:
    """As `log_of`, with the fingerprint of the events in the log, which takes about 13 ns per event."""
    made_of = EventsDigest()

    def noted() -> Iterator[Events]:
        for block in blocks:
            made_of.add(block)
            yield block

    log = log_of(engine, tracker, noted())
    return replace(log, recording=made_of.hex())


def track_recording(engine: str, tracker: Tracker, recording: Recording, keep: NDArray[np.bool_] | None = None) -> TrackLog:
    """Feed a recording, or a selection of its events, to a tracker before its first event; returns the log.

    Args:
        keep: (n,) bool, mask of the events that the tracker sees; None for all. Event indices in the log are the recording's.
    """
    if keep is not None:
        runs = _runs(keep)
        tracker = FilteredTracker(lambda _: next(runs), tracker)
    return log_of(engine, tracker, _runs(recording.events))


def _runs(whole: _Whole) -> Iterator[_Whole]:
    return (whole[begin : begin + _RUN_EVENTS] for begin in range(0, len(whole), _RUN_EVENTS))
