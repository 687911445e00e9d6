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
    assert not RctConfig().whole
    for f in fields(RctConfig):
        if f.name in RCT_RANGES:
            low, high, _ = RCT_RANGES[f.name]
            value: Any = low if low != f.default else high
        elif f.name in RCT_CHOICES:
            value = RCT_CHOICES[f.name][1]
        else:
            value = not f.default
        needed = {"velocity": {"path_points": 3}, "perspective": {"reference_y_px": 10.0}}
        changed = RctConfig(**{f.name: value}, **needed.get(f.name, {}))  # type: ignore[arg-type]
        assert changed.whole == (f.name not in PLAIN)


def test_every_setting_is_checked() -> None:
    switches = {f.name for f in fields(RctConfig) if isinstance(f.default, bool)}
    assert {f.name for f in fields(RctConfig)} == RCT_RANGES.keys() | RCT_CHOICES.keys() | switches


@pytest.mark.parametrize("name", RCT_CHOICES)
def test_a_choice_is_one_of_its_names(name: str) -> None:
    with pytest.raises(ConfigError) as caught:
        RctConfig(**{name: "both?"})  # type: ignore[arg-type]
    assert str(caught.value) == f"rct.{name} = 'both?': must be one of {', '.join(RCT_CHOICES[name])}"


@pytest.mark.parametrize("name", ["seeding", "free_aspect", "angle", "merging", "merge_grow"])
def test_a_switch_is_on_or_off(name: str) -> None:
    with pytest.raises(ConfigError, match=rf"^rct\.{name} = 1: must be true or false$"):
        RctConfig(**{name: 1})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"velocity": "regression", "path_points": 2}, "rct.path_points = 2: must be at least 3 for velocity 'regression'"),
        (
            {"size": "deviation", "radius_px": 60.0},
            "rct.radius_px = 60: must lie from radius_min_px = 4 to radius_max_px = 50 when size is 'deviation'",
        ),
        (
            {"angle": True, "centre": "box"},
            "rct.angle = True: must not be combined with size 'quantile' or centre 'box', which never turn",
        ),
        (
            {"perspective": "row", "vanishing_y_px": 7.0, "reference_y_px": 7.5},
            "rct.perspective = 'row': reference must lie at least 1 px from vanishing",
        ),
    ],
)
def test_what_contradicts_itself_is_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        RctConfig(**options)
    assert str(caught.value) == message
