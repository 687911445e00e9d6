# SPDX-License-Identifier: Apache-2.0
"""What every tracker is to the rest: events go in, in runs; what became of its clusters, and who took each event, comes out."""

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

__all__ = ["KeptTracker", "PacketBegin", "Told", "Tracker", "check_order", "log_of", "signed_log_of", "track_recording"]

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

    @property
    def settled(self) -> int:
        """So many of the events that were fed, the first ones, are settled: no record to come has the number of one of them."""
        ...


class PacketBegin:
    """Which event is the first of the open packet, in a tracker that tells packet by packet.

    Args:
        packet_us: how long a packet lasts.
    """

    def __init__(self, packet_us: int) -> None:
        self._packet_us = packet_us
        self._end_us: int | None = None
        self._seen = 0
        self.index = 0

    def fed(self, events: Events, end_us: int) -> None:
        """Note events that were fed, and where the packet that is open after them ends."""
        if len(events) and end_us != self._end_us:
            self._end_us = end_us
            self.index = self._seen + int(np.searchsorted(events.t_us, end_us - self._packet_us))
        self._seen += len(events)


class KeptTracker:
    """A tracker that sees the events that someone in front lets stay; the log numbers them all. See `Tracker`.

    Memory holds the numbers of the events that are not settled: those of a packet, for trackers that tell packet by packet.

    Args:
        keep: which of the next run of events stay, (n,) bool.
        tracker: what sees them; it has seen nothing yet.
    """

    def __init__(self, keep: Keep, tracker: Tracker) -> None:
        self._keep = keep
        self._tracker = tracker
        self._seen = 0
        # Numbers of the events that stayed and are not settled, run by run; the first of them stayed as number `_first`.
        self._first = 0
        self._kept: deque[NDArray[np.int64]] = deque()

    def feed(self, events: Events) -> Told:
        """See `Tracker.feed`; the owner of an event that was taken out is `DROPPED`."""
        keep = self._keep(events)
        if keep.any():
            self._kept.append(self._seen + np.flatnonzero(keep))
        self._seen += len(events)
        owner = np.full(len(events), DROPPED, np.int16)
        records, owner[keep] = self._tracker.feed(events.where(keep))
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
        return int(self._kept[0][0]) if self._kept else self._seen

    def _number(self, records: NDArray[np.void]) -> None:
        """Give records the events' numbers in front; after the last that stayed comes what follows all."""
        if len(records):
            numbers = np.concatenate([*self._kept, [self._seen]])
            records["event_index"] = numbers[records["event_index"] - self._first]

    def _forget(self) -> None:
        """Let go of the numbers of settled events."""
        settled = self._tracker.settled - self._first
        self._first += settled
        while self._kept and len(self._kept[0]) <= settled:
            settled -= len(self._kept.popleft())
        if settled:
            self._kept[0] = self._kept[0][settled:].copy()


def check_order(events: Events, last_us: int | None, index: int) -> None:
    """Raise RecordingError for a run that begins before the last event of the one before; `index`: of its first event."""
    if len(events) and last_us is not None and events.t_us[0] < last_us:
        raise RecordingError(f"event {index}: t = {events.t_us[0]} us follows t = {last_us} us: time must not run back")


def log_of(engine: str, tracker: Tracker, blocks: Iterable[Events]) -> TrackLog:
    """Feed a recording, block by block, to a tracker that has seen nothing yet."""
    told = [tracker.feed(block) for block in blocks]
    records = [np.empty(0, TRACK), *(records for records, _ in told), tracker.finish()]
    return TrackLog(engine, np.concatenate(records), np.concatenate([np.empty(0, np.int16), *(owner for _, owner in told)]))


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
