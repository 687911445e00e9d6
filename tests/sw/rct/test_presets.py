# SPDX-License-Identifier: Apache-2.0
"""The presets do what they are for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evcot.events import Events, Recording
from evcot.files import read_recording
from evcot.metrics import GroundTruth, evaluate, load_rule, read_truth
from evcot.rct.config import RctConfig
from evcot.rct.presets import PRESETS
from evcot.rct.tracker import track
from evcot.scenes.registry import simulate_scene

SHARED = Path(__file__).parents[4] / "shared" / "data"


def test_the_papers_tracker_stands_first() -> None:
    assert next(iter(PRESETS.items())) == ("plain", RctConfig())
    assert not PRESETS["plain"].whole


def test_four_separate_discs_are_followed_without_a_switch_to_a_pixel(tmp_path: Path) -> None:
    scene = simulate_scene("discs", 1, {"count": 4, "ways": "separate", "duration_us": 1_500_000})
    scene.truth.save(tmp_path / "truth.csv")
    rule = load_rule("scene")
    truth = read_truth(tmp_path / "truth.csv", rule)
    scores = evaluate(track(scene.recording, PRESETS["discs"]), truth, rule)
    speed = float(np.median(np.hypot(truth.objects["vx"], truth.objects["vy"])))
    assert scores.idsw == 0
    assert scores.mota > 0.9
    assert scores.position_error_px_median is not None
    assert scores.position_error_px_median < 1.0
    assert scores.velocity_error_median is not None
    assert scores.velocity_error_median < 0.05 * speed


def test_real_traffic_is_followed_on_the_half_that_was_tuned_on() -> None:
    recording, truth_file = SHARED / "traffic_outbound.aedat4", SHARED / "traffic_outbound_gt.csv"
    if not recording.exists():
        pytest.skip(f"{recording} is not here")
    whole, rule = read_recording(recording), load_rule("traffic")
    middle_us = int(whole.events.t_us[0] + whole.events.t_us[-1]) // 2
    truth = read_truth(truth_file, rule)
    early = truth.instants_us <= middle_us
    half = GroundTruth(truth.instants_us[early], truth.objects[early[truth.objects["frame"]]], truth.ids)
    events: Events = whole.events.where((whole.events.t_us <= middle_us) & ~_hot(whole))
    scores = evaluate(track(Recording(events, whole.width, whole.height), PRESETS["traffic"]), half, rule)
    assert scores.hota >= 0.85
    assert scores.idf1 >= 0.95
    assert scores.idsw <= 1


def _hot(recording: Recording) -> np.ndarray:  # type: ignore[type-arg]
    """Events of the one pixel that never rests."""
    pixel = recording.events.y.astype(np.int64) * recording.width + recording.events.x
    return np.asarray(pixel == np.bincount(pixel).argmax())
