# SPDX-License-Identifier: Apache-2.0
"""Filters and slots of the array with motion by what was seen."""

from __future__ import annotations

import itertools
from dataclasses import replace

from evcot.filters.noise import support_against
from evcot.trackers.auto.estimates import Estimates, Objects
from evcot.trackers.auto_motion import motion_config
from evcot.trackers.config import RunConfig
from evcot.trackers.presets import FOLLOWING, PRESETS
from support.scene_estimates import ALIKE, MIXED, spread

NOTHING = Estimates((346, 260))


def config_of(seen: Estimates) -> RunConfig:
    return motion_config(seen, "auto")


def test_addresses_and_slots() -> None:
    shape = config_of(MIXED).cot.shape
    assert (shape.x_w, shape.y_w) == (9, 9)
    slots = [config_of(replace(MIXED, alive_most=alive)).cot.shape.n_slots for alive in (0, 4, 5, 12, 13, 28, 60, 61, 200)]
    assert slots == [8, 8, 16, 16, 32, 32, 64, 64, 64], "a power of two with room for four more"


def test_registers_are_those_of_the_preset_whatever_was_seen() -> None:
    for seen in (MIXED, ALIKE, NOTHING):
        assert config_of(seen).cot.motion == PRESETS["motion"].cot.motion


def test_the_filters_hold_what_those_that_follow_have_at_that_noise() -> None:
    follow = FOLLOWING.filters
    for noise_hz in (0.0, 0.02, 0.1, 0.5, 1.0, 5.0, 50.0):
        filters = config_of(replace(MIXED, noise_hz=noise_hz)).filters
        support = support_against(noise_hz, follow.activity_us, follow.activity_noise_hz)
        assert (filters.activity_us, filters.activity_support) == ((follow.activity_us, support) if support else (0, 1)), (
            noise_hz
        )
        assert (filters.refractory_us, filters.activity_noise_hz) == (follow.refractory_us, 0.0)
    assert config_of(NOTHING).filters.activity_us == 0, "of unknown noise nothing is filtered"


def test_hot_pixels_are_masked() -> None:
    assert config_of(MIXED).filters.hot_pixels == ((3, 4),)


def test_extremes_stay_within_limits() -> None:
    for size, speed, pixels in itertools.product((0.1, 4000.0), (0.01, 1e6), (0.01, 1e6)):
        config_of(Estimates((1280, 720), 1, 1, 1e3, (), 1, 1, Objects(*map(spread, (size, size, speed, pixels)))))
