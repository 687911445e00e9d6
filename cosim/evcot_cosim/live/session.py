# SPDX-License-Identifier: Apache-2.0
"""A live run: one thread receives, one tracks for each tracker, and each subscriber takes the steps since its last call."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events
from evcot.tracks.tracking import Tracker

from .queues import Arrival, Latency, Waiting
from .recorder import LogKeeper, Recorder
from .sources import LiveSource
from .tracker_thread import Beside, Lane, quantiles
from .visible_clusters import Clusters

__all__ = ["Session", "Step"]

WAIT_S = 0.25  # events that have waited longer for the tracker are given up
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
    """A source, a tracker, others beside it, and subscribers.

    Args:
        tracker: a new tracker.
        recorder, log: optional files for all received events, and for the tracker's log.
        beside: more trackers of the same events; only what they have visible and their figures are known.

    Attributes:
        drawn: durations from the arrival of a packet's first event until it was drawn.
    """

    def __init__(
        self, source: LiveSource, tracker: Tracker, recorder: Recorder | None = None, log: LogKeeper | None = None,
        wait_s: float = WAIT_S, beside: Sequence[Beside] = (),
    ) -> None:  # fmt: skip
        self.source = source
        self.drawn = Latency()
        self._recorder, self._log = recorder, log
        self._inboxes: list[Waiting[Step]] = []
        self._main = Lane(Beside("", "", tracker), wait_s, self._keep, self._hand_out)
        self._lanes = [self._main, *(Lane(each, wait_s) for each in beside)]
        self._stopped = threading.Event()
        self._received = 0
        self._first_us: int | None = None
        self._marks: deque[tuple[float, int, int]] = deque([(time.perf_counter(), 0, 0)])
        self._marking = threading.Lock()
        self._begin_s = time.perf_counter()
        self._error: BaseException | None = None
        work = [self._receive, self._track, *(lane.work for lane in self._lanes[1:])]
        self._threads = [threading.Thread(target=self._guarded, args=(each,)) for each in work]

    def start(self) -> None:
        """Start receiving."""
        self._begin_s = time.perf_counter()
        for thread in self._threads:
            thread.start()

    @property
    def running(self) -> bool:
        """Whether events may still arrive or are waiting."""
        return any(thread.is_alive() for thread in self._threads)

    @property
    def failed(self) -> bool:
        """Whether an error has ended the run."""
        return self._error is not None

    def end(self) -> None:
        """Stop receiving; waiting events are still tracked. Thread-safe."""
        self._stopped.set()

    def finish(self) -> None:
        """End the run and complete its files; the source stays open, for another session.

        Raises:
            RecordingError, OutputError: the error that ended the run early, or prevents the files from being written.
        """
        self._stopped.set()
        for thread in self._threads:
            if thread.ident is not None:
                thread.join()
        for kept in (self._recorder, self._log):
            if kept is not None:
                kept.close()
        if self._error is not None:
            raise self._error

    def stop(self) -> None:
        """As `finish`; closes the source."""
        try:
            self.finish()
        finally:
            self.source.close()

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
        return self._main.clusters

    @property
    def labels(self) -> tuple[str, ...]:
        """How classes are shown; `Clusters.label` is a place in it."""
        return self._main.labels

    @property
    def beside(self) -> list[Clusters]:
        """The clusters that the trackers beside it have visible."""
        return [lane.clusters for lane in self._lanes[1:]]

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
            for lane in self._lanes:
                lane.waiting.close()

    def _receive(self) -> None:
        for arrival in self.source.arrivals(self._is_wanted):
            if self._recorder is not None:
                self._recorder.write(arrival.events)
            if self._first_us is None:
                self._first_us = int(arrival.events.t_us[0])
            self._received += len(arrival.events)
            for lane in self._lanes:
                lane.waiting.put(arrival)

    def _is_wanted(self) -> bool:
        """Whether to continue; the source calls this many times a second, with or without events."""
        if self._recorder is not None:
            self._recorder.flush_if_due()
        return not self._stopped.is_set()

    def _track(self) -> None:
        self._main.work()
        for inbox in self._inboxes:
            inbox.close()

    def _hand_out(self, arrival: Arrival, owner: NDArray[np.int16]) -> None:
        for inbox in self._inboxes:
            inbox.put(Step(arrival.events, owner, arrival.arrived_s))

    def _keep(self, records: NDArray[np.void], owner: NDArray[np.int16], verdicts: NDArray[np.void]) -> None:
        if self._log is not None:
            self._log.add(records, owner, verdicts)

    def figures(self) -> dict[str, Any]:
        """All figures as plain values; undefined ones are None. Rates cover the last second: call at least that often."""
        now_s = time.perf_counter()
        received_hz, tracked_hz = self._rates(now_s)
        return {
            "running_s": round(now_s - self._begin_s, 3),
            "recording_s": (self._main.last_us - self.first_us) / 1e6 if self._main.fed else 0.0,
            "events": self._received,
            "events_per_s": received_hz,
            "tracked_per_s": tracked_hz,
            "left_out": sum(self.source.left_out.values()),
            "slipped_s": round(getattr(self.source, "slipped_s", 0.0), 3),
            "saved": self._recorder.events if self._recorder is not None else None,
            **self._main.figures(),
            "drawn_ms": quantiles(self.drawn.recent_ms),
            "beside": [{"name": lane.name, "about": lane.about, **lane.figures()} for lane in self._lanes[1:]],
        }

    def _rates(self, now_s: float) -> tuple[float, float]:
        """(received, tracked) events per second."""
        with self._marking:
            marks = self._marks
            marks.append((now_s, self._received, self._main.fed))
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
            "tracked_per_s": round(self._main.fed / overall_s, 1),
            "tracked_ms": quantiles(self._main.tracked.overall_ms),
            "drawn_ms": quantiles(self.drawn.overall_ms),
        }
