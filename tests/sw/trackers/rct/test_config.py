# SPDX-License-Identifier: Apache-2.0
"""Settings: the paper's tracker by default, and invalid combinations."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError
from evcot.events import Recording
from evcot.filters.run import apply
from evcot.metrics import GroundTruth, evaluate, load_rule, read_truth
from evcot.metrics.rule import Rule
from evcot.recordings.files import read_recording
from evcot.scenes.registry import simulate_scene
from evcot.trackers.rct.config import FILTERS, PRESETS, RCT_CHOICES, RCT_RANGES, RctConfig
from evcot.trackers.rct.tracker import track
from shared import SHARED
from support.refusals import refused

PLAIN = {"max_clusters", "radius_px", "alpha", "velocity_alpha", "visible_events", "lifetime_us", "packet_us"}


def test_the_default_is_the_papers_tracker_and_every_other_setting_is_an_option() -> None:
    assert next(iter(PRESETS.items())) == ("plain", RctConfig())
    assert not RctConfig().full
    switches = {f.name for f in fields(RctConfig) if isinstance(f.default, bool)}
    assert {f.name for f in fields(RctConfig)} == RCT_RANGES.keys() | RCT_CHOICES.keys() | switches, "every setting is checked"
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


@pytest.mark.parametrize("name", RCT_CHOICES)
def test_a_choice_is_one_of_its_names(name: str) -> None:
    with refused(ConfigError, f"rct.{name} = 'both?': must be one of {', '.join(RCT_CHOICES[name])}"):
        RctConfig(**{name: "both?"})  # type: ignore[arg-type]


def test_a_switch_is_on_or_off() -> None:
    with refused(ConfigError, "rct.dynamic_size = 1: must be true or false"):
        RctConfig(dynamic_size=1)  # type: ignore[arg-type]


def test_the_reference_row_is_a_pixel_from_the_vanishing_row_or_on_it() -> None:
    assert not RctConfig(vanishing_y_px=7.0, reference_y_px=7.0).perspective
    message = "rct.reference_y_px = 7.5: must be vanishing_y_px = 7 (no perspective), or at least 1 px from it"
    with refused(ConfigError, message):
        RctConfig(vanishing_y_px=7.0, reference_y_px=7.5)


def test_four_separate_discs_are_followed_without_a_switch_to_a_pixel(tmp_path: Path) -> None:
    recording, truth, rule = four_discs(tmp_path, "separate", 1, 1_500_000)
    scores = evaluate(track(recording, PRESETS["discs"]), truth, rule)
    speed = float(np.median(np.hypot(truth.objects["vx"], truth.objects["vy"])))
    assert scores.idsw == 0
    assert scores.mota > 0.98
    assert scores.position_error_px_median is not None
    assert scores.position_error_px_median < 1.0
    assert scores.velocity_error_median is not None
    assert scores.velocity_error_median < 0.05 * speed


@pytest.mark.parametrize("seed", [1, 2])
def test_discs_that_cross_keep_their_tracks_where_the_younger_goes_on_unseen(tmp_path: Path, seed: int) -> None:
    """Not so where events in both windows go to the nearer one: each takes of the other's."""
    recording, truth, rule = four_discs(tmp_path, "crossing", seed, 4_000_000)
    scores = evaluate(track(recording, PRESETS["discs"]), truth, rule)
    assert (scores.idsw, scores.track_ids) == (0, 4)
    assert scores.mota > 0.98
    shared = evaluate(track(recording, replace(PRESETS["discs"], assign="nearest")), truth, rule)
    assert shared.idsw > 0


@pytest.mark.parametrize(("half", "hota", "idf1"), [("first", 0.87, 0.99), ("second", 0.82, 0.95), ("both", 0.85, 0.97)])
def test_real_traffic_is_followed_without_a_switch(half: str, hota: float, idf1: float) -> None:
    """Only the first half was tuned on."""
    recording, truth_file = SHARED / "traffic_outbound.aedat4", SHARED / "traffic_outbound_gt.csv"
    if not recording.exists():
        pytest.skip(f"{recording} is not here")
    whole, rule = read_recording(recording), load_rule("traffic")
    middle_us = int(whole.events.t_us[0] + whole.events.t_us[-1]) // 2
    kept = apply(whole, FILTERS["traffic"])[0]
    truth = read_truth(truth_file, rule)
    if half != "both":
        truth = part_of(truth, (truth.instants_us <= middle_us) == (half == "first"))
    scores = evaluate(track(kept, PRESETS["traffic"]), truth, rule)
    assert scores.hota >= hota
    assert scores.idf1 >= idf1
    assert scores.idsw == 0


def part_of(truth: GroundTruth, chosen: NDArray[np.bool_]) -> GroundTruth:
    """The chosen instants alone."""
    objects = truth.objects[chosen[truth.objects["frame"]]]
    objects["frame"] = (np.cumsum(chosen) - 1)[objects["frame"]]
    return GroundTruth(truth.instants_us[chosen], objects, truth.ids)


def four_discs(folder: Path, ways: str, seed: int, duration_us: int) -> tuple[Recording, GroundTruth, Rule]:
    """A scene of discs and how it is scored."""
    scene = simulate_scene("discs", seed, {"count": 4, "ways": ways, "duration_us": duration_us, "truth_step_us": 20_000})
    scene.truth.save(folder / "truth.csv")
    rule = load_rule("scene")
    return scene.recording, read_truth(folder / "truth.csv", rule), rule
