# SPDX-License-Identifier: Apache-2.0
"""When clusters become tracks and cease to be: mass, rate, spread; and what happens while an object is hidden."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from evcot.events import Events
from evcot.trackers.rct.config import RctConfig
from evcot.tracks.log import Kind

from .stories import events_of, kinds, object_at, of_kind, still, together, tracked

PLAIN = RctConfig(radius_px=12.0, lifetime_us=20_000, packet_us=1_000)
RATE = replace(PLAIN, visible_rate_hz=5_000.0)  # a mass of 50


def test_a_steady_rate_becomes_visible_at_its_rate_and_hides_below_the_share() -> None:
    """10, 30, 10 and 2 events/ms: above 20 it is visible, and stays visible until it falls below 4."""
    rates = (10_000, 30_000, 10_000, 2_000)
    parts = [object_at((100, 100), us=(i * 200_000, (i + 1) * 200_000), rate_hz=r, seed=i) for i, r in enumerate(rates)]
    config = replace(PLAIN, visible_rate_hz=20_000.0)
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


def test_what_was_hidden_comes_back_as_another_track() -> None:
    rows = [*still(100, 100, 60), *still(100, 100, 1, begin_us=19_500), *still(100, 100, 60, begin_us=25_000), (27_000, 9, 9)]
    records = tracked(events_of(rows), RATE)[0]
    assert of_kind(records, Kind.BORN)["track_id"].tolist() == [0, 1]
    assert of_kind(records, Kind.LOST)["track_id"].tolist() == [0]


def test_an_invisible_cluster_is_never_lost() -> None:
    rows = [*still(100, 100, 20), (30_000, 500, 500), (60_000, 500, 500)]
    assert len(tracked(events_of(rows), RATE)[0]) == 0


def test_a_hot_pixel_is_no_cluster_where_spread_is_asked_for() -> None:
    hot = still(300, 300, 5_000, step_us=100)
    car = object_at((100, 100), half=(5, 5), us=(0, 500_000))
    events = together(events_of(hot), car)
    config = replace(PLAIN, birth_spread_px=1.5)
    places = [tuple(born[["x", "y"]].tolist()) for born in of_kind(tracked(events, PLAIN)[0], Kind.BORN)]
    assert any(math.dist(place, (300, 300)) < 5 for place in places)
    (born,) = of_kind(tracked(events, config)[0], Kind.BORN)
    assert math.dist(born[["x", "y"]].tolist(), (100, 100)) < 8


def test_spread_is_judged_again_after_every_packet() -> None:
    rows = [*still(100, 100, 50), *[(2_000 + i, 100 + 8 * (-1) ** i, 100) for i in range(200)], (4_000, 100, 100)]
    records = tracked(events_of(rows), replace(PLAIN, birth_spread_px=3.0))[0]
    assert kinds(records)[:2] == [Kind.BORN, Kind.MOVED]
    assert 2_000 <= records["t_us"][0] < 3_000


class TestOcclusion:
    """An object at 300 px/s is hidden from 300 to 400 ms, for 30 px."""

    HIDDEN = (300_000, 400_000)
    CONFIG = replace(
        PLAIN, radius_px=10.0, path_points=30, predict=1.0, lifetime_us=10_000, alpha=0.05,
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

    def test_without_coasting_it_becomes_another_track(self) -> None:
        assert len(self.ids(replace(self.CONFIG, coast_us=0))) == 2

    def test_a_coasting_cluster_meets_its_object_again(self) -> None:
        assert len(self.ids(self.CONFIG)) == 1

    def test_it_moves_on_in_the_log_and_is_not_lost(self) -> None:
        records = tracked(self.passing(), self.CONFIG)[0]
        assert len(of_kind(records, Kind.LOST)) == 0
        own = records[(records["x"] < 700) & (records["t_us"] > 315_000) & (records["t_us"] < 395_000)]
        assert len(own) > 50
        assert (own["n_ev"] == 0).all()
        assert own["x"] == pytest.approx(100 + 300e-6 * own["t_us"], abs=6)

    def test_a_new_cluster_near_the_predicted_place_takes_the_track_over(self) -> None:
        """It comes back beside its way: outside the coasting window of 10 px, within and outside the reach of 20 px."""
        assert len(self.ids(self.CONFIG, bend_px=17)) == 1
        assert len(self.ids(self.CONFIG, bend_px=30)) == 2

    def test_it_is_lost_when_it_has_coasted_for_long_enough(self) -> None:
        records = tracked(self.passing(), replace(self.CONFIG, coast_us=50_000))[0]
        (lost,) = of_kind(records, Kind.LOST)
        assert lost["t_us"] == pytest.approx(300_000 + 10_000 + 50_000, abs=1_000)
        assert np.unique(records["track_id"]).tolist() == [0, 1, 2]
