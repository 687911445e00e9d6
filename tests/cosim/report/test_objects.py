# SPDX-License-Identifier: Apache-2.0
"""Objects, lifetimes and positions of tracks in the common format of a report."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evcot.events import Events, Recording
from evcot.metrics import GroundTruth
from evcot.metrics.truth import OBJECT
from evcot.tracks.log import Kind, TrackLog
from evcot.tracks.timeline import LIFE
from evcot_cosim.report import Material, Side
from evcot_cosim.report.collect import collect
from evcot_cosim.report.objects import objects_of
from evcot_cosim.report.paths import Paths, log_classes, log_paths, truth_paths
from support.logs import log_of, verdicts_of

LENGTH_US = 1_000_000
SIDE = 10.0


def side(*tracks: tuple[int, int, float]) -> Paths:
    """Tracks that stand still, 10 px wide: begin and end in ms, and x."""
    rows = [(1_000 * ms, kind, i, x, 0) for i, (a, b, x) in enumerate(tracks) for ms, kind in ((a, Kind.BORN), (b, Kind.LOST))]
    paths = log_paths(log_of(sorted(rows, key=lambda row: row[0])), LENGTH_US)
    paths.points["half_width"] = paths.points["half_height"] = SIDE / 2
    return paths


def truth(*objects: tuple[int, int, float]) -> Paths:
    """True objects that stand still, every 40 ms: begin and end in ms, and x."""
    instants_us = np.arange(0, LENGTH_US + 1, 40_000)
    found = [
        (frame, i, x, 0.0) for i, (a, b, x) in enumerate(objects) for frame, at in enumerate(instants_us) if a <= at / 1e3 <= b
    ]
    rows = np.zeros(len(found), OBJECT)
    for name, values in zip(("frame", "object", "x", "y"), zip(*found, strict=True), strict=True):
        rows[name] = values
    rows["width"] = rows["height"] = SIDE
    rows["counted"] = True
    return truth_paths(GroundTruth(instants_us, rows[np.argsort(rows["frame"], kind="stable")], tuple("tuvw"[: len(objects)])))


def numbers(**sides: Paths) -> dict[str, list[int]]:
    return {name: found.tolist() for name, found in objects_of(sides).items()}


def test_all_tracks_that_follow_a_true_object_share_its_number() -> None:
    found = numbers(
        hardware=side((0, 300, 50), (320, 1_000, 52), (100, 900, 150)),
        software=side((0, 1_000, 51), (200, 400, 149)),
        truth=truth((0, 1_000, 50), (80, 1_000, 150)),
    )
    assert found == {"hardware": [1, 2, 1], "software": [1, 2], "truth": [1, 2]}


def test_without_truth_tracks_near_each_other_form_an_object_the_longest_time_first() -> None:
    found = numbers(hardware=side((0, 200, 50), (100, 900, 55)), software=side((50, 1_000, 52)))
    assert found == {"hardware": [1, 2], "software": [2]}


def test_tracks_of_one_side_that_follow_each_other_are_one_object_where_the_other_side_has_one_track() -> None:
    found = numbers(hardware=side((0, 300, 50), (330, 600, 51), (550, 900, 50)), software=side((20, 900, 52)))
    assert found == {"hardware": [1, 2, 1], "software": [1]}, "the second and the third overlap for 50 ms"
    found = numbers(hardware=side((0, 300, 50), (330, 600, 51), (570, 900, 50)), software=side((20, 900, 52)))
    assert found == {"hardware": [1, 1, 1], "software": [1]}


def test_tracks_that_pass_each_other_are_two_objects() -> None:
    still, passing = side((0, 900, 50)), side((0, 900, 300))
    passing = replace(passing, points=np.insert(passing.points, 1, passing.points[[0, 0]]), counts=passing.counts + 2)
    passing.points["t_us"][1:3], passing.points["x"][1] = (400_000, 500_000), 50
    assert numbers(hardware=still, software=passing) == {"hardware": [1], "software": [2]}


@pytest.mark.parametrize(("apart", "together"), [(11.9, True), (12.1, False)])
def test_near_is_up_to_twelve_pixels(apart: float, together: bool) -> None:
    found = numbers(hardware=side((0, 500, 50)), software=side((0, 500, 50 + apart)))
    assert (found["hardware"] == found["software"]) == together


def test_of_large_boxes_near_is_a_share_of_the_smaller_one() -> None:
    one, other = side((0, 500, 50)), side((0, 500, 80))
    assert numbers(hardware=one, software=other)["software"] == [2]
    for large in (one, other):
        large.points["half_width"] = 50
    assert numbers(hardware=one, software=other)["software"] == [1]


@pytest.mark.parametrize(("until_ms", "together"), [(30, False), (60, True)])
def test_a_moment_beside_each_other_makes_no_object(until_ms: int, together: bool) -> None:
    found = numbers(hardware=side((0, 1_000, 50)), software=side((0, until_ms, 50)))
    assert (found["hardware"] == found["software"]) == together


def test_a_track_that_passes_a_true_object_for_less_than_a_quarter_of_its_life_is_not_it() -> None:
    passing = side((0, 1_000, 100))
    passing = replace(passing, points=np.insert(passing.points, 1, passing.points[0]), counts=passing.counts + 1)
    passing.points["t_us"][1], passing.points["x"][0] = 200_000, 50
    assert numbers(hardware=passing, truth=truth((0, 1_000, 50)))["hardware"] == [2]
    passing.points["t_us"][1] = 300_000
    assert numbers(hardware=passing, truth=truth((0, 1_000, 50)))["hardware"] == [1]


def test_a_track_beside_one_of_a_true_object_is_another_object() -> None:
    found = numbers(
        hardware=side((0, 1_000, 50), (500, 700, 300)),
        software=side((0, 1_000, 50), (500, 700, 300)),
        truth=truth((0, 1_000, 50)),
    )
    assert found == {"hardware": [1, 2], "software": [1, 2], "truth": [1]}


def test_a_third_engine_joins_the_objects_of_the_first_two() -> None:
    found = numbers(hardware=side((0, 900, 50)), software=side((0, 900, 100)), frames=side((0, 900, 101), (100, 900, 300)))
    assert found == {"hardware": [1], "software": [2], "frames": [2, 3]}


def test_objects_are_numbered_in_the_order_in_which_they_appear() -> None:
    found = numbers(hardware=side((300, 900, 50), (400, 900, 90)), software=side((10, 900, 300)), truth=truth((0, 1_000, 90)))
    assert found == {"hardware": [3, 1], "software": [2], "truth": [1]}


def test_a_moving_true_object_is_between_its_instants() -> None:
    moving = truth((0, 900, 50))
    moving.points["x"] = 50 + 80 * np.arange(len(moving.points))  # 80 px in 40 ms
    track = side((0, 1_000, 0))
    times_us = np.arange(0, LENGTH_US, 1_000)
    points = np.repeat(track.points[:1], len(times_us))
    points["t_us"], points["x"] = times_us, 50 + times_us / 500
    track = replace(track, points=points, counts=np.array([len(points)]))
    assert numbers(hardware=track, truth=moving)["hardware"] == [1]


def test_nothing_has_no_object() -> None:
    empty = side()
    assert numbers(hardware=empty, software=empty) == {"hardware": [], "software": []}
    assert numbers() == {}


FOUND_AGAIN = log_of(
    [
        (0, Kind.BORN, 4, 1, 0), (10_000, Kind.MOVED, 4, 2, 0), (15_000, Kind.BORN, 5, 9, 0), (20_000, Kind.LOST, 4, 3, 0),
        (50_000, Kind.MOVED, 4, 7, 0), (60_000, Kind.MERGED, 5, 8, 0, 4), (65_000, Kind.BORN, 6, 8, 0),
        (72_999, Kind.MERGED, 6, 8, 0, 4), (75_000, Kind.MOVED, 4, 8, 0), (80_000, Kind.LOST, 4, 8, 0),
    ]
)  # fmt: skip


def test_each_life_has_its_own_points() -> None:
    paths = log_paths(FOUND_AGAIN, 100_000)
    assert paths.names == ("4", "5", "4")
    assert paths.counts.tolist() == [3, 2, 3]
    assert np.split(paths.points["x"], np.cumsum(paths.counts)[:-1])[2].tolist() == [7, 8, 8]
    assert paths.columns("a", 0)["a.other"].values.tolist() == [-1, 2, -1]


def test_of_many_lives_the_longest_stay_and_the_first_point_of_each() -> None:
    paths = log_paths(FOUND_AGAIN, 100_000, lives_max=2, records_max=0)
    assert paths.names == ("5", "4")
    assert paths.points["t_us"].tolist() == [15_000, 60_000, 50_000, 80_000]


def test_it_is_alive_in_both() -> None:
    t_us = np.arange(0, 100_001, 5_000)
    zeros = np.zeros(len(t_us), np.uint16)
    recording = Recording(Events(t_us, zeros, zeros, zeros.astype(np.uint8)), 16, 16, "by hand")
    log = TrackLog("adaptive", FOUND_AGAIN.records, np.full(len(t_us), -1, np.int16))
    columns = collect(Material(recording, {}, (Side("software", log),), None), 100).columns
    steps = zip(columns["software.alive_t"].values.tolist(), columns["software.alive"].values.tolist(), strict=True)
    assert list(steps) == [(0, 1), (15_000, 2), (20_000, 1), (50_000, 2), (60_000, 1), (80_000, 0)]


def test_a_track_that_merges_at_its_birth_is_counted_only() -> None:
    paths = log_paths(FOUND_AGAIN, 100_000)
    assert (paths.absorbed, paths.all_lives) == (1, 3)


def test_a_true_object_lives_where_it_counts() -> None:
    rows = np.zeros(6, OBJECT)
    rows["frame"], rows["x"], rows["counted"] = np.arange(6), np.arange(6), [1, 1, 0, 1, 1, 1]
    paths = truth_paths(GroundTruth(np.arange(0, 60_000, 10_000), rows, ("car",)))
    assert paths.names == ("car", "car")
    assert paths.lives["birth_us"].tolist() == [0, 30_000]
    assert paths.lives["end_us"].tolist() == [20_000, 50_000]
    assert paths.points["x"].tolist() == [0, 1, 3, 4, 5]


def test_a_life_has_the_class_of_its_last_verdict_and_begins_with_that_of_an_earlier_one() -> None:
    """Track 0 is a 7, again a 7, then none, is lost and found again; track 1 has no verdict; track 2's comes after its end."""
    said = verdicts_of((12_000, 0, 7), (15_000, 0, 7), (18_000, 0, -1), (41_000, 2, 7), (60_000, 0, 3))
    lives = np.zeros(4, LIFE)
    lives["track_id"], lives["birth_us"], lives["end_us"] = (
        (0, 1, 2, 0),
        (10_000, 11_000, 30_000, 50_000),
        (20_000, 90_000, 40_000, 90_000),
    )
    found = log_classes(replace(log_of([]), verdicts=said, class_names={7: "cup"}), lives)
    assert found.labels == ("?", "3", "cup")
    assert found.counts.tolist() == [2, 0, 0, 2]
    assert found.t_us.tolist() == [12_000, 18_000, 50_000, 60_000]
    assert found.label.tolist() == [2, 0, 0, 1]
    assert log_classes(log_of([]), lives).labels == ()
