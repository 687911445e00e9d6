# SPDX-License-Identifier: Apache-2.0
"""A log of another recording is detected by its digest, or without one by its owners and its records' positions and times."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from evcot.digest import EventsDigest, digest
from evcot.errors import TrackLogError
from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.scenes.registry import simulate_scene
from evcot.trackers.engines import ENGINES
from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot.tracks.log_files import Extent, check_belongs
from evcot.tracks.tracking import log_of


@cache
def scene() -> Recording:
    return simulate_scene("discs", 3, {"duration_us": 100_000}).recording


def make_events(count: int, first_us: int = 100) -> Events:
    return Events(first_us + np.arange(count), *(np.arange(count, dtype=np.uint16),) * 2, np.zeros(count, np.uint8))


def make_log(events: Events) -> TrackLog:
    """A track that is born with the first event, and moves with the last."""
    records = np.zeros(2, TRACK)
    records["kind"] = Kind.BORN, Kind.MOVED
    records["event_index"] = 0, len(events) - 1
    records["t_us"] = events.t_us[[0, -1]]
    return TrackLog("rct", records, np.zeros(len(events), np.int16))


def test_a_log_belongs_to_its_events() -> None:
    events = make_events(10)
    check_belongs(make_log(events), Extent.of([events[:3], events[3:3], events[3:]]))
    check_belongs(replace(make_log(events), recording=digest(events)), Extent.of([events]))
    check_belongs(TrackLog.empty("rct"), Extent.of([]))


@pytest.mark.parametrize(
    ("of", "message"),
    [
        (make_events(11), "owner has 10 entries: must be one for each of the recording's 11 events"),
        (make_events(10, 101), "record 0: t_us = 100: must be from 101 to 110, as the recording's events are"),
        (make_events(10, 99), "record 1: t_us = 109: must be from 99 to 108, as the recording's events are"),
    ],
)
def test_a_log_of_other_events_is_refused_by_what_it_shows(of: Events, message: str) -> None:
    with pytest.raises(TrackLogError) as caught:
        check_belongs(make_log(make_events(10)), Extent.of([of]))
    assert str(caught.value) == message


@pytest.mark.parametrize("index", [-1, 11])
def test_a_record_of_no_event_is_refused(index: int) -> None:
    events = make_events(10)
    log = make_log(events)
    log.records["event_index"][1] = index
    with pytest.raises(TrackLogError, match=f"record 1: event_index = {index}: must be from 0 to 10"):
        check_belongs(log, Extent.of([events]))


def test_a_digest_tells_apart_what_looks_alike() -> None:
    events = make_events(10)
    other = replace(events, x=events.x[::-1].copy())
    check_belongs(make_log(events), Extent.of([other]))
    with pytest.raises(TrackLogError) as caught:
        check_belongs(replace(make_log(events), recording=digest(events)), Extent.of([other]))
    expected = f"recording = '{digest(events)}': must be the digest of the recording's events, '{digest(other)}'"
    assert str(caught.value) == expected


def test_a_digest_does_not_depend_on_where_blocks_are_cut_but_on_every_column() -> None:
    events, summary = scene().events, EventsDigest()
    for begin in range(0, len(events), 1_013):
        summary.add(events[begin : begin + 1_013])
    assert summary.hex() == digest(events)
    for name in ("t_us", "x", "y", "p"):
        column = getattr(events, name).copy()
        column[-1] ^= 1
        assert digest(replace(events, **{name: column})) != digest(events)


def test_a_stored_log_keeps_the_digest_of_its_recording(tmp_path: Path) -> None:
    log = make_log(make_events(10))
    log.save_npz(tmp_path / "none.npz")
    assert TrackLog.load_npz(tmp_path / "none.npz").recording == ""
    replace(log, recording="0123456789abcdef").save_npz(tmp_path / "one.npz")
    assert TrackLog.load_npz(tmp_path / "one.npz").recording == "0123456789abcdef"


@pytest.mark.parametrize("engine", ENGINES)
def test_every_engines_log_belongs(engine: str) -> None:
    """No record has a time after the recording's end, wherever the recording is cut."""
    kind = ENGINES[engine]
    preset = "discs" if "discs" in kind.presets else next(iter(kind.presets))
    for count in (1, 997, len(scene().events) // 2, len(scene().events)):
        events = scene().events[:count]
        tracker = kind.start(kind.presets[preset], FilterConfig(), (scene().width, scene().height))
        log = log_of(engine, tracker, [events])
        check_belongs(log, Extent.of([events]))
    assert len(log.of_kind(Kind.MOVED)) > 0
