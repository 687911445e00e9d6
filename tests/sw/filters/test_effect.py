# SPDX-License-Identifier: Apache-2.0
"""Filters remove noise and keep the signal; and no tracker behind them follows a hot pixel."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.filters.hot_pixels import learn_hot_pixels
from evcot.filters.run import Effect, add_noise, apply, area_under_curve, effect
from evcot.hardware import golden
from evcot.recordings.files import read_recording
from evcot.scenes.boxes import BoxExperiment, simulate
from evcot.trackers.config import RunConfig
from evcot.trackers.presets import fit, preset
from evcot.trackers.rct.tracker import track
from evcot.tracks.log import TrackLog
from shared import SHARED

TRAFFIC = SHARED / "traffic_outbound.aedat4"
HOT = (192, 209)
NOISE_HZ_PER_PX = (1.0, 5.0, 10.0)


@cache
def clean() -> Recording:
    return simulate(BoxExperiment(noise_hz_per_px=0.0, duration_us=1_000_000)).recording


@cache
def noisy(hz_per_px: float) -> tuple[Recording, NDArray[np.bool_]]:
    return add_noise(clean(), hz_per_px, np.random.default_rng(1))


class TestNoise:
    @pytest.mark.parametrize("hz_per_px", [0.0, 5.0])
    def test_the_clean_recording_is_all_there(self, hz_per_px: float) -> None:
        recording, is_noise = noisy(hz_per_px)
        assert is_noise.any() == (hz_per_px > 0)
        for name in ("t_us", "x", "y", "p"):
            np.testing.assert_array_equal(getattr(recording.events, name)[~is_noise], getattr(clean().events, name))

    def test_noise_has_its_rate_everywhere_and_all_the_time(self) -> None:
        recording, is_noise = noisy(10.0)
        noise = recording.events.where(is_noise)
        per_pixel = 10.0 * clean().duration_us * 1e-6
        counts = np.zeros((recording.height, recording.width))
        np.add.at(counts, (noise.y, noise.x), 1)
        assert counts.mean() == pytest.approx(per_pixel, rel=0.01)
        assert counts.var() == pytest.approx(per_pixel, rel=0.02)  # as of a Poisson process
        quarters = np.histogram(noise.t_us, 4)[0] / len(noise)
        np.testing.assert_allclose(quarters, 0.25, rtol=0.01)
        assert noise.p.mean() == pytest.approx(0.5, abs=0.01)


class TestMeasure:
    def test_shares_are_of_either_kind(self) -> None:
        """Of two signal events one is on; of three noise events two are."""
        events = Events(np.arange(5), np.zeros(5, np.uint16), np.zeros(5, np.uint16), np.array([1, 0, 1, 1, 0], np.uint8))
        is_noise = np.array([False, False, True, True, True])
        assert effect(Recording(events, 1, 1), is_noise, FilterConfig(polarity="on")) == Effect(1 / 2, 2 / 3)
        assert Effect(1 / 2, 2 / 3).noise_removed == pytest.approx(1 / 3)

    def test_the_area_is_1_where_all_is_told_apart_and_a_half_by_chance(self) -> None:
        assert area_under_curve([Effect(1.0, 0.0)]) == 1.0
        assert area_under_curve([]) == 0.5
        assert area_under_curve([Effect(0.3, 0.3)]) == pytest.approx(0.5)
        assert area_under_curve([Effect(0.5, 0.0), Effect(0.5, 0.5)]) == pytest.approx(0.625)


class TestBoxes:
    WINDOWS_US = (50, 200, 800, 3_200, 12_800, 51_200, 204_800)

    def curve(self, hz_per_px: float, make: Callable[[int], FilterConfig]) -> list[Effect]:
        return [effect(*noisy(hz_per_px), make(us)) for us in self.WINDOWS_US]

    @pytest.mark.parametrize(
        ("make", "areas"),
        [
            (lambda us: FilterConfig(activity_us=us), (0.99, 0.97, 0.95)),
            (lambda us: FilterConfig(activity_us=us, activity_support=2), (0.99, 0.98, 0.98)),
            (lambda us: FilterConfig(recent_us=us, recent_depth=256), (0.96, 0.92, 0.88)),
            (lambda us: FilterConfig(decay_tau_us=float(us)), (0.99, 0.985, 0.98)),
        ],
        ids=["activity", "activity of 2", "recent", "decay"],
    )
    def test_signal_and_noise_are_told_apart(self, make: Callable[[int], FilterConfig], areas: tuple[float, ...]) -> None:
        for hz_per_px, area in zip(NOISE_HZ_PER_PX, areas, strict=True):
            effects = self.curve(hz_per_px, make)
            assert (np.diff(np.array(effects), axis=0) >= 0).all()  # a longer window drops nothing that a shorter one keeps
            assert area_under_curve(effects) > area

    def test_a_fifo_of_few_events_forgets_a_large_sensor_too_soon(self) -> None:
        short, long = (
            area_under_curve(self.curve(5.0, lambda us, depth=depth: FilterConfig(recent_us=us, recent_depth=depth)))
            for depth in (32, 256)
        )
        assert short < 0.8 < 0.9 < long

    @pytest.mark.parametrize(
        ("config", "kept", "removed"),
        [
            (FilterConfig(activity_us=3_400, activity_support=2), 0.96, 0.98),
            (FilterConfig(decay_tau_us=5_000.0), 0.97, 0.96),
        ],
        ids=["activity of 2", "decay"],
    )
    def test_at_5_hz_per_pixel_most_noise_goes_and_most_signal_stays(
        self, config: FilterConfig, kept: float, removed: float
    ) -> None:
        got = effect(*noisy(5.0), config)
        assert got.signal_kept > kept
        assert got.noise_removed > removed


@pytest.mark.skipif(not TRAFFIC.is_file(), reason=f"no {TRAFFIC}")
class TestHotPixel:
    @staticmethod
    @cache
    def recording() -> Recording:
        return read_recording(TRAFFIC)

    def logs(self, filters: FilterConfig) -> list[TrackLog]:
        """Both trackers with the preset for the sensor, behind the filters."""
        run: RunConfig = fit(preset("davis346"), self.recording().width, self.recording().height)
        recording = apply(self.recording(), filters, run.hardware.tick_us)[0]
        return [golden.track(recording, run.hardware), track(recording, run.rct)]

    @staticmethod
    def stay_s(log: TrackLog) -> float:
        """How long, at most, one track reports from within 5 px of the hot pixel."""
        near = np.maximum(abs(log.records["x"] - HOT[0]), abs(log.records["y"] - HOT[1])) <= 5
        there = log.records[near]
        stays_us = [np.ptp(there["t_us"][there["track_id"] == track]) for track in np.unique(there["track_id"])]
        return max(stays_us, default=0) / 1e6

    def test_without_a_filter_both_trackers_follow_it_from_begin_to_end(self) -> None:
        for log in self.logs(FilterConfig()):
            assert self.stay_s(log) > 0.99 * self.recording().duration_us / 1e6

    def test_masked_no_track_comes_near(self) -> None:
        pixels = learn_hot_pixels(self.recording().events, (346, 260))
        for log in self.logs(FilterConfig(hot_pixels=pixels)):
            assert len(log.records) > 10_000
            assert self.stay_s(log) == 0

    @pytest.mark.parametrize(
        "filters", [FilterConfig(activity_us=5_000), FilterConfig(decay_tau_us=5_000.0)], ids=["activity", "decay"]
    )
    def test_it_does_not_vouch_for_itself(self, filters: FilterConfig) -> None:
        for log in self.logs(filters):
            assert len(log.records) > 10_000
            assert self.stay_s(log) < 0.05
