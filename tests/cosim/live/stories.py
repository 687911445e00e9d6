# SPDX-License-Identifier: Apache-2.0
"""Events, trackers and sources for tests of the live view."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events
from evcot.tracks.log import TRACK, Kind
from evcot.tracks.record import ClassNames, no_verdicts
from evcot.tracks.tracking import TrackerOutput
from evcot_cosim.live.player import Player, Run, Wish
from evcot_cosim.live.queues import Arrival
from evcot_cosim.live.session import Session
from support.logs import verdicts_of

SENSOR = (64, 48)
HELLO = {
    "name": "a drive", "engine": "rct", "preset": "plain", "width": SENSOR[0], "height": SENSOR[1], "speed": 1.0,
    "engines": {"rct": ["plain", "discs"], "adaptive": ["auto"], "cot_motion": ["motion"]},
    "lanes": ["rct"], "kinds": ["software"], "seekable": False,
}  # fmt: skip


def events(*t_us: int, x: int = 1, y: int = 2) -> Events:
    """Events at these times, all at one pixel; the polarity alternates."""
    n = len(t_us)
    return Events(
        np.array(t_us, np.int64), np.full(n, x, np.uint16), np.full(n, y, np.uint16), (np.arange(n) % 2).astype(np.uint8)
    )


def random_events(n: int, seed: int, step_us: int = 10) -> Events:
    """Events all over the sensor, `step_us` apart on average."""
    random = np.random.default_rng(seed)
    x, y = (random.integers(side, size=n).astype(np.uint16) for side in SENSOR)
    return Events(np.cumsum(random.integers(2 * step_us, size=n)), x, y, random.integers(2, size=n).astype(np.uint8))


def record(kind: Kind, t_us: int, index: int, track_id: int, x: float = 0.0) -> NDArray[np.void]:
    """One record."""
    row = np.zeros(1, TRACK)
    row["t_us"], row["event_index"], row["kind"], row["track_id"], row["x"], row["y"] = t_us, index, kind, track_id, x, 5.0
    row["radius"], row["width"], row["height"], row["n_ev"], row["support"], row["other_id"] = 3.0, 7.0, 5.0, 1, 1, -1
    return row


class EveryTenth:
    """A tracker whose one cluster is born at the first event, moves to every tenth and is lost at the end."""

    def __init__(self) -> None:
        self._seen = 0
        self._last_us = 0

    def feed(self, some: Events) -> TrackerOutput:
        numbers = self._seen + np.arange(len(some))
        tenth = numbers % 10 == 0
        records = np.zeros(np.count_nonzero(tenth), TRACK)
        records["t_us"], records["event_index"] = some.t_us[tenth], numbers[tenth]
        records["kind"] = np.where(numbers[tenth] == 0, Kind.BORN, Kind.MOVED)
        records["x"], records["y"], records["radius"], records["other_id"] = some.x[tenth], some.y[tenth], 3, -1
        records["width"] = records["height"] = 7
        self._seen += len(some)
        self._last_us = int(some.t_us[-1])
        return records, np.where(tenth, 0, -1).astype(np.int16)

    def finish(self) -> NDArray[np.void]:
        return record(Kind.LOST, self._last_us + 1, self._seen, 0)

    @property
    def settled(self) -> int:
        return self._seen


class Classified(EveryTenth):
    """The same with a classifier: a cup from event 100 on, none of the classes from event 200 on."""

    class_names: ClassNames = MappingProxyType({3: "cup", 8: "plate"})

    def __init__(self) -> None:
        super().__init__()
        self._verdicts = no_verdicts()

    def feed(self, some: Events) -> TrackerOutput:
        begin = self._seen
        output = super().feed(some)
        self._verdicts = verdicts_of(
            *((int(some.t_us[at - begin]), 0, class_id) for at, class_id in ((100, 3), (200, -1)) if begin <= at < self._seen)
        )
        self._verdicts["event_index"] = [at for at in (100, 200) if begin <= at < self._seen]
        return output

    def take_verdicts(self) -> NDArray[np.void]:
        return self._verdicts


class Played:
    """A source that gives its parts one after the other; `before(i)` is called before the i-th."""

    name = "played"
    sensor = SENSOR

    def __init__(self, parts: Iterable[Events], before: Callable[[int], object] = lambda _: None) -> None:
        self.left_out: Counter[str] = Counter()
        self.closed = False
        self._parts, self._before = parts, before

    def arrivals(self, wanted: Callable[[], bool]) -> Iterator[Arrival]:
        for i, part in enumerate(self._parts):
            self._before(i)
            if not wanted():
                return
            yield Arrival(part, time.perf_counter())

    def close(self) -> None:
        self.closed = True


def playing(session: Session, hello: dict[str, object] = HELLO, fixed: str = "") -> Player:
    """One session, and nothing else whatever is wished."""
    return Player(lambda _wish: lambda: Run(session, hello), Wish("rct", "plain"), fixed)


def parts_of(some: Events, size: int) -> list[Events]:
    return [some[begin : begin + size] for begin in range(0, len(some), size)]


def wait_until(holds: Callable[[], bool], seconds: float = 10.0) -> None:
    deadline_s = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < deadline_s, "waited for too long"
        time.sleep(0.01)
