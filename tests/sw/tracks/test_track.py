# SPDX-License-Identifier: Apache-2.0
"""Single tracks, and the geometry of their boxes."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.tracks.boxes import box_corners, upright_sides
from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot.tracks.timeline import sample
from evcot.tracks.track import Box, Track
from support.logs import HEIGHT, WIDTH, log_of


@pytest.fixture
def two_meet() -> TrackLog:
    """Track 0 from 10, track 1 from 20; 1 is absorbed at 50; 0 is lost at 90; id 1 is born again at 95."""
    return log_of(
        [
            (10, Kind.BORN, 0, 1.0, 1.0),
            (20, Kind.BORN, 1, 9.0, 9.0),
            (30, Kind.MOVED, 0, 2.0, 2.0),
            (50, Kind.MERGED, 1, 7.0, 7.0, 0),
            (50, Kind.MOVED, 0, 4.0, 4.0),
            (90, Kind.LOST, 0, 4.0, 4.0),
            (95, Kind.BORN, 1, 5.0, 6.0),
        ]
    )


def test_tracks_say_when_and_how_they_ended(two_meet: TrackLog) -> None:
    tracks = two_meet.tracks
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


def test_a_path_has_the_states_of_one_life_without_its_end(two_meet: TrackLog) -> None:
    paths = [track.path[["t_us", "x"]].tolist() for track in two_meet.tracks]
    assert paths == [[(10, 1.0), (30, 2.0), (50, 4.0)], [(20, 9.0)], [(95, 5.0)]]


def test_a_box_holds_until_the_next_state_and_ends_with_the_track(two_meet: TrackLog) -> None:
    first, absorbed, last = two_meet.tracks
    assert [box.x if (box := first.box_at(t_us)) else None for t_us in (9, 10, 29, 30, 50, 89, 90, 95)] == [
        None, 1.0, 1.0, 2.0, 4.0, 4.0, None, None,
    ]  # fmt: skip
    assert absorbed.box_at(49) == Box(9.0, 9.0, WIDTH, HEIGHT, 0.0)
    assert absorbed.box_at(50) is None
    assert last.box_at(10**12) == Box(5.0, 6.0, WIDTH, HEIGHT, 0.0)


def test_a_track_that_is_found_again_is_one_track_without_a_box_in_between() -> None:
    (track,) = log_of(
        [
            (10, Kind.BORN, 4, 1.0, 1.0),
            (30, Kind.LOST, 4, 1.0, 1.0),
            (50, Kind.MOVED, 4, 8.0, 8.0),
            (70, Kind.LOST, 4, 8.0, 8.0),
        ]
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


def test_a_log_without_records_has_no_tracks() -> None:
    assert list(TrackLog.empty("rct").tracks) == []


def test_a_track_that_is_only_an_end_has_no_box(two_meet: TrackLog) -> None:
    (track,) = TrackLog("by hand", two_meet.records[5:6], two_meet.owner).tracks
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
