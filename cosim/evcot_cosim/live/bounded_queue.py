# SPDX-License-Identifier: Apache-2.0
"""A bounded queue between two threads of which the second may be too slow: the oldest items are dropped and counted."""

from __future__ import annotations

import threading
import time
from collections import deque
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from evcot.events import Events

__all__ = ["Arrival", "Taken", "Waiting"]


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
