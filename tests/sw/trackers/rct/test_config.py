# SPDX-License-Identifier: Apache-2.0
"""Settings: the paper's tracker by default, and invalid combinations."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import pytest

from evcot.errors import ConfigError
from evcot.trackers.rct.config import RCT_CHOICES, RCT_RANGES, RctConfig

PLAIN = {"max_clusters", "radius_px", "alpha", "velocity_alpha", "visible_events", "lifetime_us", "packet_us"}


def test_the_default_is_the_papers_tracker_and_every_other_setting_is_an_option() -> None:
    assert not RctConfig().full
    for f in fields(RctConfig):
        if f.name in RCT_RANGES:
            low, high, _ = RCT_RANGES[f.name]
            value: Any = low if low != f.default else high
        elif f.name in RCT_CHOICES:
            value = RCT_CHOICES[f.name][1]
        else:
            value = not f.default
        changed = RctConfig(**{f.name: value})  # type: ignore[arg-type]
        assert changed.full == (f.name not in PLAIN)


def test_every_setting_is_checked() -> None:
    switches = {f.name for f in fields(RctConfig) if isinstance(f.default, bool)}
    assert {f.name for f in fields(RctConfig)} == RCT_RANGES.keys() | RCT_CHOICES.keys() | switches


@pytest.mark.parametrize("name", RCT_CHOICES)
def test_a_choice_is_one_of_its_names(name: str) -> None:
    with pytest.raises(ConfigError) as caught:
        RctConfig(**{name: "both?"})  # type: ignore[arg-type]
    assert str(caught.value) == f"rct.{name} = 'both?': must be one of {', '.join(RCT_CHOICES[name])}"


def test_a_switch_is_on_or_off() -> None:
    with pytest.raises(ConfigError, match=r"^rct\.dynamic_size = 1: must be true or false$"):
        RctConfig(dynamic_size=1)  # type: ignore[arg-type]


def test_the_reference_row_is_a_pixel_from_the_vanishing_row_or_on_it() -> None:
    assert not RctConfig(vanishing_y_px=7.0, reference_y_px=7.0).perspective
    message = "rct.reference_y_px = 7.5: must be vanishing_y_px = 7 (no perspective), or at least 1 px from it"
    with pytest.raises(ConfigError) as caught:
        RctConfig(vanishing_y_px=7.0, reference_y_px=7.5)
    assert str(caught.value) == message
