# SPDX-License-Identifier: Apache-2.0
"""Registers and filters of the array with motion by what was seen: how they follow each estimate."""

from __future__ import annotations

import itertools
from dataclasses import replace

import pytest

from evcot.hardware.motion.contract import MotionRegisters
from evcot.trackers.auto.estimates import Estimates, Objects
from evcot.trackers.auto_motion import motion_config
from evcot.trackers.config import RunConfig
from evcot.trackers.presets import PRESETS
from support.scene_estimates import ALIKE, MIXED, objects_of, spread


def config_of(seen: Estimates) -> RunConfig:
    return motion_config(seen, "auto")


def motion_of(seen: Estimates) -> MotionRegisters:
    return config_of(seen).cot.motion


def test_addresses_and_slots() -> None:
    shape = config_of(MIXED).cot.shape
    assert (shape.x_w, shape.y_w) == (9, 9)
    slots = [config_of(replace(MIXED, alive_most=alive)).cot.shape.n_slots for alive in (0, 4, 5, 12, 13, 28, 60, 61, 200)]
    assert slots == [8, 8, 16, 16, 32, 32, 64, 64, 64], "a power of two with room for four more"


def test_a_fast_object_travels_up_to_a_pixel_and_a_quarter_in_a_motion_step() -> None:
    for step_us, step_log2 in ((1024, 10), (1025, 10), (2047, 10), (2048, 11), (5000, 12)):
        fastest = 1.25e6 / step_us
        seen = objects_of(MIXED, speed_px_s=spread(fastest / 2, 2))
        assert motion_of(seen).step_log2 == step_log2, step_us
    assert motion_of(objects_of(MIXED, speed_px_s=spread(1e6))).step_log2 == 8
    assert motion_of(objects_of(MIXED, speed_px_s=spread(0.01))).step_log2 == 13


def test_what_is_counted_in_steps_takes_the_same_time_whatever_their_length() -> None:
    base = motion_of(objects_of(MIXED, speed_px_s=spread(900)))
    assert (base.step_log2, base.friction, base.join_steps, base.report_steps) == (10, 7, 10, 4)
    longer = motion_of(objects_of(MIXED, speed_px_s=spread(450)))
    assert (longer.step_log2, longer.friction, longer.join_steps, longer.report_steps) == (11, 6, 5, 2)
    shorter = motion_of(objects_of(MIXED, speed_px_s=spread(1800)))
    assert (shorter.step_log2, shorter.friction, shorter.join_steps, shorter.report_steps) == (9, 8, 20, 8)
    longest = motion_of(objects_of(MIXED, speed_px_s=spread(1)))
    assert (longest.friction, longest.join_steps, longest.report_steps) == (4, 1, 1)


def test_all_other_registers_are_those_of_the_preset() -> None:
    preset = PRESETS["motion"].cot.motion
    counted = ("step_log2", "friction", "join_steps", "report_steps")
    for seen in (MIXED, ALIKE):
        motion = motion_of(seen)
        same = replace(motion, **{name: getattr(preset, name) for name in counted})
        assert same == preset


def test_noise_is_filtered_where_it_would_be_a_share_of_an_objects_events() -> None:
    """80 pixels per pixel at 60 px/s are 4,800 events/s; the window, three half sides a side, has 2,304 px."""
    assert config_of(replace(MIXED, noise_hz=None)).filters.activity_us == 0
    assert config_of(replace(MIXED, noise_hz=0.0208)).filters.activity_us == 0
    filters = config_of(replace(MIXED, noise_hz=0.0209)).filters
    assert (filters.activity_us, filters.activity_support) == (50_000, 1)
    supports = [config_of(replace(MIXED, noise_hz=hz)).filters.activity_support for hz in (0.1, 1.0, 5.0, 20.0)]
    assert supports == sorted(supports)
    assert supports[-1] > supports[0]


def test_an_event_is_neighboured_by_four_of_its_object_within_the_time_of_the_filter() -> None:
    """Objects alike: 18,000 events/s on 324 px, so eight pixels have four in 9 ms."""
    filters = config_of(replace(ALIKE, noise_hz=5.0)).filters
    assert filters.activity_us == pytest.approx(4e6 / (8 * 18_000 / 324), abs=1)


def test_hot_pixels_are_masked() -> None:
    assert config_of(MIXED).filters.hot_pixels == ((3, 4),)


def test_without_objects_the_preset_is_assumed_behind_a_filter_if_there_is_noise() -> None:
    seen = Estimates((346, 260), 20_000, 10, 5.0, ((3, 4),))
    config = config_of(seen)
    assert config.cot.motion == PRESETS["motion"].cot.motion
    assert (config.filters.activity_us, config.filters.activity_support) == (10_000, 3)
    assert config_of(replace(seen, noise_hz=0.0)).filters.activity_us == 0


def test_extremes_stay_within_limits() -> None:
    for size, speed, pixels in itertools.product((0.1, 4000.0), (0.01, 1e6), (0.01, 1e6)):
        config_of(Estimates((1280, 720), 1, 1, 1e3, (), 1, 1, Objects(*map(spread, (size, size, speed, pixels)))))
