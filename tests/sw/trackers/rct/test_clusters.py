# SPDX-License-Identifier: Apache-2.0
"""Size, shape, boxes and merges of clusters."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from evcot.events import Events
from evcot.trackers.rct.config import RctConfig
from evcot.trackers.rct.tracker import RctTracker
from evcot.tracks.log import Kind

from .stories import events_of, kinds, object_at, of_kind, still, together, tracked

BASE = RctConfig(radius_px=10.0, alpha=0.25)


@pytest.mark.parametrize(
    ("share", "gap_px", "merged"),
    [(0.0, 20, 1), (0.0, 21, 0), (0.2, 16, 1), (0.2, 17, 0), (0.44, 11, 1), (0.46, 11, 0), (1.1, 12, 0)],
)
def test_two_merge_that_share_enough_of_the_smaller_window(share: float, gap_px: int, merged: int) -> None:
    """Windows of 20 px, side by side: 20 - gap of 20 is shared; above 1, nothing merges."""
    rows = still(100, 50, 6) + still(100 + gap_px, 50, 6, begin_us=100)
    assert len(of_kind(tracked(events_of(rows), replace(BASE, merge_overlap=share))[0], Kind.MERGED)) == merged


@pytest.mark.parametrize(("rate_hz", "survivor", "x"), [(0.0, 0, 108.2), (100.0, 1, 115.3)])
def test_the_older_stays_or_by_rate_the_one_with_more_events_of_late(rate_hz: float, survivor: int, x: float) -> None:
    """The first had 60 events 40 ms ago and 10 now, the other 59 now; that one drifts into the first one's reach."""
    now_us = 40_000
    rows = [
        *still(100, 50, 60),
        *still(100, 50, 10, now_us),
        *still(121, 50, 30, now_us + 20),
        *still(118, 50, 29, now_us + 1_000),
    ]
    records, _, clusters = tracked(events_of(rows), replace(BASE, visible_rate_hz=rate_hz))
    (merged,) = of_kind(records, Kind.MERGED)
    assert (merged["track_id"], merged["other_id"]) == (1 - survivor, survivor)
    assert clusters["x"] == pytest.approx([x], abs=0.1)


DYNAMIC = RctConfig(radius_px=12.0, max_clusters=1, dynamic_size=True, visible_events=100)
MARGIN = 1.4  # of the window around a filled object


@pytest.mark.parametrize("quantile", [0.0, 0.05, 0.2])
@pytest.mark.parametrize("half", [6.0, 20.0])
def test_a_window_follows_the_size_of_its_object(half: float, quantile: float) -> None:
    (cluster,) = tracked(object_at((200, 200), half=(half, half)), replace(DYNAMIC, box_quantile=quantile))[2]
    assert cluster["half_width"] == cluster["half_height"] == pytest.approx(MARGIN * half, rel=0.15)


def test_the_larger_side_decides_and_the_aspect_stays() -> None:
    (cluster,) = tracked(object_at((200, 200), half=(6, 18)), replace(DYNAMIC, aspect=1.5, radius_px=14.0))[2]
    assert cluster["half_height"] == pytest.approx(MARGIN * 18, rel=0.15)
    assert cluster["half_width"] == pytest.approx(cluster["half_height"] / 1.5)


@pytest.mark.parametrize(("half", "visible_events", "size"), [(1.0, 100, 4.0), (80.0, 100, 48.0), (4.0, 1_000_000, 12.0)])
def test_dynamic_sizes_have_limits_and_an_invisible_cluster_keeps_its_size(
    half: float, visible_events: int, size: float
) -> None:
    config = replace(DYNAMIC, visible_events=visible_events)
    (cluster,) = tracked(object_at((200, 200), half=(half, half)), config)[2]
    assert cluster["half_width"] == pytest.approx(size)


@pytest.mark.parametrize(("y", "scale"), [(250, 0.5), (450, 1.0), (850, 2.0)])
def test_windows_scale_with_the_distance_from_the_vanishing_row(y: int, scale: float) -> None:
    """The row is y = 50; the radius holds 400 px away."""
    tracker = RctTracker(RctConfig(radius_px=16.0, vanishing_y_px=50.0, reference_y_px=450.0))
    tracker.feed(events_of([(0, 300, y)]))
    (cluster,) = tracker.clusters()
    assert cluster["half_width"] == cluster["half_height"] == pytest.approx(16 * scale)


def test_a_window_shrinks_on_the_way_to_the_vanishing_row() -> None:
    events = object_at((300, 450), (0, -300), half=(4, 4))
    config = RctConfig(
        radius_px=16.0, max_clusters=1, alpha=0.1, vanishing_y_px=50.0, reference_y_px=450.0, predict=1.0, path_points=20
    )
    records = tracked(events, config)[0]
    expected = 16 * (records["y"] - 50) / 400
    assert records["radius"][50:] == pytest.approx(expected[50:], rel=0.05)
    assert records["radius"][-1] < 0.3 * records["radius"][50]


PLAIN = RctConfig(radius_px=24.0, max_clusters=1)
BOXED = replace(PLAIN, box_quantile=0.05)


@pytest.mark.parametrize("half", [(5.0, 5.0), (20.0, 6.0), (4.0, 18.0)])
@pytest.mark.parametrize("config", [PLAIN, BOXED, replace(PLAIN, surround=1.5)], ids=["plain", "box", "options"])
def test_the_box_is_the_events_extent_and_not_the_window(half: tuple[float, float], config: RctConfig) -> None:
    """Evenly full: nine tenths of the events lie within nine tenths of each side."""
    records = tracked(object_at((200, 200), half=half), config)[0][-100:]
    assert float(records["width"].mean()) == pytest.approx(0.9 * 2 * half[0], rel=0.15)
    assert float(records["height"].mean()) == pytest.approx(0.9 * 2 * half[1], rel=0.15)
    assert (records["angle"] == 0).all()
    outline = tracked(object_at((200, 200), half=(10, 8), hollow=True), config)[0][-100:]
    assert float(outline["width"].mean()) == pytest.approx(20, abs=2)


def test_the_box_goes_with_a_fast_object() -> None:
    records = tracked(object_at((100, 500), (600, 0), half=(8, 5)), replace(PLAIN, alpha=0.1))[0][-100:]
    assert float(records["width"].mean()) == pytest.approx(0.9 * 16, rel=0.25)
    assert float(records["height"].mean()) == pytest.approx(0.9 * 10, rel=0.25)


def test_a_young_box_grows_quickly_from_one_pixel() -> None:
    """After a millisecond with 20 events it is more than half as large as the object."""
    records = tracked(object_at((200, 200), half=(12, 12)), PLAIN)[0]
    first = of_kind(records, Kind.MOVED)[1]
    assert min(first["width"], first["height"]) > 12
    records = tracked(events_of(still(50, 60, n=40, step_us=100)), PLAIN)[0]
    assert set(records["width"]) == set(records["height"]) == {1.0}


def test_the_velocity_is_0_until_it_is_known_and_then_the_clusters() -> None:
    records, _, (cluster,) = tracked(object_at((200, 200), (150, -90), half=(6, 6)), replace(PLAIN, velocity_alpha=0.01))
    assert of_kind(records, Kind.BORN)[["vx", "vy"]].tolist() == [(0.0, 0.0)]
    assert records[-1][["vx", "vy"]].item() == cluster[["velocity_x", "velocity_y"]].item()
    assert records[-1]["vx"] == pytest.approx(150, abs=15)


def test_the_merged_box_covers_both_within_the_window() -> None:
    """40 px apart, half the sides of the windows are 22 px."""
    parts = object_at((200, 200), half=(3, 3)), object_at((240, 200), half=(3, 3), us=(100_000, 1_000_000), seed=2)
    config = RctConfig(radius_px=22.0, merge_overlap=0.0, max_clusters=2)
    records = tracked(together(*parts), config)[0]
    merged = of_kind(records, Kind.MERGED)[0]
    after = records[(records["event_index"] == merged["event_index"]) & (records["kind"] == Kind.MOVED)]
    assert after["width"].tolist() == pytest.approx([44.0])
    assert after["height"][0] < 12


def test_confidence_is_one_half_where_a_cluster_becomes_visible_and_rises() -> None:
    confidence = tracked(object_at((200, 200), rate_hz=100_000), replace(PLAIN, visible_events=40))[0]["confidence"]
    assert confidence[0] == 0.5
    assert (np.diff(confidence) >= 0).all()
    assert 0.95 < confidence[-1] < 1


def test_confidence_by_rate_falls_with_the_rate() -> None:
    rates = (40_000.0, 4_000.0)
    parts = [object_at((200, 200), us=(i * 400_000, (i + 1) * 400_000), rate_hz=r, seed=i) for i, r in enumerate(rates)]
    config = replace(PLAIN, visible_rate_hz=4_000.0)
    records = tracked(together(*parts), config)[0]
    high, low = (
        float(records["confidence"][(records["t_us"] > b) & (records["t_us"] < b + 200_000)].mean()) for b in (2e5, 6e5)
    )
    assert high == pytest.approx(40 / 44, abs=0.03)
    assert low == pytest.approx(0.5, abs=0.05)


VISIBLE_PLAIN = RctConfig(radius_px=12.0, lifetime_us=20_000, packet_us=1_000)
RATE = replace(VISIBLE_PLAIN, visible_rate_hz=5_000.0)  # a mass of 50


def test_a_steady_rate_becomes_visible_at_its_rate_and_hides_below_the_share() -> None:
    """10, 30, 10 and 2 events/ms: above 20 it is visible, and stays visible until it falls below 4."""
    rates = (10_000, 30_000, 10_000, 2_000)
    parts = [object_at((100, 100), us=(i * 200_000, (i + 1) * 200_000), rate_hz=r, seed=i) for i, r in enumerate(rates)]
    config = replace(VISIBLE_PLAIN, visible_rate_hz=20_000.0)
    records = tracked(together(*parts), config)[0]
    (born,), (lost,) = of_kind(records, Kind.BORN), of_kind(records, Kind.LOST)
    assert 200_000 < born["t_us"] < 300_000
    assert 600_000 < lost["t_us"] < 700_000
    assert records["t_us"].max() == lost["t_us"]


def test_a_rate_shows_and_hides_with_hysteresis() -> None:
    rows = [*still(100, 100, 60), *still(100, 100, 2, begin_us=4_000), *still(100, 100, 1, begin_us=22_000)]
    records = tracked(events_of([*rows, (24_500, 100, 100)]), replace(RATE, lifetime_us=50_000))[0]
    assert kinds(records)[0] == Kind.BORN
    (lost,) = of_kind(records, Kind.LOST)
    mass, packets = 60 * math.exp(-4 / 10) + 2, 5  # at 5 ms
    while mass >= 10:
        mass, packets = mass * math.exp(-1 / 10), packets + 1
    assert (lost["t_us"], lost["event_index"]) == (1_000 * packets, 62)


def test_what_was_hidden_comes_back_as_another_track_and_what_was_invisible_is_never_lost() -> None:
    rows = [*still(100, 100, 60), *still(100, 100, 1, begin_us=19_500), *still(100, 100, 60, begin_us=25_000), (27_000, 9, 9)]
    records = tracked(events_of(rows), RATE)[0]
    assert of_kind(records, Kind.BORN)["track_id"].tolist() == [0, 1]
    assert of_kind(records, Kind.LOST)["track_id"].tolist() == [0]
    invisible = [*still(100, 100, 20), (30_000, 500, 500), (60_000, 500, 500)]
    assert len(tracked(events_of(invisible), RATE)[0]) == 0


def test_a_hot_pixel_is_no_cluster_where_spread_is_asked_for() -> None:
    hot = still(300, 300, 5_000, step_us=100)
    car = object_at((100, 100), half=(5, 5), us=(0, 500_000))
    events = together(events_of(hot), car)
    config = replace(VISIBLE_PLAIN, birth_spread_px=1.5)
    places = [tuple(born[["x", "y"]].tolist()) for born in of_kind(tracked(events, VISIBLE_PLAIN)[0], Kind.BORN)]
    assert any(math.dist(place, (300, 300)) < 5 for place in places)
    (born,) = of_kind(tracked(events, config)[0], Kind.BORN)
    assert math.dist(born[["x", "y"]].tolist(), (100, 100)) < 8


def test_spread_is_judged_again_after_every_packet() -> None:
    rows = [*still(100, 100, 50), *[(2_000 + i, 100 + 8 * (-1) ** i, 100) for i in range(200)], (4_000, 100, 100)]
    records = tracked(events_of(rows), replace(VISIBLE_PLAIN, birth_spread_px=3.0))[0]
    assert kinds(records)[:2] == [Kind.BORN, Kind.MOVED]
    assert 2_000 <= records["t_us"][0] < 3_000


class TestOcclusion:
    """An object at 300 px/s is hidden from 300 to 400 ms, for 30 px."""

    HIDDEN = (300_000, 400_000)
    CONFIG = replace(
        VISIBLE_PLAIN, radius_px=10.0, path_points=30, predict=1.0, lifetime_us=10_000, alpha=0.05,
        coast_us=150_000,
    )  # fmt: skip

    def passing(self, bend_px: float = 0.0) -> Events:
        before = object_at((100, 300), (300, 0), half=(5, 5), us=(0, self.HIDDEN[0]))
        after = object_at((100, 300 + bend_px), (300, 0), half=(5, 5), us=(self.HIDDEN[1], 700_000), seed=2)
        clock = object_at((800, 800), half=(2, 2), us=(0, 700_000), rate_hz=5_000, seed=3)  # time goes on
        return together(before, after, clock)

    def ids(self, config: RctConfig, bend_px: float = 0.0) -> list[int]:
        """Tracks that the passing object had."""
        records = tracked(self.passing(bend_px), config)[0]
        return sorted(set(records["track_id"][records["x"] < 700].tolist()))

    def test_it_moves_on_in_the_log_and_is_not_lost(self) -> None:
        records = tracked(self.passing(), self.CONFIG)[0]
        assert len(of_kind(records, Kind.LOST)) == 0
        own = records[(records["x"] < 700) & (records["t_us"] > 315_000) & (records["t_us"] < 395_000)]
        assert len(own) > 50
        assert (own["n_ev"] == 0).all()
        assert own["x"] == pytest.approx(100 + 300e-6 * own["t_us"], abs=6)

    @pytest.mark.parametrize(
        ("coast_us", "bend_px", "tracks"), [(0, 0, 2), (150_000, 0, 1), (150_000, 17, 1), (150_000, 30, 2)]
    )
    def test_a_coasting_cluster_or_a_new_one_near_its_predicted_place_goes_on_with_the_track(
        self, coast_us: int, bend_px: float, tracks: int
    ) -> None:
        """It comes back beside its way: outside the coasting window of 10 px, within and outside the reach of 20 px."""
        assert len(self.ids(replace(self.CONFIG, coast_us=coast_us), bend_px)) == tracks

    def test_it_is_lost_when_it_has_coasted_for_long_enough(self) -> None:
        records = tracked(self.passing(), replace(self.CONFIG, coast_us=50_000))[0]
        (lost,) = of_kind(records, Kind.LOST)
        assert lost["t_us"] == pytest.approx(300_000 + 10_000 + 50_000, abs=1_000)
        assert np.unique(records["track_id"]).tolist() == [0, 1, 2]
