# SPDX-License-Identifier: Apache-2.0
"""Lifetimes, samples, merges and single tracks of hand-made logs, and comparison with a replay of random logs."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot.tracks.record import box_corners, upright_sides
from evcot.tracks.tally import LifeCounter
from evcot.tracks.timeline import LIFE, MERGE, OPEN, SAMPLE, alive, lifetimes, merges, sample
from evcot.tracks.track import Box, Track
from support.logs import HEIGHT, WIDTH, Row, log_of


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
    kinds = (Kind.BORN, Kind.LOST, Kind.BORN, Kind.MOVED, Kind.LOST, Kind.BORN)
    lives = lifetimes(log_of([(10 * i, kind, 0, 1.0, 1.0) for i, kind in enumerate(kinds, 1)]), 99)
    expected = [(10, 20, Kind.LOST), (30, 50, Kind.LOST), (60, 99, OPEN)]
    assert lives[["birth_us", "end_us", "ended"]].tolist() == expected


def test_a_sample_holds_the_newest_state_of_every_visible_track(two_meet: TrackLog) -> None:
    samples = sample(two_meet, np.array([5, 29, 30, 50, 92, 95]))
    assert samples.dtype == SAMPLE
    assert samples[["sample", "track_id", "x", "y"]].tolist() == [
        *((1, 0, 1.0, 1.0), (1, 1, 9.0, 9.0), (2, 0, 2.0, 2.0), (2, 1, 9.0, 9.0), (3, 0, 4.0, 4.0), (5, 2, 5.0, 6.0))
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
    assert len(lifetimes(log, 0)) == len(sample(log, np.array([0, 5]))) == len(merges(log)) == len(log.tracks) == 0
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


@pytest.fixture
def born_again(two_meet: TrackLog) -> TrackLog:
    """The same, but at 95 id 1 is born again."""
    two_meet.records["track_id"][-1] = 1
    return two_meet


def test_tracks_say_when_and_how_they_ended(born_again: TrackLog) -> None:
    tracks = born_again.tracks
    found = [(track.id, track.born_us, track.ended_us, track.merged_into) for track in tracks]
    assert found == [(0, 10, 90, None), (1, 20, 50, 0), (1, 95, None, None)]
    assert len(tracks) == 3
    assert repr(tracks) == "<Tracks: 3>"
    assert repr(tracks[1]) == "<Track 1: born at 20 us, ended at 50 us in 0, 1 states>"
    assert repr(tracks[2]) == "<Track 1: born at 95 us, still alive, 1 states>"
    assert [track.born_us for track in tracks[1:]] == [20, 95]
    assert tracks[-1].born_us == 95
    with pytest.raises(IndexError):
        tracks[3]


def test_a_path_has_the_states_of_one_life_without_its_end(born_again: TrackLog) -> None:
    paths = [track.path[["t_us", "x"]].tolist() for track in born_again.tracks]
    assert paths == [[(10, 1.0), (30, 2.0), (50, 4.0)], [(20, 9.0)], [(95, 5.0)]]


def test_a_box_holds_until_the_next_state_and_ends_with_the_track(born_again: TrackLog) -> None:
    first, absorbed, last = born_again.tracks
    assert [box.x if (box := first.box_at(t_us)) else None for t_us in (9, 10, 29, 30, 50, 89, 90, 95)] == [
        None, 1.0, 1.0, 2.0, 4.0, 4.0, None, None,
    ]  # fmt: skip
    assert absorbed.box_at(49) == Box(9.0, 9.0, WIDTH, HEIGHT, 0.0)
    assert absorbed.box_at(50) is None
    assert last.box_at(10**12) == Box(5.0, 6.0, WIDTH, HEIGHT, 0.0)


def test_a_track_that_is_found_again_is_one_track_without_a_box_in_between() -> None:
    kinds = (Kind.BORN, Kind.LOST, Kind.MOVED, Kind.LOST)
    (track,) = log_of(
        [(t, kind, 4, x, x) for t, kind, x in zip((10, 30, 50, 70), kinds, (1.0, 1.0, 8.0, 8.0), strict=True)]
    ).tracks
    assert (track.born_us, track.ended_us, track.path["t_us"].tolist()) == (10, 70, [10, 50])
    assert [box.x if (box := track.box_at(t_us)) else None for t_us in (29, 30, 49, 50, 70)] == [1.0, None, None, 8.0, None]


def test_boxes_are_those_of_sample() -> None:
    rng = np.random.default_rng(7)
    rows = [(3 * i, Kind(int(rng.integers(4))), int(rng.integers(6)), *rng.uniform(0, 99, 2).tolist(), -1) for i in range(400)]
    log = log_of(rows)
    times_us = np.arange(-3, 1_210, 7)
    wanted = sample(log, times_us)
    for at, t_us in enumerate(times_us.tolist()):
        # Of an id that is born again without an end, `sample` has the newer life alone.
        newest = {track.id: track for track in log.tracks if track.born_us <= t_us}
        boxes = {name: box for name, track in newest.items() if (box := track.box_at(t_us)) is not None}
        own = wanted[wanted["sample"] == at]
        assert boxes == {int(row["track_id"]): Box(*(float(row[name]) for name in Box._fields)) for row in own}


def test_a_track_that_is_only_an_end_has_no_box(born_again: TrackLog) -> None:
    (track,) = TrackLog("by hand", born_again.records[5:6], born_again.owner).tracks
    assert isinstance(track, Track)
    assert (track.born_us, track.ended_us, len(track.path), track.box_at(90)) == (90, 90, 0, None)
    assert repr(track) == "<Track 0: born at 90 us, ended at 90 us, 0 states>"


def boxes(*rows: tuple[float, float, float, float, float]) -> np.ndarray:  # type: ignore[type-arg]
    """(x, y, width, height, angle) of records."""
    made = np.zeros(len(rows), TRACK)
    for name, column in zip(("x", "y", "width", "height", "angle"), zip(*rows, strict=True), strict=True):
        made[name] = column
    return made


def test_an_upright_box_has_its_own_sides_exactly() -> None:
    width, height = upright_sides(boxes((0, 0, 0.1, 7.3, 0)))
    assert (width.tolist(), height.tolist()) == ([0.1], [7.3])


def test_a_turned_box_needs_room_for_its_corners() -> None:
    made = boxes((5, 6, 6, 8, 0), (5, 6, 6, 8, np.pi / 2), (5, 6, 6, 8, -np.pi / 6), (5, 6, 6, 8, np.pi / 3))
    width, height = upright_sides(made)
    np.testing.assert_allclose(width, [6, 8, 3 * 3**0.5 + 4, 3 + 4 * 3**0.5])
    np.testing.assert_allclose(height, [8, 6, 3 + 4 * 3**0.5, 3 * 3**0.5 + 4])
    corners = box_corners(made)
    np.testing.assert_allclose(np.ptp(corners[..., 0], axis=1), width)
    np.testing.assert_allclose(np.ptp(corners[..., 1], axis=1), height)


def test_corners_go_round_from_the_upper_left_and_angles_turn_from_x_towards_y() -> None:
    upright, turned = box_corners(boxes((10, 20, 4, 2, 0), (10, 20, 4, 2, np.pi / 2)))
    assert upright.tolist() == [[8, 19], [12, 19], [12, 21], [8, 21]]
    assert turned.tolist() == [pytest.approx(corner) for corner in ([11, 18], [11, 22], [9, 22], [9, 18])]
