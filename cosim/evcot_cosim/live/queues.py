# SPDX-License-Identifier: Apache-2.0
"""A bounded queue between two threads, whose oldest items are dropped and counted, and statistics of durations."""

from __future__ import annotations

import threading
import time
from collections import deque
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events

__all__ = ["Arrival", "Latency", "Taken", "Waiting"]


@dataclass(frozen=True)
class Arrival:
    """Events received together; `arrived_s`: arrival time of the first of them, by `time.perf_counter`."""

    events: Events
    arrived_s: float


class Waits(Protocol):
    """Interface of an item in a `Waiting` queue."""

    @property
    def events(self) -> Events: ...

    @property
    def arrived_s(self) -> float: ...


_Item = TypeVar("_Item", bound=Waits)


@dataclass(frozen=True)
class Taken(Generic[_Item]):
    """The result of `take`: `lost` events were dropped since the last call, before the items."""

    lost: int
    items: list[_Item]


class Waiting(Generic[_Item]):
    """A queue between two threads that never blocks the first one.

    Args:
        wait_s: items that have waited longer are dropped if there is a newer one.
        events_max: maximum number of waiting events, beyond which the oldest are dropped.

    Attributes:
        lost: events dropped so far.
    """

    def __init__(self, wait_s: float, events_max: int) -> None:
        self._wait_s, self._events_max = wait_s, events_max
        self._items: deque[_Item] = deque()
        self._events = 0
        self._unreported = 0
        self._closed = False
        self._changed = threading.Condition()
        self.lost = 0

    def put(self, item: _Item) -> None:
        """Add an item that is newer than all waiting ones."""
        with self._changed:
            self._items.append(item)
            self._events += len(item.events)
            while len(self._items) > 1 and self._events > self._events_max:
                self._drop_oldest()
            self._changed.notify()

    def close(self) -> None:
        """Mark the end of the stream: nothing more will be added."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def take(self, timeout_s: float = 0.0, most: int | None = None) -> Taken[_Item] | None:
        """All waiting items, or at most `most`; without items after the timeout, None at the end of the stream."""
        with self._changed:
            if not self._items and not self._closed:
                self._changed.wait(timeout_s)
            if not self._items and self._closed and not self._unreported:
                return None
            now_s = time.perf_counter()
            while len(self._items) > 1 and now_s - self._items[0].arrived_s > self._wait_s:
                self._drop_oldest()
            count = len(self._items) if most is None else min(most, len(self._items))
            items = [self._items.popleft() for _ in range(count)]
            self._events -= sum(len(item.events) for item in items)
            lost, self._unreported = self._unreported, 0
            return Taken(lost, items)

    def _drop_oldest(self) -> None:
        count = len(self._items.popleft().events)
        self._events -= count
        self._unreported += count
        self.lost += count


_RECENT = 2_000
_LEAST_S, _MOST_S = 1e-6, 1e3
_BINS_PER_DECADE = 200  # 1.2 % wide
_BINS = int(_BINS_PER_DECADE * np.log10(_MOST_S / _LEAST_S))


class Latency:
    """Thread-safe statistics of durations."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._recent: deque[float] = deque(maxlen=_RECENT)
        self._counts = np.zeros(_BINS + 1, np.int64)

    def add(self, durations_s: NDArray[np.float64]) -> None:
        """Add (k,) durations in seconds."""
        place = np.log10(np.clip(durations_s, _LEAST_S, _MOST_S) / _LEAST_S) * _BINS_PER_DECADE
        with self._lock:
            self._recent.extend(durations_s.tolist())
            np.add.at(self._counts, place.astype(np.int64), 1)

    def recent_ms(self, share: float) -> float | None:
        """Quantile of the most recent durations in ms; None before the first."""
        with self._lock:
            recent = list(self._recent)
        return float(np.quantile(recent, share)) * 1e3 if recent else None

    def overall_ms(self, share: float) -> float | None:
        """Quantile of all durations so far in ms, to 1.2 %; None before the first."""
        with self._lock:
            upto = np.cumsum(self._counts)
        if not upto[-1]:
            return None
        return float(_LEAST_S * 10 ** ((np.searchsorted(upto, share * upto[-1]) + 0.5) / _BINS_PER_DECADE)) * 1e3
