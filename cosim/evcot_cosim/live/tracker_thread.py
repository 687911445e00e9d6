# SPDX-License-Identifier: Apache-2.0
"""A tracker of a live run in a thread of its own; across gaps in the stream; and the simulated hardware as one."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.errors import RecordingError, ToolchainError
from evcot.events import Events
from evcot.hardware.config import CotConfig, MotionConfig
from evcot.hardware.golden import GoldenTracker
from evcot.recordings.formats.source import Sensor
from evcot.tracks.log import DROPPED, TRACK, Kind
from evcot.tracks.record import no_verdicts
from evcot.tracks.tracking import Tracker, TrackerOutput, class_names_of, take_verdicts

from ..devices.device import build_device
from ..devices.tracker import DeviceTracker
from .queues import Arrival, Latency, Waiting
from .visible_clusters import Alive, Clusters

__all__ = ["HARDWARE", "Beside", "GapTracker", "Lane", "hardware_beside", "quantiles", "warm_up"]


class GapTracker:
    """Wraps a tracker so that its records number the events of the whole stream, dropped ones included. See `Tracker`.

    Args:
        tracker: a new tracker, which gets the events that were not dropped.
    """

    def __init__(self, tracker: Tracker) -> None:
        self._tracker = tracker
        self._fed = 0
        self._verdicts = no_verdicts()
        self.class_names = class_names_of(tracker)
        # Of every gap that still matters, and the last one before what is not settled: events that the tracker had been
        # fed before it, and how many were missing after it.
        self._gaps = [(0, 0)]

    def skip(self, count: int) -> NDArray[np.int16]:
        """Count dropped events; returns their owners."""
        if count:
            fed, missing = self._gaps[-1]
            if fed == self._fed:
                self._gaps.pop()
            self._gaps.append((self._fed, missing + count))
        return np.full(count, DROPPED, np.int16)

    def feed(self, events: Events) -> TrackerOutput:
        """See `Tracker.feed`."""
        records, owner = self._tracker.feed(events)
        self._verdicts = take_verdicts(self._tracker)
        self._verdicts["event_index"] += self._gaps[-1][1]  # a verdict is of an event of this run
        self._fed += len(events)
        self._number(records)
        self._forget()
        return records, owner

    def take_verdicts(self) -> NDArray[np.void]:
        """Those of the last run."""
        taken, self._verdicts = self._verdicts, no_verdicts()
        return taken

    def finish(self) -> NDArray[np.void]:
        """See `Tracker.finish`."""
        records = self._tracker.finish()
        self._number(records)
        return records

    @property
    def settled(self) -> int:
        """See `Tracker.settled`."""
        return self._tracker.settled + self._gaps[0][1]

    def _number(self, records: NDArray[np.void]) -> None:
        """Convert the event numbers of records to those of the stream."""
        if len(records):
            fed, missing = (np.array(column) for column in zip(*self._gaps, strict=True))
            records["event_index"] += missing[np.searchsorted(fed, records["event_index"], "right") - 1]

    def _forget(self) -> None:
        """Discard gaps that no future record can refer to."""
        settled = self._tracker.settled
        while len(self._gaps) > 1 and self._gaps[1][0] <= settled:
            self._gaps.pop(0)


HARDWARE = "hardware"
_RTL, _MODEL = "RTL in simulation", "golden model"
_BLOB_EVENTS = 4_000


def hardware_beside(config: CotConfig | MotionConfig, sensor: Sensor) -> Beside:
    """The module with this configuration; compiled where that has not been done, which takes 10 to 60 s.

    The golden model decides as the RTL does, bit for bit. It is there from the start where the RTL
    cannot be compiled, and takes over, beginning anew, when events come faster than the simulation takes them.
    """
    warm_up(GoldenTracker(config), sensor)
    try:
        tracker = DeviceTracker(config, model=build_device(config, waves=False))
    except ToolchainError as error:
        return Beside(HARDWARE, f"{_MODEL}; {error}", GoldenTracker(config))
    return Beside(HARDWARE, _RTL, tracker, (_MODEL, lambda: GoldenTracker(config)))


def warm_up(tracker: Tracker, sensor: Sensor) -> None:
    """Have everything compiled before the first event comes: a blob that rests for a while does it."""
    random = np.random.default_rng(0)
    x, y = ((side / 2 + random.normal(0, 2, _BLOB_EVENTS)).clip(0, side - 1).astype(np.uint16) for side in sensor)
    polarity = random.integers(2, size=_BLOB_EVENTS).astype(np.uint8)
    tracker.feed(Events(np.arange(_BLOB_EVENTS, dtype=np.int64) * 20, x, y, polarity))
    tracker.finish()


_LOSSES_MAX = 3  # until a substitute takes over
_LOSS_S = 1.0  # between two that count
_WAITING_EVENTS = 1 << 23  # 100 MB: enough for a quarter of a second of any camera

Keep = Callable[[NDArray[np.void], NDArray[np.int16], NDArray[np.void]], None]
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
        keep: called with all records, owners and verdicts; owners of dropped events are included.
        done: called with every packet that was tracked, and its owners.

    Attributes:
        about: what runs in it, which a substitute changes.
        waiting: the queue.
        tracked: durations from the arrival of a packet's first event until it was tracked.
        fed, last_us: number of events tracked, and time of the last of them.
    """

    def __init__(
        self, run: Beside, wait_s: float, keep: Keep = lambda _records, _owner, _verdicts: None,
        done: Done = lambda _arrival, _owner: None,
    ) -> None:  # fmt: skip
        self.name, self.about = run.name, run.about
        self.waiting: Waiting[Arrival] = Waiting(wait_s, _WAITING_EVENTS)
        self.tracked = Latency()
        self.fed = 0
        self.last_us = 0
        self._tracker = GapTracker(run.tracker)
        self._alive = Alive(self._tracker.class_names)
        self._substitute = run.substitute
        self._losses, self._loss_s = 0, -math.inf
        self._keep, self._done = keep, done

    @property
    def clusters(self) -> Clusters:
        """The clusters that are visible now."""
        return self._alive.clusters

    @property
    def labels(self) -> tuple[str, ...]:
        """What `Clusters.label` counts."""
        return self._alive.labels

    def work(self) -> None:
        """Track what comes until the queue is closed."""
        while (taken := self.waiting.take(0.1, most=1)) is not None:
            if taken.lost and self._substitute is not None and self._is_late_again():
                self._take_over("did not keep up")
            self._keep(np.empty(0, TRACK), self._tracker.skip(taken.lost), no_verdicts())
            for arrival in taken.items:
                self._step(arrival)
        records = self._tracker.finish()
        self._alive.apply(records)
        self._keep(records, np.empty(0, np.int16), no_verdicts())

    def _step(self, arrival: Arrival) -> None:
        try:
            records, owner = self._tracker.feed(arrival.events)
        except RecordingError as error:
            if self._substitute is None:
                raise
            self._take_over(str(error))
            records, owner = self._tracker.feed(arrival.events)
        verdicts = self._tracker.take_verdicts()
        self._alive.apply(records, verdicts)
        self.fed += len(owner)
        self.last_us = int(arrival.events.t_us[-1])
        self.tracked.add(np.array([time.perf_counter() - arrival.arrived_s]))
        self._keep(records, owner, verdicts)
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
        self._tracker = GapTracker(start())
        self._alive = Alive(self._tracker.class_names)

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
