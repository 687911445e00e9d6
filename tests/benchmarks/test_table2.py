# SPDX-License-Identifier: Apache-2.0
"""Slow against fast: settings as the paper has them, exact lag, and the same bits from hardware and model."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest

import following
import table2
from evcot.scenes.boxes import BoxExperiment, simulate
from evcot.scenes.truth import Scene
from evcot.tracks.log import TRACK, Kind, TrackLog

LIFETIME_US = 20_000


@pytest.fixture(scope="module")
def scene() -> Scene:
    return simulate(BoxExperiment(speed="fast", duration_us=400_000, truth_step_us=4_007))


def ideal(scene: Scene, late_us: int) -> TrackLog:
    """A track on every box, which says every 0.1 ms where the box was a while ago."""
    t_us = np.arange(0, 400_000, 100)
    parts = []
    for i, box in enumerate(scene.truth.boxes):
        records = np.zeros(len(t_us), TRACK)
        records["t_us"], records["track_id"], records["kind"], records["other_id"] = t_us, i, Kind.MOVED, -1
        records["kind"][0] = Kind.BORN
        records["x"], records["y"] = box.centre(t_us - late_us)
        parts.append(records)
    records = np.concatenate(parts)
    return TrackLog("cot_array", records[np.argsort(records["t_us"], kind="stable")], np.zeros(1, np.int16))


@pytest.mark.parametrize("late_us", [0, 2_000, 10_000])
def test_lag_is_how_late_a_track_is(scene: Scene, late_us: int) -> None:
    found = following.follow(ideal(scene, late_us), scene, LIFETIME_US)
    assert np.median(found.lag_ms) == pytest.approx(late_us / 1_000, abs=0.1)
    assert np.median(found.lag_px) == pytest.approx(0.4 * np.median(found.lag_ms), abs=0.01)  # 400 px/s
    assert np.median(found.error_px) == pytest.approx(np.median(found.lag_px), abs=0.02)
    assert len(found.error_px) > 0.9 * found.objects
    assert (found.lost, found.born) == (0, len(scene.truth.boxes))


def test_a_track_that_is_ahead_has_a_lag_below_zero(scene: Scene) -> None:
    found = following.follow(ideal(scene, -5_000), scene, LIFETIME_US)
    assert np.median(found.lag_ms) == pytest.approx(-5, abs=0.1)


def test_only_a_life_that_ends_on_a_moving_box_is_lost_on_the_way(scene: Scene) -> None:
    log = ideal(scene, 0)
    x, y = scene.truth.boxes[0].centre(np.array([200_000]))
    ends = np.zeros(2, TRACK)
    ends["t_us"], ends["kind"], ends["track_id"], ends["other_id"] = 200_000, Kind.LOST, (0, 1), -1
    ends["x"], ends["y"] = x[0], (y[0], y[0] + 20)  # on the box, and 20 px below it
    records = np.concatenate((log.records[log.records["t_us"] <= 200_000], ends))
    assert following.follow(TrackLog("cot_array", records, log.owner), scene, LIFETIME_US).lost == 1


def test_settings_are_those_of_the_paper() -> None:
    for adjustment in table2.Adjustment:
        config = table2.configured(table2.Setting(3, 7, adjustment), (346, 260)).hardware
        slot = config.slots[0]
        assert (slot.clust_nev, slot.hist_avg) == (3, 1)  # alpha = 1/2
        assert slot.max_ticks * config.tick_us == 7_000
        assert slot.detect_ticks * config.tick_us == 5_000  # the same whatever a tick is
        assert (slot.nev_min == slot.nev_max) == (adjustment is table2.Adjustment.FIXED)
    assert {table2.Setting(*setting[1:], table2.Adjustment.FIXED) for setting in table2._PAPERS} == {
        table2.Setting(n_ev, tc_ms, table2.Adjustment.FIXED) for n_ev, tc_ms in ((8, 20), (5, 7), (3, 7))
    }


def test_time_at_each_n_ev_is_weighted_by_how_long_it_lasted() -> None:
    records = np.zeros(5, TRACK)
    records["t_us"], records["track_id"], records["n_ev"] = (0, 10, 15, 40, 100), (0, 1, 0, 0, 1), (8, 4, 16, 8, 2)
    n_ev, lasted_us = table2.n_ev_over_time(TrackLog("cot_array", records, np.zeros(1, np.int16)))
    assert list(zip(n_ev.tolist(), lasted_us.tolist(), strict=True)) == [(8, 15), (16, 25), (4, 90)]


def test_hardware_and_model_give_one_outcome(scene: Scene) -> None:
    short = replace(scene, recording=replace(scene.recording, events=scene.recording.events[:20_000]))
    setting = table2.Setting(3, 7, table2.Adjustment.WIDE)
    assert asdict(table2.outcome(short, setting)) == asdict(table2.outcome(short, setting, rtl=False))


def test_n_ev_does_not_decide_how_far_a_centre_lags_in_pixels_but_alpha_does() -> None:
    """Events come as often as the box moves, so a lag counted in events is one in pixels, whatever the speed."""
    lag_px = {
        (speed, hist_avg): table2.outcome(
            table2.scene(speed, 1, 600_000), table2.Setting(8, 20, table2.Adjustment.FIXED, hist_avg), rtl=False
        ).lag_px
        for speed in ("slow", "fast")
        for hist_avg in (1, 3)
    }
    for speed in ("slow", "fast"):
        assert lag_px[speed, 3] > lag_px[speed, 1] + 0.3
    assert lag_px["fast", 3] == pytest.approx(lag_px["slow", 3], rel=0.5)  # at 5 times the speed
