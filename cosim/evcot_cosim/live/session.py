# SPDX-License-Identifier: Apache-2.0
"""A live run: one thread receives, one tracks, and each subscriber takes the steps since its last call."""

from __future__ import annotations

import threading
import time
from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events
from evcot.tracks.log import Kind
from evcot.tracks.tracking import Tracker

from .alive import Alive, Clusters
from .gaps import GapTracker
from .latency import Latency
from .recorder import LogKeeper, Recorder
from .sources import LiveSource
from .waiting import Arrival, Waiting

__all__ = ["WAIT_S", "Session", "Step"]

WAIT_S = 0.25  # events that have waited longer for the tracker are given up
_WAITING_EVENTS = 1 << 23  # 100 MB: enough for `WAIT_S` of any camera
_INBOX_S = 1.0  # of what waits to be drawn, this much
_INBOX_EVENTS = 1 << 21
_RATE_S = 1.0  # over which rates are taken


@dataclass(frozen=True)
class Step:
    """Events that were tracked together, their owners, and the arrival time of the first of them."""

    events: Events
    owner: NDArray[np.int16]
    arrived_s: float


class Session:
    """A source, a tracker and its subscribers.

    Args:
        tracker: a new tracker.
        recorder, log: optional files for all received events, and for the tracker's records and owners.

    Attributes:
        tracked, drawn: durations from the arrival of a packet's first event until it was tracked, and until it was drawn.
    """

    def __init__(
        self, source: LiveSource, tracker: Tracker, recorder: Recorder | None = None, log: LogKeeper | None = None,
        wait_s: float = WAIT_S,
    ) -> None:  # fmt: skip
        self.source = source
        self.tracked, self.drawn = Latency(), Latency()
        self._tracker = GapTracker(tracker)
        self._recorder, self._log = recorder, log
        self._waiting: Waiting[Arrival] = Waiting(wait_s, _WAITING_EVENTS)
        self._inboxes: list[Waiting[Step]] = []
        self._alive = Alive()
        self._stopped = threading.Event()
        self._received = self._fed = 0
        self._first_us: int | None = None
        self._last_us = 0
        self._marks: deque[tuple[float, int, int]] = deque([(time.perf_counter(), 0, 0)])
        self._marking = threading.Lock()
        self._begin_s = time.perf_counter()
        self._error: BaseException | None = None
        self._threads = [threading.Thread(target=self._guarded, args=(work,)) for work in (self._receive, self._track)]

    def start(self) -> None:
        """Start receiving."""
        self._begin_s = time.perf_counter()
        for thread in self._threads:
            thread.start()

    @property
    def running(self) -> bool:
        """Whether events may still arrive or are waiting."""
        return any(thread.is_alive() for thread in self._threads)

    def end(self) -> None:
        """Stop receiving; waiting events are still tracked. Thread-safe."""
        self._stopped.set()

    def stop(self) -> None:
        """End the run and complete its files.

        Raises:
            RecordingError, OutputError: the error that ended the run early, or prevents the files from being written.
        """
        self._stopped.set()
        for thread in self._threads:
            if thread.ident is not None:
                thread.join()
        self.source.close()
        for kept in (self._recorder, self._log):
            if kept is not None:
                kept.close()
        if self._error is not None:
            raise self._error

    def subscribe(self) -> Waiting[Step]:
        """A queue of all steps from now on; if the subscriber does not keep up, the oldest are dropped."""
        inbox: Waiting[Step] = Waiting(_INBOX_S, _INBOX_EVENTS)
        self._inboxes = [*self._inboxes, inbox]
        return inbox

    def unsubscribe(self, inbox: Waiting[Step]) -> None:
        """End a subscription."""
        self._inboxes = [each for each in self._inboxes if each is not inbox]

    @property
    def clusters(self) -> Clusters:
        """The clusters that are visible now."""
        return self._alive.clusters

    @property
    def first_us(self) -> int:
        """Time of the first event."""
        return self._first_us or 0

    def _guarded(self, work: Any) -> None:
        try:
            work()
        except BaseException as error:
            self._error = self._error or error
            self._stopped.set()
        finally:
            self._waiting.close()

    def _receive(self) -> None:
        for arrival in self.source.arrivals(self._is_wanted):
            if self._recorder is not None:
                self._recorder.write(arrival.events)
            if self._first_us is None:
                self._first_us = int(arrival.events.t_us[0])
            self._received += len(arrival.events)
            self._waiting.put(arrival)

    def _is_wanted(self) -> bool:
        """Whether to continue; the source calls this many times a second, with or without events."""
        if self._recorder is not None:
            self._recorder.flush_if_due()
        return not self._stopped.is_set()

    def _track(self) -> None:
        while (taken := self._waiting.take(0.1, most=1)) is not None:
            self._keep(np.empty(0, self._alive.clusters.states.dtype), self._tracker.skip(taken.lost))
            for arrival in taken.items:
                self._step(arrival)
        records = self._tracker.finish()
        self._alive.apply(records)
        self._keep(records, np.empty(0, np.int16))
        for inbox in self._inboxes:
            inbox.close()

    def _step(self, arrival: Arrival) -> None:
        records, owner = self._tracker.feed(arrival.events)
        self._alive.apply(records)
        self._fed += len(owner)
        self._last_us = int(arrival.events.t_us[-1])
        self.tracked.add(np.array([time.perf_counter() - arrival.arrived_s]))
        self._keep(records, owner)
        for inbox in self._inboxes:
            inbox.put(Step(arrival.events, owner, arrival.arrived_s))

    def _keep(self, records: NDArray[np.void], owner: NDArray[np.int16]) -> None:
        if self._log is not None:
            self._log.add(records, owner)

    def figures(self) -> dict[str, Any]:
        """All figures as plain values; undefined ones are None. Rates cover the last second: call at least that often."""
        now_s = time.perf_counter()
        count, clusters = self._alive.count, len(self._alive.clusters.states)
        received_hz, tracked_hz = self._rates(now_s)
        return {
            "running_s": round(now_s - self._begin_s, 3),
            "recording_s": (self._last_us - self.first_us) / 1e6 if self._fed else 0.0,
            "events": self._received,
            "events_per_s": received_hz,
            "tracked_per_s": tracked_hz,
            "dropped": self._waiting.lost,
            "left_out": sum(self.source.left_out.values()),
            "slipped_s": round(getattr(self.source, "slipped_s", 0.0), 3),
            "saved": self._recorder.events if self._recorder is not None else None,
            "clusters": clusters,
            "tracks": count[Kind.BORN],
            "merged": count[Kind.MERGED],
            "lost": count[Kind.LOST],
            "tracked_ms": _quantiles(self.tracked.recent_ms),
            "drawn_ms": _quantiles(self.drawn.recent_ms),
        }

    def _rates(self, now_s: float) -> tuple[float, float]:
        """(received, tracked) events per second."""
        with self._marking:
            marks = self._marks
            marks.append((now_s, self._received, self._fed))
            while len(marks) > 2 and now_s - marks[1][0] >= _RATE_S:
                marks.popleft()
            (begin_s, *begin), (end_s, *end) = marks[0], marks[-1]
        since_s = max(end_s - begin_s, 1e-9)
        received_hz, tracked_hz = (round((b - a) / since_s, 1) for a, b in zip(begin, end, strict=True))
        return received_hz, tracked_hz

    def summary(self) -> dict[str, Any]:
        """The figures of the whole run."""
        overall_s = max(time.perf_counter() - self._begin_s, 1e-9)
        return self.figures() | {
            "events_per_s": round(self._received / overall_s, 1),
            "tracked_per_s": round(self._fed / overall_s, 1),
            "tracked_ms": _quantiles(self.tracked.overall_ms),
            "drawn_ms": _quantiles(self.drawn.overall_ms),
        }


def _quantiles(of: Any) -> dict[str, float | None]:
    return {f"p{share}": None if (ms := of(share / 100)) is None else round(ms, 3) for share in (50, 99)}
