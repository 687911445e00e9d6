# SPDX-License-Identifier: Apache-2.0
"""Agreement of hand-made logs with known results."""

from __future__ import annotations

import json
from functools import partial

import pytest

from evcot.errors import ConfigError
from evcot.tracks.compare import MergePair, TrackPair, compare
from evcot.tracks.log import Kind, TrackLog
from support import logs

MS = 1_000
EMPTY = TrackLog.empty("rct")
log_of = partial(logs.log_of, unit_us=MS)


# Two objects: the first from 10 to 90 ms, the second from 20 ms until it is absorbed by the first at 50 ms.
HARDWARE = log_of(
    [
        (10, Kind.BORN, 0, 10.0, 10.0),
        (20, Kind.BORN, 1, 60.0, 10.0),
        (50, Kind.MERGED, 1, 60.0, 10.0, 0),
        (50, Kind.MOVED, 0, 35.0, 10.0),
        (90, Kind.LOST, 0, 35.0, 10.0),
    ]
)
# The same, seen 5 ms later and 3 px lower, with the ids in another order and an object of its own at the end.
SOFTWARE = log_of(
    [
        (15, Kind.BORN, 7, 10.0, 13.0),
        (25, Kind.BORN, 4, 60.0, 13.0),
        (55, Kind.MERGED, 4, 60.0, 13.0, 7),
        (55, Kind.MOVED, 7, 35.0, 13.0),
        (95, Kind.BORN, 9, 200.0, 13.0),
        (95, Kind.LOST, 7, 35.0, 13.0),
    ]
)
SPAN = (0, 99 * MS)


def test_a_log_agrees_with_itself() -> None:
    same = compare(HARDWARE, HARDWARE, span_us=SPAN)
    assert same.samples == 100
    assert same.alive_equal_fraction == 1.0
    assert same.alive_mean_difference == 0.0
    assert same.alive_mean_hardware == same.alive_mean_software == pytest.approx((80 + 30) / 100)
    assert same.distance_median_px == same.distance_p90_px == 0.0
    assert same.paired_fraction_hardware == same.paired_fraction_software == 1.0
    assert same.tracks == (TrackPair(0, 0, 80 * MS, 0, 0, True), TrackPair(1, 1, 30 * MS, 0, 0, True))
    assert same.tracks_corresponding == same.tracks_hardware == same.tracks_software == 2
    assert same.merges == (MergePair(1, 1, 0, 0.0),)
    assert same.tracks_unpaired_hardware == same.tracks_unpaired_software == ()
    assert same.merges_unpaired_hardware == same.merges_unpaired_software == ()


def test_a_track_that_is_found_again_is_one_track() -> None:
    found_again = log_of(
        [
            (10, Kind.BORN, 3, 10.0, 10.0), (30, Kind.LOST, 3, 10.0, 10.0), (40, Kind.MOVED, 3, 10.0, 10.0),
            (60, Kind.LOST, 3, 10.0, 10.0), (70, Kind.MOVED, 3, 10.0, 10.0), (90, Kind.LOST, 3, 10.0, 10.0),
        ]
    )  # fmt: skip
    found = compare(log_of([(10, Kind.BORN, 0, 10.0, 10.0), (90, Kind.LOST, 0, 10.0, 10.0)]), found_again, span_us=SPAN)
    assert found.tracks == (TrackPair(0, 3, 60 * MS, 0, 0, True),)
    assert (found.tracks_software, found.tracks_unpaired_software) == (1, ())
    assert found.alive_mean_software == pytest.approx(0.6)
    born_anew = found_again.records.copy()  # as with narrow ids in hardware: other tracks
    born_anew["kind"][[2, 4]] = Kind.BORN
    assert compare(EMPTY, TrackLog("rct", born_anew, found_again.owner), span_us=SPAN).tracks_software == 3


def test_the_same_story_told_a_little_later() -> None:
    agreement = compare(HARDWARE, SOFTWARE, span_us=SPAN, radius_px=10.0, tolerance_us=5 * MS)
    # The counts differ by one in [10, 15), [20, 25), [50, 55), [90, 95) and [95, 100).
    assert agreement.alive_equal_fraction == pytest.approx(0.75)
    assert agreement.alive_mean_difference == pytest.approx(0.25)
    # Pairs: track 0 from 15 to 50 and 55 to 90, track 1 from 25 to 50; from 50 to 55 nobody is near anybody.
    assert agreement.distance_median_px == agreement.distance_p90_px == 3.0
    assert agreement.paired_fraction_hardware == pytest.approx(95 / (80 + 30))
    assert agreement.paired_fraction_software == pytest.approx(95 / (80 + 30 + 5))
    assert agreement.tracks == (
        TrackPair(0, 7, 70 * MS, 5 * MS, 5 * MS, True),
        TrackPair(1, 4, 25 * MS, 5 * MS, 5 * MS, True),
    )
    assert (agreement.tracks_hardware, agreement.tracks_software, agreement.tracks_corresponding) == (2, 3, 2)
    assert agreement.tracks_unpaired_software == (9,)
    assert agreement.merges == (MergePair(1, 4, 5 * MS, 3.0),)
    assert (agreement.merges_comparable_hardware, agreement.merges_comparable_software) == (1, 1)


def test_merges_that_agree_are_comparable_however_short_their_tracks() -> None:
    here = log_of([(0, Kind.BORN, 0, 50.0, 50.0), (10.2, Kind.BORN, 1, 50.0, 50.0), (10.4, Kind.MERGED, 1, 50.0, 50.0, 0)])
    there = log_of([(0, Kind.BORN, 5, 50.0, 50.0), (20.2, Kind.BORN, 6, 50.0, 50.0), (20.4, Kind.MERGED, 6, 50.0, 50.0, 5)])
    near, far = (compare(here, there, span_us=SPAN, tolerance_us=tolerance) for tolerance in (11 * MS, 5 * MS))
    assert near.tracks_paired == 1
    assert (near.merges_paired, near.merges_comparable_hardware, near.merges_comparable_software) == (1, 1, 1)
    assert (far.merges_paired, far.merges_comparable_hardware, far.merges_comparable_software) == (0, 0, 0)


def test_a_tighter_tolerance_parts_lives_and_merges_but_not_pairs() -> None:
    agreement = compare(HARDWARE, SOFTWARE, span_us=SPAN, radius_px=10.0, tolerance_us=5 * MS - 1)
    assert [(pair.hardware_id, pair.software_id, pair.corresponds) for pair in agreement.tracks] == [
        (0, 7, False),
        (1, 4, False),
    ]
    assert agreement.tracks_corresponding == 0
    assert agreement.merges == ()
    assert (agreement.merges_unpaired_hardware, agreement.merges_unpaired_software) == ((1,), (4,))
    assert (agreement.merges_hardware, agreement.merges_software) == (1, 1)


@pytest.mark.parametrize(("radius_px", "paired"), [(3.0, True), (2.99, False)])
def test_the_radius_gates_clusters_and_merges(radius_px: float, paired: bool) -> None:
    agreement = compare(HARDWARE, SOFTWARE, span_us=SPAN, radius_px=radius_px)
    assert bool(agreement.tracks) == bool(agreement.merges) == paired
    assert (agreement.distance_median_px == 3.0) == paired
    assert agreement.paired_fraction_hardware == (pytest.approx(95 / 110) if paired else 0.0)
    comparable = int(paired)  # a track without a partner cannot merge on the other side
    assert (agreement.merges_comparable_hardware, agreement.merges_comparable_software) == (comparable, comparable)
    if not paired:
        assert agreement.tracks_unpaired_hardware == (0, 1)
        assert agreement.tracks_unpaired_software == (7, 4, 9)


def test_a_pair_may_be_just_the_radius_apart_along_either_axis() -> None:
    here = log_of([(0, Kind.BORN, 0, 50.0, 50.0), (10, Kind.LOST, 0, 50.0, 50.0)])
    for x, y in ((58.0, 50.0), (42.0, 50.0), (50.0, 58.0), (50.0, 42.0)):
        there = log_of([(0, Kind.BORN, 0, x, y), (10, Kind.LOST, 0, x, y)])
        assert compare(here, there, radius_px=8.0).paired_fraction_hardware == 1.0
        assert compare(here, there, radius_px=7.99).paired_fraction_hardware == 0.0


def test_tracks_come_in_order_of_birth_whatever_their_ids() -> None:
    pairs = compare(SOFTWARE, HARDWARE, span_us=SPAN).tracks
    assert [(pair.hardware_id, pair.software_id) for pair in pairs] == [(7, 0), (4, 1)]


def test_of_merges_in_one_place_those_nearest_in_time_correspond() -> None:
    def merges_at(times_ms: tuple[int, ...]) -> TrackLog:
        births = [(0, Kind.BORN, i, 5.0, 5.0) for i in range(len(times_ms))]
        return log_of([*births, *((t_ms, Kind.MERGED, i, 5.0, 5.0, 99) for i, t_ms in enumerate(times_ms))])

    agreement = compare(merges_at((0, 10, 20)), merges_at((12, 22)), tolerance_us=25 * MS, span_us=SPAN)
    assert agreement.merges == (MergePair(1, 0, 2 * MS, 0.0), MergePair(2, 1, 2 * MS, 0.0))
    assert agreement.merges_unpaired_hardware == (0,)


def test_an_end_that_only_one_side_saw_does_not_correspond() -> None:
    still_there = TrackLog("by hand", HARDWARE.records[:-1], HARDWARE.owner)
    agreement = compare(HARDWARE, still_there, span_us=(0, 200 * MS), tolerance_us=5 * MS)
    assert agreement.tracks[0] == TrackPair(0, 0, 80 * MS, 0, 110 * MS, False)


def test_tracks_pair_by_their_time_together_and_each_only_once() -> None:
    """One long hardware track, which software saw as two: the longer part is its partner."""
    whole = log_of([(0, Kind.BORN, 0, 10.0, 10.0), (100, Kind.LOST, 0, 10.0, 10.0)])
    parts = log_of(
        [
            (0, Kind.BORN, 0, 10.0, 10.0),
            (40, Kind.LOST, 0, 10.0, 10.0),
            (40, Kind.BORN, 1, 10.0, 10.0),
            (100, Kind.LOST, 1, 10.0, 10.0),
        ]
    )
    agreement = compare(whole, parts)
    assert agreement.tracks == (TrackPair(0, 1, 60 * MS, 40 * MS, 0, False),)
    assert agreement.tracks_unpaired_software == (0,)
    assert agreement.paired_fraction_hardware == 1.0


def test_clusters_of_different_moments_are_never_paired() -> None:
    early = log_of([(0, Kind.BORN, 0, 0.0, 10.0), (10, Kind.LOST, 0, 0.0, 10.0)])
    late = log_of([(10, Kind.BORN, 0, 0.0, 10.0), (20, Kind.LOST, 0, 0.0, 10.0)])
    agreement = compare(early, late, radius_px=1000.0)
    assert agreement.paired_fraction_hardware == agreement.paired_fraction_software == 0.0
    assert agreement.distance_median_px is None


def test_empty_logs_have_null_and_not_nan() -> None:
    nothing = compare(EMPTY, EMPTY)
    assert nothing.samples == 0
    text = json.dumps(nothing.to_dict(), allow_nan=False)
    assert json.loads(text)["alive_equal_fraction"] is None
    assert json.loads(text)["distance_median_px"] is None
    assert json.loads(text)["tracks"] == []

    silent = compare(EMPTY, EMPTY, span_us=(0, 10 * MS))
    assert (silent.samples, silent.alive_equal_fraction, silent.alive_mean_hardware) == (11, 1.0, 0.0)
    assert silent.paired_fraction_hardware is None


def test_one_empty_log() -> None:
    for hardware, software in ((HARDWARE, EMPTY), (EMPTY, HARDWARE)):
        agreement = compare(hardware, software)
        json.dumps(agreement.to_dict(), allow_nan=False)
        assert not agreement.tracks
        assert not agreement.merges
        assert {agreement.tracks_unpaired_hardware, agreement.tracks_unpaired_software} == {(0, 1), ()}
        assert {agreement.paired_fraction_hardware, agreement.paired_fraction_software} == {0.0, None}


def test_the_clock_spans_both_logs_and_stays_coarse_enough() -> None:
    agreement = compare(HARDWARE, SOFTWARE)
    assert (agreement.begin_us, agreement.end_us, agreement.step_us) == (10 * MS, 95 * MS, 1 * MS)
    hour = log_of([(0, Kind.BORN, 0, 1.0, 1.0), (3_600_000, Kind.LOST, 0, 1.0, 1.0)])
    assert compare(hour, hour).step_us == 180 * MS
    assert compare(hour, hour).samples == 20_001


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"step_us": 0}, r"^compare\.step_us = 0: must be from 1 to 1000000000000$"),
        ({"tolerance_us": -1}, r"^compare\.tolerance_us = -1: must be from 0 "),
        ({"radius_px": float("nan")}, r"^compare\.radius_px = nan: must be from 0 "),
        ({"span_us": (5, 4)}, r"^compare\.span_us = \(5, 4\): must not end before it begins$"),
    ],
)
def test_values_outside_their_range_are_refused(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        compare(EMPTY, EMPTY, **arguments)  # type: ignore[arg-type]
