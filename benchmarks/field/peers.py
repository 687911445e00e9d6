# SPDX-License-Identifier: Apache-2.0
"""Other people's trackers behind our interface: eventcv's connected components, dv-processing's mean shift, REMOT's output.

They see windows of fixed length; a window's answer carries the time of its end. Both report points, so that their boxes are
squares: eventcv's of the blob's area, dv-processing's of its bandwidth.
"""

from __future__ import annotations

import csv
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import timedelta
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events
from evcot.tracks.log import TRACK, Kind, TrackLog
from field.member import Absent
from shared import SHARED

__all__ = [
    "DV",
    "EVENTCV",
    "DvSettings",
    "DvTracker",
    "EventcvSettings",
    "EventcvTracker",
    "remot_log",
    "varied_dv",
    "varied_eventcv",
]

_REMOT = "remot_outbound_tracks.csv"


@dataclass(frozen=True)
class EventcvSettings:
    """Of eventcv's tracker, and of what is usual in front of it.

    Attributes:
        shrink: pixels a side that are one in the image of counts, so that the edges of an object join; areas and distances are
            those of the sensor.
        age: how many windows must have shown a blob before it counts.
    """

    window_us: int = 20_000
    min_area: int = 20
    max_distance: float = 20.0
    max_missed: int = 3
    connectivity: int = 8
    activity_us: int = 0
    shrink: int = 1
    age: int = 2


@dataclass(frozen=True)
class DvSettings:
    """Of dv-processing's mean shift tracker, and of what is usual around it.

    Attributes:
        again_us: how often new tracks are looked for, in an image `2 ** pyramid` times as small.
        min_events: in a window and within the bandwidth; a track with fewer is removed. So is the younger of two tracks that
            come closer than half the bandwidth.
    """

    window_us: int = 10_000
    bandwidth: int = 20
    step: float = 0.5
    weight: float = 1.0
    max_tracks: int = 8
    again_us: int = 100_000
    pyramid: int = 0
    activity_us: int = 0
    min_events: int = 10
    age: int = 2


EVENTCV = {
    "plain": EventcvSettings(),
    "filtered": EventcvSettings(activity_us=5_000),
    "joined": EventcvSettings(30_000, 100, 40.0, 4, activity_us=10_000, shrink=4),
}
DV = {
    "plain": DvSettings(),
    "filtered": DvSettings(activity_us=5_000),
    "large": DvSettings(20_000, 40, pyramid=2, activity_us=10_000, min_events=60),
}


def varied_eventcv(near: EventcvSettings, random: np.random.Generator) -> EventcvSettings:
    """Each setting as it was or, as often, anywhere in a sensible range."""
    return _some_of(
        near,
        random,
        window_us=round(_between(random, 4_000, 50_000)),
        min_area=round(_between(random, 4, 200)),
        max_distance=_between(random, 5, 60),
        max_missed=int(random.integers(0, 8)),
        connectivity=int(random.choice((4, 8))),
        activity_us=int(random.choice((0, 2_000, 5_000, 10_000, 20_000))),
        shrink=int(random.integers(1, 9)),
        age=int(random.integers(1, 6)),
    )


def varied_dv(near: DvSettings, random: np.random.Generator) -> DvSettings:
    """Each setting as it was or, as often, anywhere in a sensible range."""
    return _some_of(
        near,
        random,
        window_us=round(_between(random, 4_000, 50_000)),
        bandwidth=round(_between(random, 8, 60)),
        step=random.uniform(0.2, 0.9),
        weight=_between(random, 0.5, 2.0),
        max_tracks=int(random.integers(2, 16)),
        again_us=round(_between(random, 10_000, 500_000)),
        pyramid=int(random.integers(0, 4)),
        activity_us=int(random.choice((0, 2_000, 5_000, 10_000, 20_000))),
        min_events=round(_between(random, 3, 300)),
        age=int(random.integers(1, 8)),
    )


def _some_of(near: Any, random: np.random.Generator, **drawn: Any) -> Any:
    return replace(near, **{name: value for name, value in drawn.items() if random.random() < 0.5})


def _between(random: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


class _Windowed(ABC):
    """Cuts the stream into windows, and makes records of what each window shows."""

    def __init__(self, window_us: int) -> None:
        self._window_us = window_us
        self._open: list[Events] = []
        self._begin_us: int | None = None
        self._alive: dict[int, tuple[float, float, float]] = {}
        self._numbers: dict[int, int] = {}
        self._seen = 0
        self.settled = 0

    @abstractmethod
    def look(self, events: Events, begin_us: int) -> dict[int, tuple[float, float, float]]:
        """Identity -> x, y, half side, of what is tracked after the window."""

    def feed(self, events: Events) -> tuple[NDArray[np.void], NDArray[np.int16]]:
        records: list[tuple[Any, ...]] = []
        if self._begin_us is None and len(events):
            self._begin_us = int(events.t_us[0])
        rest = events
        while len(rest) and self._begin_us is not None:
            inside = int(np.searchsorted(rest.t_us, self._begin_us + self._window_us))
            self._open.append(rest[:inside])
            if inside == len(rest):
                break
            records += self._end()
            rest = rest[inside:]
        self._seen += len(events)
        self.settled = self._seen
        return self._made(records), np.full(len(events), -1, np.int16)

    def finish(self) -> NDArray[np.void]:
        return self._made(self._end() if self._open else [])

    def _end(self) -> Iterator[tuple[Any, ...]]:
        assert self._begin_us is not None
        window = Events.joined(self._open)
        now = self.look(window, self._begin_us)
        self._begin_us += self._window_us
        self._open = []
        for identity in [one for one in self._alive if one not in now]:
            yield (Kind.LOST, identity, *self._alive[identity], self._begin_us)
        for identity, place in now.items():
            yield (Kind.MOVED if identity in self._alive else Kind.BORN, identity, *place, self._begin_us)
        self._alive = now

    def _made(self, records: Iterator[tuple[Any, ...]] | list[tuple[Any, ...]]) -> NDArray[np.void]:
        rows = list(records)
        made = np.zeros(len(rows), TRACK)
        for row, (kind, identity, x, y, half, t_us) in zip(made, rows, strict=True):
            row["kind"], row["track_id"], row["t_us"] = kind, identity, t_us
            row["x"], row["y"], row["radius"] = x, y, half
            for name in {"width", "height"} & set(TRACK.names or ()):
                row[name] = 2 * half
        made["event_index"], made["other_id"] = self._seen, -1
        return made


class EventcvTracker(_Windowed):
    """eventcv's `Tracker` on images of event counts, behind its background activity filter if that is asked for."""

    def __init__(self, settings: EventcvSettings, sensor: tuple[int, int]) -> None:
        import eventcv

        super().__init__(settings.window_us)
        self._eventcv, self._settings, self._sensor = eventcv, settings, sensor
        self._tracker = eventcv.Tracker(
            connectivity=settings.connectivity,
            min_area=max(1, round(settings.min_area / settings.shrink**2)),
            max_distance=settings.max_distance / settings.shrink,
            max_missed=settings.max_missed,
        )

    def look(self, events: Events, begin_us: int) -> dict[int, tuple[float, float, float]]:
        shrink = self._settings.shrink
        stream = self._stream(events.x, events.y, events.t_us - begin_us, events.p, self._sensor)
        if self._settings.activity_us:
            stream = stream.background_activity_filter(self._settings.activity_us)
        if shrink > 1:
            x, y, t_us, p = stream.numpy().T
            size = -(-self._sensor[0] // shrink), -(-self._sensor[1] // shrink)
            stream = self._stream(x // shrink, y // shrink, t_us, p, size)
        found = {}
        for track in self._tracker.update(stream.count()):
            if track["age"] >= self._settings.age:
                x, y = (shrink * (float(place) + 0.5) - 0.5 for place in track["centroid"])
                found[int(track["id"])] = x, y, 0.5 * shrink * float(np.sqrt(track["area"]))
        return found

    def _stream(self, x: Any, y: Any, t_us: Any, p: Any, size: tuple[int, int]) -> Any:
        columns = np.stack((x, y, t_us, p), axis=1).astype(np.int64)
        if not len(columns):
            columns = np.zeros((1, 4), np.int64)  # an empty stream has no image
        return self._eventcv.from_numpy(columns, sensor_size=size, time_unit="us")


class DvTracker(_Windowed):
    """dv-processing's `MeanShiftTracker` on its own time surface, with its own blob detector for new tracks."""

    def __init__(self, settings: DvSettings, sensor: tuple[int, int]) -> None:
        import dv_processing as dv

        super().__init__(settings.window_us)
        self._dv, self._settings = dv, settings
        window = timedelta(microseconds=settings.window_us)
        self._tracker = dv.features.MeanShiftTracker(sensor, settings.bandwidth, window, settings.step, settings.weight)
        self._tracker.setDetector(dv.features.EventFeatureBlobDetector(sensor, settings.pyramid))
        self._tracker.setMaxTracks(settings.max_tracks)
        again = timedelta(microseconds=settings.again_us)
        self._tracker.setRedetectionStrategy(dv.features.UpdateIntervalRedetection(again))
        self._filter = None
        if settings.activity_us:
            quiet = timedelta(microseconds=settings.activity_us)
            self._filter = dv.noise.BackgroundActivityNoiseFilter(sensor, quiet)
        self._ages: dict[int, int] = {}

    def look(self, events: Events, begin_us: int) -> dict[int, tuple[float, float, float]]:
        store = self._dv.EventStore()
        for event in zip(*(column.tolist() for column in (events.t_us, events.x, events.y, events.p)), strict=True):
            store.push_back(*event)  # there is no other way in
        if self._filter is not None:
            self._filter.accept(store)
            store = self._filter.generateEvents()
        if store.isEmpty():
            return dict(self._alive)
        self._tracker.accept(store)
        result = self._tracker.runTracking()
        if result is None:
            return dict(self._alive)
        places = np.array(store.coordinates(), float).reshape(-1, 2)
        return self._kept(result.keypoints, places)

    def _kept(self, keypoints: Any, places: NDArray[np.float64]) -> dict[int, tuple[float, float, float]]:
        """The tracks that hold enough events and are not on an older one; the others are removed."""
        reach, kept, removed = self._settings.bandwidth, dict[int, tuple[float, float, float]](), []
        for one in sorted(keypoints, key=lambda one: int(one.class_id)):
            number, (x, y) = int(one.class_id), one.pt
            events = np.count_nonzero(np.hypot(places[:, 0] - x, places[:, 1] - y) <= reach)
            twice = any(np.hypot(x - other[0], y - other[1]) < reach / 2 for other in kept.values())
            if events < self._settings.min_events or twice:
                removed.append(number)
            else:
                kept[number] = float(x), float(y), float(reach)
        if removed:
            self._tracker.removeTracks(removed)
        self._ages = {number: self._ages.get(number, 0) + 1 for number in kept}
        return {number: place for number, place in kept.items() if self._ages[number] >= self._settings.age}


def remot_log(instants_us: NDArray[np.int64], frames_later: int) -> TrackLog:
    """What REMOT put out on traffic_outbound, at the truth's instants; its frames moved by some."""
    path = SHARED / _REMOT
    if not path.is_file():
        raise Absent(f"{_REMOT} is not in {SHARED}")
    with path.open(encoding="utf-8", newline="") as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    rows = [row for row in rows if 0 <= row["frame"] + frames_later < len(instants_us)]
    records = np.zeros(len(rows), TRACK)
    for record, row in zip(records, rows, strict=True):
        record["t_us"], record["track_id"] = instants_us[int(row["frame"]) + frames_later], row["track_id"]
        record["x"], record["y"] = row["left"] + row["width"] / 2, row["top"] + row["height"] / 2
        record["radius"] = max(row["width"], row["height"]) / 2
        for name in {"width", "height"} & set(TRACK.names or ()):
            record[name] = row[name]
    records["kind"], records["other_id"] = Kind.MOVED, -1
    return TrackLog("remot", records[np.argsort(records["t_us"], kind="stable")], np.empty(0, np.int16))
