# SPDX-License-Identifier: Apache-2.0
"""The line on what a tracker has seen of a scene."""

from __future__ import annotations

import re

import pytest

from evcot.events import Events
from evcot.filters.config import FilterConfig
from evcot.scenes.registry import simulate_scene
from evcot.trackers.adaptive.estimates import estimate
from evcot.trackers.engines import ENGINES
from evcot.trackers.scene_line import seen_by

SENSOR = 346, 260


@pytest.fixture(scope="module")
def events() -> Events:
    """Six discs for two seconds."""
    return simulate_scene("discs", 5, {"duration_us": 2_000_000}).recording.events


@pytest.mark.parametrize("filters", [FilterConfig(), FilterConfig(refractory_us=1)])
def test_the_adaptive_tracker_tells_its_estimates_behind_filters_or_not(events: Events, filters: FilterConfig) -> None:
    engine = ENGINES["adaptive"]
    tracker = engine.start(engine.presets["auto"], filters, SENSOR)
    tracker.feed(events)
    seen = seen_by(tracker)
    assert seen is not None
    assert re.fullmatch(r"auto: 346x260, 2 s, noise .* up to 6 objects of .*", seen)
    if not filters.enabled:
        assert seen == str(estimate([events], SENSOR))


def test_the_hardware_s_model_tells_what_it_follows(events: Events) -> None:
    engine = ENGINES["cot_motion"]
    tracker = engine.start(engine.presets["auto"], engine.filters["auto"], SENSOR)
    first = seen_by(tracker)
    assert first == "auto: 346x260, 0 s, noise unknown, 0 hot pixels, no object seen for long enough"
    tracker.feed(events)
    seen = seen_by(tracker)
    assert seen is not None
    found = re.fullmatch(
        r"auto: 346x260, 2 s, noise ([0-9.]+) Hz/pixel, 0 hot pixels, up to 6 objects of ([0-9]+) to ([0-9]+) px, "
        r"([0-9]+) to ([0-9]+) px/s -> at the end an event needs ([0-6]) of 8 neighbours within 40 ms",
        seen,
    )
    assert found is not None, seen
    assert float(found[1]) == pytest.approx(0.1, rel=0.5)
    assert (int(found[2]), int(found[3])) == (pytest.approx(20, abs=4), pytest.approx(22, abs=4))


@pytest.mark.parametrize(("name", "preset"), [("rct", "plain"), ("cot_array", "davis346")])
def test_others_tell_nothing(events: Events, name: str, preset: str) -> None:
    engine = ENGINES[name]
    tracker = engine.start(engine.presets[preset], FilterConfig(), SENSOR)
    tracker.feed(events[:1000])
    assert seen_by(tracker) is None
