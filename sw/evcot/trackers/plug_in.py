# SPDX-License-Identifier: Apache-2.0
"""Trackers of other packages: how they are loaded, begun, fed and checked. An error names engine, package and rule."""

from __future__ import annotations

import inspect
import traceback
from collections.abc import Callable
from dataclasses import dataclass, is_dataclass
from importlib.metadata import EntryPoint
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import EngineError, EvcotError, TrackLogError
from ..events import Events
from ..tracks.record import BEGIN_US, DROPPED, TRACK, Kind, check_records
from ..tracks.tally import IdSet
from ..tracks.tracking import TrackerOutput

__all__ = ["PlugIn", "PlugInTracker", "plug_in_sources"]

_METHODS = ("feed", "finish")
_SLOT_MAX = np.iinfo(np.int16).max


@dataclass(frozen=True)
class _NoSettings:
    """Of a tracker that is made from the sensor alone."""


class PlugIn:
    """What the entry point of a tracker names: a class, or another callable, that makes trackers.

    Args:
        name: what messages call it.
        point: names a callable with the arguments (width, height) or (width, height, settings); the default of `settings` is a
            dataclass.

    Attributes:
        settings: the default ones.

    Raises:
        EngineError: it cannot be imported, or is no such callable.
    """

    def __init__(self, name: str, point: EntryPoint) -> None:
        self._name = f"{name}: {point.value}"
        self._make: Callable[..., Any] = _called(self._name, "cannot be loaded", point.load)
        rule = "must be callable with (width, height) or (width, height, settings)"
        try:
            parameters = inspect.signature(self._make).parameters
        except (TypeError, ValueError):
            raise EngineError(f"{self._name}: is of type {type(self._make).__name__}: {rule}") from None
        self._configured = "settings" in parameters
        try:
            inspect.signature(self._make).bind(1, 1, *([None] if self._configured else []))
        except TypeError as error:
            raise EngineError(f"{self._name}: {error}: {rule}") from error
        self.settings: Any = parameters["settings"].default if self._configured else _NoSettings()
        if not is_dataclass(self.settings) or isinstance(self.settings, type):
            default = "none" if self.settings is inspect.Parameter.empty else f"{self.settings!r}"
            raise EngineError(f"{self._name}: default of settings is {default}: must be an instance of a dataclass")

    def start(self, settings: Any, width: int, height: int) -> PlugInTracker:
        """A new tracker for a sensor of this size, in pixels.

        Raises:
            EngineError: it cannot be made, or is no tracker.
        """
        arguments = (width, height, *([settings] if self._configured else []))
        made = _called(self._name, "cannot be made", lambda: self._make(*arguments))
        for method in _METHODS:
            if not callable(getattr(made, method, None)):
                raise EngineError(
                    f"{self._name}: makes something of type {type(made).__name__} without {method}: must have feed and finish"
                )
        return PlugInTracker(self._name, made)


class PlugInTracker:
    """A tracker of another package, whose every answer is checked; see `Tracker`.

    Args:
        name: what messages call it.
        tracker: before its first event. `settled` may be missing; then no event is settled.
    """

    def __init__(self, name: str, tracker: Any) -> None:
        self._name, self._tracker = name, tracker
        self._events, self._records, self._settled = 0, 0, 0
        self._first_us, self._last_us, self._since_us = BEGIN_US, BEGIN_US, BEGIN_US
        self._born = IdSet()

    def feed(self, events: Events) -> TrackerOutput:
        """See `Tracker.feed`.

        Raises:
            EngineError: the tracker raises, or answers with anything but records and owners that keep the rules.
        """
        if len(events):
            self._first_us = self._first_us if self._events else int(events.t_us[0])
            self._last_us = int(events.t_us[-1])
        self._events += len(events)
        answer = _called(self._name, "feed failed", lambda: self._tracker.feed(events.read_only()))
        if not isinstance(answer, tuple) or len(answer) != 2:
            raise self._wrong("feed", "returns", answer, "must be a tuple (records, owner)")
        records = self._checked("feed", answer[0], self._events - 1)
        owner = answer[1]
        if not isinstance(owner, np.ndarray) or owner.shape != (len(events),) or owner.dtype.kind not in "iu":
            raise self._wrong("feed", "owner is", owner, f"must be whole numbers, one for each of the {len(events)} events")
        if len(owner) and not DROPPED <= owner.min() <= owner.max() <= _SLOT_MAX:
            worst = owner.min() if owner.min() < DROPPED else owner.max()
            raise EngineError(f"{self._name}: feed: owner = {worst}: must be from {DROPPED} to {_SLOT_MAX}")
        return records, owner.astype(np.int16)

    def finish(self) -> NDArray[np.void]:
        """See `Tracker.finish`.

        Raises:
            EngineError: as for `feed`.
        """
        return self._checked("finish", _called(self._name, "finish failed", self._tracker.finish), self._events)

    @property
    def settled(self) -> int:
        """See `Tracker.settled`."""
        said = getattr(self._tracker, "settled", 0)
        if not isinstance(said, int | np.integer) or not self._settled <= said <= self._events:
            rule = f"must be a whole number from {self._settled}, as before, to {self._events} events"
            raise EngineError(f"{self._name}: settled = {said!r}: {rule}")
        self._settled = int(said)
        return self._settled

    def _checked(self, method: str, records: Any, index_max: int) -> NDArray[np.void]:
        if not isinstance(records, np.ndarray) or records.ndim != 1 or records.dtype != TRACK:
            raise self._wrong(method, "records are", records, "must be a 1-d array of dtype evcot.TRACK")
        try:
            check_records(records, self._records, self._since_us)
        except TrackLogError as error:
            raise EngineError(f"{self._name}: {method}: {error}") from error
        for name, low, high in (
            ("t_us", self._first_us, self._last_us), ("event_index", self._settled, max(index_max, self._settled)),
        ):  # fmt: skip
            good = (records[name] >= low) & (records[name] <= high)
            self._check(method, records, name, good, f"must be from {low} to {high}, as the events so far")
        self._check_births(method, records)
        self._records += len(records)
        self._since_us = int(records["t_us"][-1]) if len(records) else self._since_us
        return records

    def _check_births(self, method: str, records: NDArray[np.void]) -> None:
        ids, first = np.unique(records["track_id"], return_index=True)
        known = np.array([int(track_id) in self._born for track_id in ids], bool)
        unborn = np.zeros(len(records), bool)
        unborn[first] = ~known & (records["kind"][first] != Kind.BORN)
        self._check(method, records, "kind", ~unborn, "must be BORN in the first record of a track_id")
        self._born.add(ids)

    def _check(self, method: str, records: NDArray[np.void], name: str, good: NDArray[np.bool_], rule: str) -> None:
        if not good.all():
            row = int(np.argmin(good))
            raise EngineError(f"{self._name}: {method}: record {self._records + row}: {name} = {records[name][row]}: {rule}")

    def _wrong(self, method: str, verb: str, answer: Any, rule: str) -> EngineError:
        shape = f" of shape {answer.shape} and dtype {answer.dtype}" if isinstance(answer, np.ndarray) else ""
        return EngineError(f"{self._name}: {method}: {verb} {type(answer).__name__}{shape[:80]}: {rule}")


def plug_in_sources(point: EntryPoint) -> list[Path]:
    """The Python files of the package, or the module, that an entry point names; empty where there are none."""
    try:
        spec = find_spec(point.module.partition(".")[0])
    except (ImportError, ValueError):
        return []
    if spec is None or spec.origin is None:
        return []
    origin = Path(spec.origin)
    return sorted(origin.parent.rglob("*.py")) if spec.submodule_search_locations else [origin]


def _called(name: str, fault: str, function: Callable[[], Any]) -> Any:
    """Call what belongs to another package; what it raises becomes one line with the place."""
    try:
        return function()
    except EvcotError:
        raise
    except Exception as error:
        frame = traceback.extract_tb(error.__traceback__)[-1]
        what = f"{type(error).__name__}: {' '.join(str(error).split())}".removesuffix(": ")
        raise EngineError(f"{name}: {fault}: {what} ({Path(frame.filename).name}, line {frame.lineno})") from error
