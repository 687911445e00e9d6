# SPDX-License-Identifier: Apache-2.0
"""The Rectangular Cluster Tracker: the rules as stories."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import RecordingError
from evcot.events import Recording
from evcot.trackers.rct.config import RctConfig
from evcot.trackers.rct.tracker import RctTracker, track
from evcot.tracks.log import TRACK, Kind

from .stories import events_of, of_kind

SMALL = RctConfig(max_clusters=4, radius_px=10.0, alpha=0.01, visible_events=5, lifetime_us=10_000, packet_us=1_000)


def story(rows: Sequence[tuple[int, int, int]], config: RctConfig) -> tuple[NDArray[np.void], list[int]]:
    """Records and owners of a hand-written stream."""
    log = track(Recording(events_of(rows), 1000, 1000), config)
    return log.records, log.owner.tolist()


def test_an_unclaimed_event_seeds_a_cluster_that_becomes_visible_with_its_fifth_event() -> None:
    records, owner = story([(i, 100, 50) for i in range(5)], SMALL)
    assert owner == [0] * 5
    assert records["kind"].tolist() == [Kind.BORN, Kind.MOVED]
    born = records[0]
    assert (born["t_us"], born["event_index"], born["track_id"], born["slot"]) == (4, 4, 0, 0)
    assert (born["x"], born["y"], born["radius"], born["support"], born["other_id"]) == (100.0, 50.0, 10.0, 5, -1)
    records, owner = story([(i, 100, 50) for i in range(4)], SMALL)
    assert (len(records), owner) == (0, [0] * 4)
    records, _ = story([(7, 100, 50)], replace(SMALL, visible_events=1))
    assert records[["kind", "t_us"]].tolist() == [(Kind.BORN, 7), (Kind.MOVED, 7)]
    records, owner = story([], SMALL)
    assert (records.dtype, len(records), owner) == (TRACK, 0, [])


def test_the_centre_moves_by_equation_7_exactly() -> None:
    xs = [100, 110, 95, 103, 108, 91]
    records, _ = story([(i, x, 50) for i, x in enumerate(xs)], SMALL)
    centre = 100.0
    for x in xs[1:]:
        centre = (1 - 0.01) * centre + 0.01 * x
    assert records[-1]["kind"] == Kind.MOVED
    assert records[-1]["x"] == centre
    assert records[-1]["y"] == (1 - 0.01) * 50.0 + 0.01 * 50.0


@pytest.mark.parametrize(("dx", "dy", "owner"), [(10, 0, 0), (0, -10, 0), (10, -10, 0), (11, 0, 1), (0, -11, 1)])
def test_the_window_is_a_square_and_both_ends_belong_to_it(dx: int, dy: int, owner: int) -> None:
    assert story([(0, 100, 50), (1, 100 + dx, 50 + dy)], SMALL)[1] == [0, owner]


def test_of_two_clusters_that_hold_the_event_the_nearest_takes_it_and_the_first_seeded_takes_a_tie() -> None:
    _, owner = story([(0, 100, 50), (1, 112, 50), (2, 107, 50)], SMALL)
    assert owner == [0, 1, 1]
    _, owner = story([(0, 100, 50), (1, 112, 50), (2, 106, 50)], SMALL)
    assert owner == [0, 1, 0]


def test_an_event_beyond_the_last_slot_passes_through() -> None:
    _, owner = story([(i, 100 * i, 50) for i in range(6)], SMALL)
    assert owner == [0, 1, 2, 3, -1, -1]


def test_a_visible_cluster_moves_once_per_packet_that_brought_it_events() -> None:
    rows = [(100 * i, 100, 50) for i in range(10)] + [(1000 + i, 101, 50) for i in range(3)] + [(3500, 102, 50)]
    records, _ = story(rows, SMALL)
    moved = of_kind(records, Kind.MOVED)
    assert moved["t_us"].tolist() == [900, 1002, 3500]
    assert moved["event_index"].tolist() == [9, 12, 13]
    assert moved["n_ev"].tolist() == [10, 3, 1]
    assert moved["support"].tolist() == [10, 13, 14]


def test_a_silent_cluster_is_lost_a_lifetime_after_its_last_event() -> None:
    rows = [(i, 100, 50) for i in range(5)]
    records, owner = story([*rows, (50_000, 800, 800)], SMALL)
    (lost,) = of_kind(records, Kind.LOST)
    assert (lost["t_us"], lost["event_index"], lost["track_id"], lost["n_ev"]) == (10_004, 5, 0, 0)
    assert owner[5] == 0  # the slot is free again
    records, owner = story([(0, 100, 50), (50_000, 800, 800)], SMALL)
    assert (len(records), owner) == (0, [0, 0])  # an invisible one ends without a word
    for last_us, at in ((10_003, []), (10_004, [5])):  # nothing is lost after the last event
        assert of_kind(story([*rows, (last_us, 800, 800)], SMALL)[0], Kind.LOST)["event_index"].tolist() == at


def test_removal_waits_for_the_end_of_the_packet_and_an_event_until_then_keeps_the_cluster() -> None:
    config = replace(SMALL, packet_us=20_000)
    rows = [(i, 100, 50) for i in range(5)] + [(15_000, 100, 50)]
    records, owner = story([*rows, (19_999, 500, 500), (20_000, 500, 500)], config)
    assert len(of_kind(records, Kind.LOST)) == 0
    assert owner == [0] * 6 + [1, 1]


def test_a_loss_stands_in_the_log_where_its_time_is() -> None:
    config = replace(SMALL, packet_us=20_000)
    first = [(i, 100, 50) for i in range(5)]  # ends at 10 004, in the middle of the packet
    second = [(10_000 + i, 500, 50) for i in range(8)]  # becomes visible with event 9, at 10 004
    records, _ = story([*first, *second, (40_000, 0, 0)], config)
    assert [(r["kind"], r["track_id"], r["t_us"], r["event_index"]) for r in records] == [
        (Kind.BORN, 0, 4, 4),
        (Kind.LOST, 0, 10_004, 9),
        (Kind.BORN, 1, 10_004, 9),
        (Kind.MOVED, 1, 10_007, 12),
        (Kind.LOST, 1, 20_007, 13),
    ]


def test_overlapping_clusters_merge_at_the_mean_weighted_by_their_events() -> None:
    rows = [(i, 100, 50) for i in range(30)] + [(100 + i, 120, 60) for i in range(10)]
    records, owner = story([*rows, (1_000, 110, 50)], SMALL)
    assert records["kind"].tolist() == [Kind.BORN, Kind.BORN, Kind.MERGED, Kind.MOVED, Kind.MOVED]
    merged, moved = records[2], records[3]
    assert (merged["track_id"], merged["other_id"], merged["support"]) == (1, 0, 10)
    assert (merged["t_us"], merged["event_index"]) == (109, 39)
    assert (merged["x"], merged["y"]) == pytest.approx((120.0, 60.0))
    assert (moved["track_id"], moved["other_id"], moved["support"]) == (0, -1, 40)
    assert (moved["x"], moved["y"]) == pytest.approx((105.0, 52.5))
    assert owner[-1] == 0


@pytest.mark.parametrize(("gap_px", "merges"), [(20, 1), (21, 0)])
def test_windows_overlap_when_they_share_a_point(gap_px: int, merges: int) -> None:
    config = replace(SMALL, alpha=0.25)  # a binary fraction: a cluster whose events all agree stands exactly there
    rows = [(i, 100, 50) for i in range(5)] + [(100 + i, 100 + gap_px, 50) for i in range(5)]
    assert len(of_kind(story(rows, config)[0], Kind.MERGED)) == merges


def test_a_visible_cluster_absorbs_an_invisible_one_without_a_record_even_if_that_was_seeded_first() -> None:
    rows = [(0, 100, 50)] + [(1 + i, 115, 50) for i in range(5)]
    records, owner = story([*rows, (1_000, 112, 50)], SMALL)
    assert records["kind"].tolist() == [Kind.BORN, Kind.MOVED, Kind.MOVED]
    assert records["track_id"].tolist() == [0, 0, 0]
    assert records[1]["support"] == 6
    assert records[1]["x"] == pytest.approx(112.5)
    assert owner == [0, 1, 1, 1, 1, 1, 1]


def test_the_cluster_that_became_visible_first_stays_even_if_it_was_seeded_second() -> None:
    rows = [(0, 100, 50)] + [(1 + i, 115, 50) for i in range(5)] + [(10 + i, 100, 50) for i in range(50)]
    (merged,) = of_kind(story(rows, SMALL)[0], Kind.MERGED)
    assert (merged["track_id"], merged["other_id"], merged["slot"]) == (1, 0, 0)


def test_two_invisible_clusters_become_visible_together() -> None:
    rows = [(i, 100, 50) for i in range(3)] + [(10 + i, 115, 50) for i in range(3)]
    records, _ = story(rows, SMALL)
    assert records["kind"].tolist() == [Kind.BORN, Kind.MOVED]
    assert records["support"].tolist() == [6, 6]
    assert records["t_us"].tolist() == [12, 12]


def test_track_ids_are_never_reused_though_slots_are() -> None:
    rows = [(100_000 * life + i, 100, 50) for life in range(4) for i in range(5)]
    records, owner = story(rows, SMALL)
    assert of_kind(records, Kind.BORN)["track_id"].tolist() == [0, 1, 2, 3]
    assert set(owner) == {0}


def test_velocity_is_that_of_the_object() -> None:
    """A point at 200 px/s: once the filters have settled, so says the tracker."""
    events = events_of([(t_us, int(100 + t_us * 200e-6), 50) for t_us in range(0, 2_000_000, 100)])
    tracker = RctTracker(SMALL)
    tracker.feed(events)
    (cluster,) = tracker.clusters()
    assert cluster["velocity_x"] == pytest.approx(200, rel=0.05)
    assert cluster["velocity_y"] == pytest.approx(0, abs=1e-9)
    assert cluster["x"] == pytest.approx(events.x[-1], abs=3)


def test_time_that_runs_back_between_runs_is_refused() -> None:
    tracker = RctTracker(SMALL)
    tracker.feed(events_of([(5, 0, 0), (9, 0, 0)]))
    with pytest.raises(RecordingError, match=r"^event 2: t = 8 us follows t = 9 us: time must not run back$"):
        tracker.feed(events_of([(8, 0, 0)]))


def test_a_small_buffer_is_emptied_as_often_as_needed() -> None:
    """Many packets in one run: more records than the tracker holds at a time."""
    rows = [(1_000 * i, 100, 50) for i in range(20_000)]
    records, _ = story(rows, SMALL)
    assert of_kind(records, Kind.MOVED)["event_index"].tolist() == list(range(4, 20_000))
