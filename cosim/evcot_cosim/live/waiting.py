# SPDX-License-Identifier: Apache-2.0
"""What waits between two threads of which the second may be too slow: bounded; the newest stays, the oldest is given up and
counted."""

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
    """Events that came together; `arrived_s`: when the first of them happened or came, by `time.perf_counter`."""

    events: Events
    arrived_s: float


class Waits(Protocol):
    """What can wait."""

    @property
    def events(self) -> Events: ...

    @property
    def arrived_s(self) -> float: ...


_Item = TypeVar("_Item", bound=Waits)


@dataclass(frozen=True)
class Taken(Generic[_Item]):
    """What was taken: `lost` events were given up since the last time, then come the items."""

    lost: int
    items: list[_Item]


class Waiting(Generic[_Item]):
    """A queue between two threads that never makes the first one wait.

    Args:
        wait_s: what has waited longer is given up, as long as something newer is there.
        events_max: of more waiting events the oldest are given up.

    Attributes:
        lost: events given up so far.
    """

    def __init__(self, wait_s: float, events_max: int) -> None:
        self._wait_s, self._events_max = wait_s, events_max
        self._items: deque[_Item] = deque()
        self._events = 0
        self._untold = 0
        self._closed = False
        self._changed = threading.Condition()
        self.lost = 0

    def put(self, item: _Item) -> None:
        """Add what is newer than everything that waits."""
        with self._changed:
            self._items.append(item)
            self._events += len(item.events)
            while len(self._items) > 1 and self._events > self._events_max:
                self._give_up()
            self._changed.notify()

    def close(self) -> None:
        """Say that nothing more comes."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def take(self, timeout_s: float = 0.0, most: int | None = None) -> Taken[_Item] | None:
        """Everything that waits, or `most` items of it; nothing in it when the time is over, None when nothing can come."""
        with self._changed:
            if not self._items and not self._closed:
                self._changed.wait(timeout_s)
            if not self._items and self._closed and not self._untold:
                return None
            now_s = time.perf_counter()
            while len(self._items) > 1 and now_s - self._items[0].arrived_s > self._wait_s:
                self._give_up()
            count = len(self._items) if most is None else min(most, len(self._items))
            items = [self._items.popleft() for _ in range(count)]
            self._events -= sum(len(item.events) for item in items)
            lost, self._untold = self._untold, 0
            return Taken(lost, items)

    def _give_up(self) -> None:
        count = len(self._items.popleft().events)
        self._events -= count
        self._untold += count
        self.lost += count
