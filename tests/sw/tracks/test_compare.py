# SPDX-License-Identifier: Apache-2.0
"""Agreement of hand-made logs with known results."""

from __future__ import annotations

import json
import subprocess
import sys
from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError
from evcot.tracks import track_pairs
from evcot.tracks.compare import Comparison, MergePair, TrackPair, compare
from evcot.tracks.log import Kind, TrackLog
from evcot.tracks.timeline import MERGE
from evcot.tracks.track_pairs import best_pairs, closest_pairs, pair_merges
from support import logs

MS = 1_000
EMPTY = TrackLog.empty("rct")
log_of = partial(logs.log_of, unit_us=MS)


# Two objects: the first from 10 to 90 ms, the second from 20 ms until it is absorbed by the first at 50 ms.
HARDWARE = log_of(
    [(10, Kind.BORN, 0, 10.0, 10.0), (20, Kind.BORN, 1, 60.0, 10.0), (50, Kind.MERGED, 1, 60.0, 10.0, 0),
     (50, Kind.MOVED, 0, 35.0, 10.0), (90, Kind.LOST, 0, 35.0, 10.0)]
)  # fmt: skip
# The same, seen 5 ms later and 3 px lower, with the ids in another order and an object of its own at the end.
SOFTWARE = log_of(
    [(15, Kind.BORN, 7, 10.0, 13.0), (25, Kind.BORN, 4, 60.0, 13.0), (55, Kind.MERGED, 4, 60.0, 13.0, 7),
     (55, Kind.MOVED, 7, 35.0, 13.0), (95, Kind.BORN, 9, 200.0, 13.0), (95, Kind.LOST, 7, 35.0, 13.0)]
)  # fmt: skip
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
    times = ((0, Kind.BORN, 0), (40, Kind.LOST, 0), (40, Kind.BORN, 1), (100, Kind.LOST, 1))
    agreement = compare(whole, log_of([(*row, 10.0, 10.0) for row in times]))
    assert agreement.tracks == (TrackPair(0, 1, 60 * MS, 40 * MS, 0, False),)
    assert agreement.tracks_unpaired_software == (0,)
    assert agreement.paired_fraction_hardware == 1.0


def test_clusters_of_different_moments_are_never_paired() -> None:
    early, late = (log_of([(t, Kind.BORN, 0, 0.0, 10.0), (t + 10, Kind.LOST, 0, 0.0, 10.0)]) for t in (0, 10))
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


def every_pairing(left: NDArray[np.int64], right: NDArray[np.int64]) -> list[list[int]]:
    """All sets of pairs in which no element stands twice."""
    pairings: list[list[int]] = [[]]
    for k in range(len(left)):
        pairings += [[*p, k] for p in pairings if all(left[k] != left[q] and right[k] != right[q] for q in p)]
    return pairings


def random_pairs(seed: int) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    rng = np.random.default_rng(seed)
    allowed = rng.permutation(30)[: rng.integers(1, 13)]  # of 6 x 5
    return allowed // 5 + 100, allowed % 5, rng.random(len(allowed))


@pytest.mark.parametrize("seed", range(40))
def test_best_pairs_gain_the_most_and_closest_pairs_are_most_then_cheapest(seed: int) -> None:
    left, right, weight = random_pairs(seed)
    pairings = every_pairing(left, right)
    best, closest = best_pairs(left, right, weight).tolist(), closest_pairs(left, right, weight).tolist()
    assert best in pairings
    assert closest in pairings
    assert weight[best].sum() == pytest.approx(max(weight[p].sum() for p in pairings))
    assert len(closest) == max(len(p) for p in pairings)
    assert weight[closest].sum() == pytest.approx(min(weight[p].sum() for p in pairings if len(p) == len(closest)))


def test_one_close_pair_gives_way_to_two_that_are_farther_apart() -> None:
    left, right, none = np.array([0, 0, 1]), np.array([0, 1, 0]), np.empty(0, np.int64)
    assert closest_pairs(left, right, np.array([0.1, 9.0, 9.0])).tolist() == [1, 2]
    assert best_pairs(left, right, np.array([9.0, 1.0, 1.0])).tolist() == [0]
    assert closest_pairs(np.array([0, 1]), np.array([0, 1]), np.zeros(2)).tolist() == [0, 1], "equal costs of nothing"
    assert len(best_pairs(none, none, np.empty(0))) == len(closest_pairs(none, none, np.empty(0))) == 0


def test_assignment_is_that_of_scipy_without_importing_its_package() -> None:
    program = """
import sys
import numpy as np
from evcot.tracks.track_pairs import assignment
gains = [np.random.default_rng(seed).integers(0, 4, (5, 7)).astype(float) for seed in range(50)]
found = [assignment(gain) for gain in gains]
assert "scipy.optimize" not in sys.modules
from scipy.optimize import linear_sum_assignment
for gain, pairs in zip(gains, found, strict=True):
    np.testing.assert_array_equal(pairs, linear_sum_assignment(gain, maximize=True))
"""
    subprocess.run([sys.executable, "-c", program], check=True)


RADIUS_PX, TOLERANCE_US = 6.0, 500


def random_merges(rng: np.random.Generator, count: int) -> NDArray[np.void]:
    merges = np.zeros(count, MERGE)
    merges["t_us"] = np.sort(rng.integers(0, 100 * count, count))
    merges["track_id"] = rng.permutation(count)
    merges["x"], merges["y"] = rng.random((2, count)) * 12
    return merges


def all_at_once(hw: NDArray[np.void], sw: NDArray[np.void]) -> list[tuple[int, int]]:
    late_us = sw["t_us"] - hw["t_us"][:, None]
    distance_px = np.hypot(sw["x"] - hw["x"][:, None], sw["y"] - hw["y"][:, None])
    i, j = np.nonzero((np.abs(late_us) <= TOLERANCE_US) & (distance_px <= RADIUS_PX))
    chosen = closest_pairs(i, j, np.abs(late_us[i, j]) / TOLERANCE_US + distance_px[i, j] / RADIUS_PX)
    return list(zip(i[chosen].tolist(), j[chosen].tolist(), strict=True))


@pytest.mark.parametrize("run", [1, 7, 1 << 14])
@pytest.mark.parametrize("seed", range(4))
def test_runs_do_not_matter(seed: int, run: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(track_pairs, "_RUN", run)
    rng = np.random.default_rng(seed)
    hw, sw = (random_merges(rng, count) for count in rng.integers(60, 120, 2))
    wanted = all_at_once(hw, sw)
    assert 10 < len(wanted) < min(len(hw), len(sw))
    found = pair_merges(hw, sw, RADIUS_PX, TOLERANCE_US, None)
    assert list(zip(found.pairs["i"].tolist(), found.pairs["j"].tolist(), strict=True)) == wanted
    assert found.count == len(wanted)
    assert found.pairs["hardware_id"].tolist() == [hw["track_id"][i] for i, _ in wanted]
    assert found.pairs["software_id"].tolist() == [sw["track_id"][j] for _, j in wanted]
    assert found.hardware_alone.tolist() == np.delete(hw["track_id"], [i for i, _ in wanted]).tolist()
    assert found.software_alone.tolist() == np.delete(sw["track_id"], [j for _, j in wanted]).tolist()
    first = pair_merges(hw, sw, RADIUS_PX, TOLERANCE_US, 5)
    assert first.count == len(wanted)
    assert np.array_equal(first.pairs, found.pairs[:5])
    assert first.hardware_alone.tolist() == found.hardware_alone[:5].tolist()
    assert first.software_alone.tolist() == found.software_alone[:5].tolist()


def test_a_side_without_merges_leaves_the_other_alone() -> None:
    merges, none = random_merges(np.random.default_rng(1), 9), np.empty(0, MERGE)
    assert pair_merges(none, merges, RADIUS_PX, TOLERANCE_US, None).software_alone.tolist() == merges["track_id"].tolist()
    assert pair_merges(merges, none, RADIUS_PX, TOLERANCE_US, None).hardware_alone.tolist() == merges["track_id"].tolist()


def test_samples_are_taken_from_the_beginning_to_the_end_and_of_a_part_before_the_next() -> None:
    """Every 10 us from 10 us on; the end counts."""
    for end_us, last_us in ((49, 40), (50, 50)):
        comparison = Comparison(10, end_us, step_us=10)
        assert comparison.times_us(10, None).tolist() == list(range(10, last_us + 1, 10))
        assert comparison.times_us(21, None).tolist() == list(range(30, last_us + 1, 10))
    assert comparison.times_us(15, 40).tolist() == [20, 30]
    assert comparison.times_us(20, 41).tolist() == [20, 30, 40]
