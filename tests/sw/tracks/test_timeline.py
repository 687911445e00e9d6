# SPDX-License-Identifier: Apache-2.0
"""Lifetimes, samples and merges of hand-made logs, and comparison with a replay of random logs."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.tracks.log import Kind, TrackLog
from evcot.tracks.tally import LifeCounter
from evcot.tracks.timeline import LIFE, MERGE, OPEN, SAMPLE, alive, lifetimes, merges, sample
from support.logs import Row, log_of


@pytest.fixture
def two_meet() -> TrackLog:
    """Track 0 from 10, track 1 from 20; 1 is absorbed at 50; 0 is lost at 90; track 2 is there from 95 on."""
    return log_of(
        [
            (10, Kind.BORN, 0, 1.0, 1.0),
            (20, Kind.BORN, 1, 9.0, 9.0),
            (30, Kind.MOVED, 0, 2.0, 2.0),
            (50, Kind.MERGED, 1, 7.0, 7.0, 0),
            (50, Kind.MOVED, 0, 4.0, 4.0),
            (90, Kind.LOST, 0, 4.0, 4.0),
            (95, Kind.BORN, 2, 5.0, 6.0),
        ]
    )


def test_alive_counts_from_the_birth_on_and_no_longer_at_the_end(two_meet: TrackLog) -> None:
    times = np.array([9, 10, 19, 20, 49, 50, 89, 90, 94, 95, 1000])
    assert alive(two_meet, times).tolist() == [0, 1, 1, 2, 2, 1, 1, 0, 0, 1, 1]


def test_lifetimes_say_how_they_ended(two_meet: TrackLog) -> None:
    lives = lifetimes(two_meet, until_us=120)
    assert lives.dtype == LIFE
    assert lives.tolist() == [(0, 0, 10, 90, Kind.LOST, -1), (1, 1, 20, 50, Kind.MERGED, 0), (2, 2, 95, 120, OPEN, -1)]


def test_a_track_that_was_born_before_the_log_begins_lives_from_its_first_record(two_meet: TrackLog) -> None:
    """Cut after 40: of track 0 there is a move and the end, of track 1 the end alone."""
    cut = TrackLog("by hand", two_meet.records[two_meet.records["t_us"] > 40], two_meet.owner)
    lives = lifetimes(cut, until_us=120)
    assert lives.tolist() == [(1, 1, 50, 50, Kind.MERGED, 0), (0, 0, 50, 90, Kind.LOST, -1), (2, 2, 95, 120, OPEN, -1)]
    assert alive(cut, np.array([49, 50, 89, 90, 95])).tolist() == [0, 1, 1, 0, 1]
    ends = TrackLog("by hand", two_meet.records[5:6], two_meet.owner)
    assert lifetimes(ends, until_us=120).tolist() == [(0, 0, 90, 90, Kind.LOST, -1)]
    assert alive(ends, np.array([89, 90, 91])).tolist() == [0, 0, 0]


@pytest.mark.parametrize("run", [1, 2, 7])
def test_lives_are_counted_in_runs_as_in_the_whole(run: int) -> None:
    rng = np.random.default_rng(3)
    log = log_of([(10 * i, Kind(int(rng.integers(4))), int(rng.integers(5)), 1.0, 1.0, -1) for i in range(300)])
    lives = LifeCounter()
    for begin in range(0, 300, run):
        lives.add(log.records[begin : begin + run])
    assert lives.count == len(lifetimes(log, 0))


def test_an_id_that_is_born_again_is_another_track() -> None:
    log = log_of(
        [
            (10, Kind.BORN, 0, 1.0, 1.0),
            (20, Kind.LOST, 0, 1.0, 1.0),
            (30, Kind.BORN, 0, 5.0, 5.0),
            (40, Kind.MOVED, 0, 5.0, 5.0),
            (50, Kind.LOST, 0, 5.0, 5.0),
            (60, Kind.BORN, 0, 7.0, 7.0),
        ]
    )
    assert lifetimes(log, 99)[["birth_us", "end_us", "ended"]].tolist() == [
        *((10, 20, Kind.LOST), (30, 50, Kind.LOST), (60, 99, OPEN)),
    ]


def test_without_records_nobody_lives() -> None:
    assert len(lifetimes(TrackLog.empty("by hand"), 5)) == 0
    assert alive(TrackLog.empty("by hand"), np.array([0, 5])).tolist() == [0, 0]


def test_a_sample_holds_the_newest_state_of_every_visible_track(two_meet: TrackLog) -> None:
    samples = sample(two_meet, np.array([5, 29, 30, 50, 92, 95]))
    assert samples.dtype == SAMPLE
    assert samples[["sample", "track_id", "x", "y"]].tolist() == [
        (1, 0, 1.0, 1.0),
        (1, 1, 9.0, 9.0),
        (2, 0, 2.0, 2.0),
        (2, 1, 9.0, 9.0),
        (3, 0, 4.0, 4.0),
        (5, 2, 5.0, 6.0),
    ]


def test_a_sample_has_every_field_of_the_state(two_meet: TrackLog) -> None:
    fields = ("radius", "width", "height", "angle", "vx", "vy", "confidence")
    for i, name in enumerate(fields):
        two_meet.records[name] = 10 * i + np.arange(len(two_meet.records))
    (row,) = sample(two_meet, np.array([95]))
    last = len(two_meet.records) - 1
    assert [row[name] for name in fields] == [10 * i + last for i in range(len(fields))]


def test_a_merge_is_where_the_survivor_stands_after_it(two_meet: TrackLog) -> None:
    rows = merges(two_meet)
    assert rows.dtype == MERGE
    assert rows.tolist() == [(50, 1, 0, 4.0, 4.0)]


def test_a_merge_whose_survivor_says_nothing_is_where_the_absorbed_was(two_meet: TrackLog) -> None:
    silent = TrackLog("by hand", np.delete(two_meet.records, 4), two_meet.owner)
    assert merges(silent).tolist() == [(50, 1, 0, 7.0, 7.0)]


def test_an_empty_log_has_nothing() -> None:
    log = TrackLog.empty("rct")
    assert alive(log, np.array([0, 5])).tolist() == [0, 0]
    assert len(lifetimes(log, 0)) == len(sample(log, np.array([0, 5]))) == len(merges(log)) == 0
    assert len(sample(log_of([(10, Kind.BORN, 0, 1.0, 1.0)]), np.empty(0, np.int64))) == 0


def random_log(seed: int) -> tuple[TrackLog, list[dict[int, tuple[float, float]]]]:
    """A random legal log, and the state after each of its records."""
    rng = np.random.default_rng(seed)
    rows: list[Row] = []
    states: list[dict[int, tuple[float, float]]] = []
    live: dict[int, tuple[float, float]] = {}
    t_us = births = 0
    for _ in range(400):
        t_us += int(rng.integers(0, 3))
        x, y = rng.random(2).tolist()
        kind = Kind(rng.choice([Kind.BORN, Kind.MOVED, Kind.MOVED, Kind.MERGED, Kind.LOST]))
        if kind == Kind.BORN or len(live) < 2:
            rows.append((t_us, Kind.BORN, births, x, y))
            live[births] = (x, y)
            births += 1
        else:
            track_id, other_id = rng.choice(list(live), 2, replace=False).tolist()
            rows.append((t_us, kind, track_id, x, y, other_id if kind == Kind.MERGED else -1))
            live[track_id] = (x, y)
            if kind != Kind.MOVED:
                del live[track_id]
        states.append(dict(live))
    return log_of(rows), states


@pytest.mark.parametrize("seed", range(5))
def test_samples_and_counts_are_those_of_a_replay(seed: int) -> None:
    log, states = random_log(seed)
    times = np.arange(-2, int(log.records["t_us"][-1]) + 3)
    samples = sample(log, times)
    counts = alive(log, times)
    for i, time in enumerate(times):
        seen = np.searchsorted(log.records["t_us"], time, "right")
        expected = states[seen - 1] if seen else {}
        rows = samples[samples["sample"] == i]
        assert {int(row["track_id"]): (row["x"], row["y"]) for row in rows} == expected
        assert counts[i] == len(rows) == len(expected)
