# SPDX-License-Identifier: Apache-2.0
"""The comparison of the engines is a mean over draws, and an engine without a preset for the scene runs with its first one."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import quality
from cot_quality import Case
from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.metrics import load_rule
from evcot.metrics.truth import OBJECT, GroundTruth
from evcot.trackers.adaptive.config import AdaptiveConfig
from evcot.trackers.adaptive.tracker import AdaptiveTracker
from evcot.tracks.log import TRACK, Kind, TrackLog


def case() -> Case:
    """One object that stands at (10, 10) for 2 s, in 20,000 events."""
    t_us = np.arange(20_000) * 100
    x, p = np.full(20_000, 10, np.uint16), np.ones(20_000, np.uint8)
    objects = np.zeros(100, OBJECT)
    objects["frame"], objects["counted"] = np.arange(100), True
    objects["x"], objects["y"], objects["width"], objects["height"] = 10, 10, 8, 8
    truth = GroundTruth(np.arange(100) * 20_000, objects, ("a",))
    return Case("discs crossing, one", "discs", Recording(Events(t_us, x, x, p), 20, 20), truth, load_rule("scene"))


def test_quality_is_a_mean_over_draws(monkeypatch: pytest.MonkeyPatch) -> None:
    lengths, lost = [], set()

    def follow(given: Case, _: str) -> TrackLog:
        """Exact in the first draw, in two tracks in the others."""
        lengths.append(len(given.recording.events))
        lost.add(bytes(given.recording.events.t_us))
        records = np.zeros(100, TRACK)
        records["t_us"], records["kind"] = given.truth.instants_us, Kind.MOVED
        records["x"], records["y"], records["width"], records["height"] = 10, 10, 8, 8
        records["track_id"] = (len(lengths) > 1) & (np.arange(100) >= 50)
        return TrackLog("some", records, np.empty(0, np.int16))

    monkeypatch.setattr(quality, "follow", follow)
    found = quality.quality([case()], "some")
    assert len(lost) == len(lengths) == quality.DRAWS == 5
    assert all(17_800 < length < 18_200 for length in lengths)
    minutes = 99 * 0.02 / 60
    assert found.switches == pytest.approx(0.8 / minutes)  # per minute; 4 switches in 5 draws
    assert found.idf1 == pytest.approx((1 + 4 * 0.5) / 5, abs=0.02)  # the first track is there for 60 ms more
    assert found.hota == pytest.approx((1 + 4 * np.sqrt(0.5)) / 5, abs=0.02)


def test_an_engine_without_a_preset_for_the_scene_has_its_first(monkeypatch: pytest.MonkeyPatch) -> None:
    started = []

    def start(settings: str, filters: FilterConfig, sensor: tuple[int, int]) -> Any:
        started.append((settings, filters, sensor))
        return AdaptiveTracker(AdaptiveConfig(), *sensor)

    filters = FilterConfig(refractory_us=7)
    for presets in ({"auto": "first", "motion": "second"}, {"auto": "first", "discs": "own"}):
        engine = SimpleNamespace(presets=presets, filters={"auto": filters}, start=start)
        monkeypatch.setattr(quality, "ENGINES", {"some": engine})
        quality.follow(case(), "some")
    assert started == [("first", filters, (20, 20)), ("own", FilterConfig(), (20, 20))]
