# SPDX-License-Identifier: Apache-2.0
"""One tracker of a live run, with a queue and a thread of its own: a slow tracker does not hold up another."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.errors import RecordingError
from evcot.tracks.log import Kind
from evcot.tracks.tracking import Tracker

from .bounded_queue import Arrival, Waiting
from .gaps import GapTracker
from .latency import Latency
from .visible_clusters import Alive, Clusters

__all__ = ["Beside", "Lane", "quantiles"]

_LOSSES_MAX = 3  # until a substitute takes over
_LOSS_S = 1.0  # between two that count
_WAITING_EVENTS = 1 << 23  # 100 MB: enough for a quarter of a second of any camera

Keep = Callable[[NDArray[np.void], NDArray[np.int16]], None]
Done = Callable[[Arrival, NDArray[np.int16]], None]


class Beside:
    """A tracker that runs beside the session's own.

    Args:
        name: the word for it on the page: "hardware".
        about: what it is: "RTL in simulation".
        substitute: (what it is, new tracker) that takes over from there, if this one loses events again and again,
            or refuses them.
    """

    def __init__(
        self, name: str, about: str, tracker: Tracker, substitute: tuple[str, Callable[[], Tracker]] | None = None
    ) -> None:
        self.name, self.about, self.tracker, self.substitute = name, about, tracker, substitute


class Lane:
    """Feeds a tracker from its queue.

    Args:
        wait_s: events that have waited longer for the tracker are dropped if there are newer ones.
        keep: called with all records and owners, those of dropped events included.
        done: called with every packet that was tracked, and its owners.

    Attributes:
        about: what runs in it, which a substitute changes.
        waiting: the queue.
        tracked: durations from the arrival of a packet's first event until it was tracked.
        fed, last_us: number of events tracked, and time of the last of them.
    """

    def __init__(
        self, run: Beside, wait_s: float, keep: Keep = lambda _records, _owner: None, done: Done = lambda _arrival, _owner: None
    ) -> None:
        self.name, self.about = run.name, run.about
        self.waiting: Waiting[Arrival] = Waiting(wait_s, _WAITING_EVENTS)
        self.tracked = Latency()
        self.fed = 0
        self.last_us = 0
        self._alive = Alive()
        self._tracker = GapTracker(run.tracker)
        self._substitute = run.substitute
        self._losses, self._loss_s = 0, -math.inf
        self._keep, self._done = keep, done

    @property
    def clusters(self) -> Clusters:
        """The clusters that are visible now."""
        return self._alive.clusters

    def work(self) -> None:
        """Track what comes until the queue is closed."""
        while (taken := self.waiting.take(0.1, most=1)) is not None:
            if taken.lost and self._substitute is not None and self._is_late_again():
                self._take_over("did not keep up")
            self._keep(np.empty(0, self._alive.clusters.states.dtype), self._tracker.skip(taken.lost))
            for arrival in taken.items:
                self._step(arrival)
        records = self._tracker.finish()
        self._alive.apply(records)
        self._keep(records, np.empty(0, np.int16))

    def _step(self, arrival: Arrival) -> None:
        try:
            records, owner = self._tracker.feed(arrival.events)
        except RecordingError as error:
            if self._substitute is None:
                raise
            self._take_over(str(error))
            records, owner = self._tracker.feed(arrival.events)
        self._alive.apply(records)
        self.fed += len(owner)
        self.last_us = int(arrival.events.t_us[-1])
        self.tracked.add(np.array([time.perf_counter() - arrival.arrived_s]))
        self._keep(records, owner)
        self._done(arrival, owner)

    def _is_late_again(self) -> bool:
        """Count a loss, at most one a second; returns whether there were too many: one may be another process's doing."""
        now_s = time.perf_counter()
        if now_s - self._loss_s >= _LOSS_S:
            self._loss_s, self._losses = now_s, self._losses + 1
        return self._losses >= _LOSSES_MAX

    def _take_over(self, why: str) -> None:
        assert self._substitute is not None
        about, start = self._substitute
        self.about = f"{about}; {self.about} {why}"
        self._substitute = None
        self._alive = Alive()
        self._tracker = GapTracker(start())

    def figures(self) -> dict[str, Any]:
        """Its figures as plain values; undefined ones are None."""
        count = self._alive.count
        return {
            "dropped": self.waiting.lost,
            "clusters": len(self.clusters.states),
            "tracks": count[Kind.BORN],
            "merged": count[Kind.MERGED],
            "lost": count[Kind.BORN] - count[Kind.MERGED] - len(self.clusters.states),  # for now: it may be found again
            "tracked_ms": quantiles(self.tracked.recent_ms),
        }


def quantiles(of: Callable[[float], float | None]) -> dict[str, float | None]:
    """Median and 99 % of durations in ms, as plain values."""
    return {f"p{share}": None if (ms := of(share / 100)) is None else round(ms, 3) for share in (50, 99)}
