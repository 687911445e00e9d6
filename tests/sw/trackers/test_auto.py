# SPDX-License-Identifier: Apache-2.0
"""Filters and slots of the hardware by what was seen, and the line that says so."""

from __future__ import annotations

import itertools
from dataclasses import replace

from evcot.filters.config import FilterConfig
from evcot.filters.noise import support_against
from evcot.hardware.config import MotionConfig
from evcot.hardware.motion.contract import MotionRegisters
from evcot.trackers.adaptive.estimates import Estimates, Objects
from evcot.trackers.auto import auto_config, summary_line
from evcot.trackers.config import RunConfig
from evcot.trackers.presets import AUTO, FOLLOWING, MOTION, PRESETS
from support.scene_estimates import ALIKE, MIXED, spread

NOTHING = Estimates((346, 260))


def registers_of(config: RunConfig) -> MotionRegisters:
    assert isinstance(config.hardware, MotionConfig)
    return config.hardware.registers


def test_it_is_a_run_of_the_adaptive_tracker_which_needs_no_filters() -> None:
    config = auto_config(MIXED)
    assert (config.name, config.software, config.hardware.module) == (AUTO, "adaptive", "cot_motion")
    assert config.in_front_of_software == FilterConfig()
    assert AUTO not in PRESETS


def test_addresses_and_slots() -> None:
    shape = auto_config(MIXED).hardware.shape
    assert (shape.x_w, shape.y_w) == (9, 9)
    slots = [
        auto_config(replace(MIXED, alive_most=alive)).hardware.shape.n_slots for alive in (0, 4, 5, 12, 13, 28, 60, 61, 200)
    ]
    assert slots == [8, 8, 16, 16, 32, 32, 64, 64, 64], "a power of two with room for four more"


def test_registers_are_those_of_the_preset_whatever_was_seen() -> None:
    for seen in (MIXED, ALIKE, NOTHING):
        assert registers_of(auto_config(seen)) == registers_of(PRESETS["motion"])


def test_registers_are_those_of_the_base_if_one_is_given() -> None:
    registers = replace(registers_of(MOTION), side_max=90)
    base = replace(MOTION, hardware=MotionConfig(registers=registers))
    config = auto_config(MIXED, base)
    assert registers_of(config) == registers
    assert (config.filters, config.hardware.shape) == (auto_config(MIXED).filters, auto_config(MIXED).hardware.shape)


def test_the_filters_hold_what_those_that_follow_have_at_that_noise() -> None:
    follow = FOLLOWING.filters
    for noise_hz in (0.0, 0.02, 0.1, 0.5, 1.0, 5.0, 50.0):
        filters = auto_config(replace(MIXED, noise_hz=noise_hz)).filters
        support = support_against(noise_hz, follow.activity_us, follow.activity_noise_hz)
        assert (filters.activity_us, filters.activity_support) == ((follow.activity_us, support) if support else (0, 1)), (
            noise_hz
        )
        assert (filters.refractory_us, filters.activity_noise_hz) == (follow.refractory_us, 0.0)
    assert auto_config(NOTHING).filters.activity_us == 0, "of unknown noise nothing is filtered"


def test_hot_pixels_are_masked() -> None:
    assert auto_config(MIXED).filters.hot_pixels == ((3, 4),)


def test_extremes_stay_within_limits() -> None:
    for size, speed, pixels in itertools.product((0.1, 4000.0), (0.01, 1e6), (0.01, 1e6)):
        auto_config(Estimates((1280, 720), 1, 1, 1e3, (), 1, 1, Objects(*map(spread, (size, size, speed, pixels)))))


def test_the_line_says_what_runs() -> None:
    seen = replace(MIXED, noise_hz=0.5)
    line = summary_line(seen, auto_config(seen))
    assert line.startswith(str(seen))
    assert line.endswith("-> cot_motion with 16 slots, mask filter, refractory filter, activity filter")


def test_where_no_object_was_seen_the_line_says_so() -> None:
    seen = Estimates((1280, 720), 20_000, 10, 5.0)
    line = summary_line(seen, auto_config(seen))
    assert "no object seen for long enough -> cot_motion with 8 slots, refractory" in line, "nothing depends on objects"
