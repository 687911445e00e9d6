# SPDX-License-Identifier: Apache-2.0
"""Registers and filters of the array without motion by what was seen: how they follow each estimate."""

from __future__ import annotations

from dataclasses import replace

import pytest

from evcot.trackers.auto.estimates import Estimates, Objects
from evcot.trackers.auto_paper import paper_config
from evcot.trackers.config import RunConfig
from evcot.trackers.presets import PRESETS
from support.scene_estimates import ALIKE, MIXED, objects_of, spread


def config_of(seen: Estimates) -> RunConfig:
    return paper_config(seen, "auto-paper")


def test_addresses_and_slots() -> None:
    shape = config_of(MIXED).cot.shape
    assert (shape.x_w, shape.y_w, shape.n_slots) == (9, 9, 7 + 4)
    assert config_of(replace(MIXED, alive_most=200)).cot.shape.n_slots == 64


def test_a_window_reaches_beyond_an_object_and_follows_its_size() -> None:
    for scale in (0.5, 1.0, 2.0):
        slot = config_of(objects_of(MIXED, long_px=spread(20 * scale, 2))).cot.slots[0]
        assert slot.init_radix + slot.radix_th == pytest.approx(1.4 * 20 * scale, abs=1)
        assert slot.radix_max + slot.radix_th == pytest.approx(1.4 * 40 * scale, abs=1)


def test_windows_keep_their_size_where_objects_are_of_one() -> None:
    slot = config_of(ALIKE).cot.slots[0]
    assert slot.radix_max - slot.init_radix == slot.init_radix - slot.radix_min == 1
    mixed = config_of(MIXED).cot.slots[0]
    assert mixed.radix_max > 1.5 * mixed.init_radix


def test_one_polarity_only_where_objects_are_of_several_sizes() -> None:
    assert config_of(MIXED).filters.polarity == "off"
    assert config_of(ALIKE).filters.polarity is None


def test_counts_follow_pixels_per_pixel_travelled_and_not_speed() -> None:
    def n_ev(pixels: float, speed: float) -> int:
        return config_of(objects_of(ALIKE, pixels_per_px=spread(pixels), speed_px_s=spread(speed))).cot.slots[0].clust_nev

    assert n_ev(1000, 120) == 2 * n_ev(500, 120) == 2 * n_ev(500, 12) > 10


def test_times_follow_size_by_speed() -> None:
    def times(seen: Estimates) -> tuple[int, ...]:
        config = config_of(seen)
        return config.cot.slots[0].max_ticks, config.cot.slots[0].detect_ticks, config.filters.refractory_us

    slow = times(objects_of(MIXED, speed_px_s=spread(30, 3)))
    assert slow == pytest.approx([2 * t for t in times(MIXED)], abs=2)
    assert times(MIXED)[0] == int(1e6 * 0.12 * 16 / 60)


def test_noise_is_filtered_where_it_would_keep_tracks_alive() -> None:
    quiet, loud, louder = (config_of(replace(MIXED, noise_hz=hz)).filters for hz in (None, 1.0, 10.0))
    assert quiet.activity_us == 0
    assert loud.activity_us == louder.activity_us > 0
    assert louder.activity_support > loud.activity_support


def test_hot_pixels_are_masked() -> None:
    assert config_of(MIXED).filters.hot_pixels == ((3, 4),)


@pytest.mark.parametrize(("width", "preset"), [(128, "dvs128"), (346, "davis346"), (1280, "hd")])
def test_without_objects_the_preset_of_the_sensor_is_assumed(width: int, preset: str) -> None:
    config = config_of(Estimates((width, 100), 20_000, 10, 5.0, ((3, 4),)))
    assert config.cot.slots == PRESETS[preset].cot.slots
    assert config.filters.activity_us > 0


def test_extremes_stay_within_limits() -> None:
    for size in (0.1, 4000.0):
        for speed in (0.01, 1e6):
            for pixels in (0.01, 1e6):
                config_of(Estimates((1280, 720), 1, 1, 1e3, (), 1, 1, Objects(*map(spread, (size, size, speed, pixels)))))
