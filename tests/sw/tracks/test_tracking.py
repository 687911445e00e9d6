# SPDX-License-Identifier: Apache-2.0
"""Trackers over blocks of events, and behind filters."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.filters.run import apply, filtered
from evcot.scenes.registry import simulate_scene
from evcot.trackers.engines import ENGINES
from evcot.trackers.frame_based import FrameConfig
from evcot.trackers.mean_shift.tracker import MeanShiftConfig
from evcot.trackers.rct.config import RctConfig
from evcot.trackers.rct.tracker import RctTracker
from evcot.tracks.log import DROPPED, TRACK, Kind, TrackLog
from evcot.tracks.tracking import FilteredTracker, TrackerOutput, log_of


class Parrot:
    """A tracker with one record per run, and one at the end; the owner of an event is its column."""

    def __init__(self) -> None:
        self.seen = 0

    def _record(self) -> NDArray[np.void]:
        told = np.zeros(1, TRACK)
        told["event_index"] = self.seen
        return told

    def feed(self, events: Events) -> TrackerOutput:
        self.seen += len(events)
        return self._record(), events.x.astype(np.int16)

    def finish(self) -> NDArray[np.void]:
        return self._record()


def make_events(count: int) -> Events:
    return Events(np.arange(count), *(np.arange(count, dtype=np.uint16),) * 2, np.zeros(count, np.uint8))


def test_records_and_owners_are_joined_in_order() -> None:
    events = make_events(10)
    log = log_of("parrot", Parrot(), [events[:4], events[4:9], events[9:]])
    assert log.engine == "parrot"
    assert log.records["event_index"].tolist() == [4, 9, 10, 10]
    assert log.owner.tolist() == list(range(10))
    log = log_of("parrot", Parrot(), [])
    assert (log.records["event_index"].tolist(), len(log.owner)) == ([0], 0)


SENSOR = (346, 260)
FILTERS = FilterConfig(activity_us=3_000)
# Settings of each engine with which noise is never an object.
QUIET: dict[str, Any] = {
    "rct": RctConfig(visible_events=10_000),
    "mean-shift": MeanShiftConfig(points_min=1_000),
    "frames": FrameConfig(),
}
RCT = RctConfig(visible_events=40, lifetime_us=20_000)


@cache
def scene() -> Recording:
    return simulate_scene("discs", 3, {"duration_us": 150_000, "noise_hz": 5.0}).recording


def behind(size: int) -> TrackLog:
    """The scene, in runs of `size` events."""
    tracker = FilteredTracker(filtered((), FILTERS, SENSOR).keep, RctTracker(RCT))
    events = scene().events
    return log_of("rct", tracker, (events[begin : begin + size] for begin in range(0, len(events), size)))


def test_tracks_are_those_of_the_events_that_stay() -> None:
    kept, keep = apply(scene(), FILTERS)
    alone, log = log_of("rct", RctTracker(RCT), [kept.events]), behind(len(keep))
    assert 0 < np.count_nonzero(keep) < len(keep)
    assert len(alone.of_kind(Kind.BORN)) >= 4
    assert np.array_equal(log.owner[keep], alone.owner)
    assert (log.owner[~keep] == DROPPED).all()
    for name in TRACK.names or ():
        if name != "event_index":
            assert np.array_equal(log.records[name], alone.records[name])
    place = np.append(np.flatnonzero(keep), len(keep))
    assert np.array_equal(log.records["event_index"], place[alone.records["event_index"]])


@pytest.mark.parametrize("size", [1_000, 20_011])
def test_where_runs_are_cut_changes_nothing(size: int) -> None:
    whole, cut = behind(len(scene().events)), behind(size)
    assert np.array_equal(whole.records, cut.records)
    assert np.array_equal(whole.owner, cut.owner)


def test_a_run_of_which_nothing_stays() -> None:
    tracker = FilteredTracker(filtered((), FilterConfig(polarity="on"), SENSOR).keep, Silent())
    off = Events(np.arange(5), *(np.zeros(5, np.uint16),) * 2, np.zeros(5, np.uint8))
    records, owner = tracker.feed(off)
    assert (len(records), owner.tolist()) == (0, 5 * [DROPPED])
    assert tracker.finish()["event_index"].tolist() == [5]


@pytest.mark.parametrize("engine", ["rct", "mean-shift", "frames", "cot_array", "cot_motion"])
def test_no_record_is_of_a_settled_event_and_packets_settle(engine: str) -> None:
    kind = ENGINES[engine]
    preset = kind.presets["discs"] if "discs" in kind.presets else next(iter(kind.presets.values()))
    tracker = kind.start(preset, FilterConfig(), SENSOR)
    events, records = scene().events[:60_000], 0
    for begin in range(0, len(events), 499):
        settled = tracker.settled
        told, _ = tracker.feed(events[begin : begin + 499])
        assert (told["event_index"] >= settled).all()
        assert tracker.settled >= settled
        records += len(told)
    assert records > 0
    assert len(events) - 20_000 < tracker.settled <= len(events)
    settled = tracker.settled
    assert (tracker.finish()["event_index"] >= settled).all()


@pytest.mark.parametrize("engine", ["rct", "mean-shift", "frames"])
def test_memory_does_not_grow_with_the_recording_though_no_record_comes(engine: str) -> None:
    """Noise, of which every second event stays, for 10 s and longer: no tracker sees an object in it."""
    random = np.random.default_rng(5)
    tracker = FilteredTracker(lambda run: run.p > 0, ENGINES[engine].start(QUIET[engine], FilterConfig(), SENSOR))
    held: list[int] = []
    for second in range(20):
        n = 2_000
        t_us = np.sort(random.integers(0, 1_000_000, n)) + second * 1_000_000
        x, y = random.integers(0, SENSOR[0], n).astype(np.uint16), random.integers(0, SENSOR[1], n).astype(np.uint16)
        for begin in range(0, n, 100):
            part = slice(begin, begin + 100)
            run = Events(t_us[part], x[part], y[part], np.arange(100, dtype=np.uint8) % 2)
            told, _ = tracker.feed(run)
            assert len(told) == 0
        held.append(sum(numbers.nbytes for numbers in tracker._kept) + 1_000 * len(tracker._kept))
    assert max(held[10:]) <= max(held[:10]) + 1_000
    assert max(held) < 8 * 1_000 + 20 * 1_000  # less than a second's
    assert tracker.settled > 39_000


class Silent:
    """A tracker whose only record, at the end, refers to the event after all others."""

    def feed(self, events: Events) -> TrackerOutput:
        assert not len(events)
        return np.empty(0, TRACK), np.empty(0, np.int16)

    def finish(self) -> NDArray[np.void]:
        return np.zeros(1, TRACK)

    settled = 0
