# SPDX-License-Identifier: Apache-2.0
"""The registers of the extended contract: ranges, contradictions, and the file that sets them."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import pytest

from evcot.errors import ConfigError
from evcot.hardware.motion._state import STEP_LOG2
from evcot.hardware.motion.contract import MOTION_RANGES, MotionRegisters
from evcot.trackers.config import load_toml
from evcot.trackers.presets import PRESETS, fit

NAMES = [field.name for field in fields(MotionRegisters)]


def test_every_register_has_a_range_and_none_is_on_by_default() -> None:
    assert list(MOTION_RANGES) == NAMES
    assert MotionRegisters().enable == 0
    assert NAMES[STEP_LOG2] == "step_log2"


@pytest.mark.parametrize("name", NAMES)
def test_a_value_outside_its_range_is_named(name: str) -> None:
    low, high, meaning = MOTION_RANGES[name]
    for value in (int(low) - 1, int(high) + 1, 1.5, True):
        changes: dict[str, Any] = {name: value}
        with pytest.raises(ConfigError) as caught:
            replace(MotionRegisters(), **changes)
        assert str(caught.value) == f"motion.{name} = {value!r}: must be an integer from {low} to {high} ({meaning})"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"nev_low": 20, "nev_high": 10}, "motion.nev_low = 20: must be at most nev_high = 10"),
        ({"ring_px": 9, "ring_max": 8}, "motion.ring_px = 9: must be at most ring_max = 8"),
        ({"life_ticks": 9, "coast_ticks": 8}, "motion.life_ticks = 9: must be at most coast_ticks = 8"),
        ({"seed_px": 9, "side_max": 17}, "motion.seed_px = 9: must be at most half of side_max = 17"),
    ],
)
def test_contradictions_are_refused(changes: dict[str, int], message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        MotionRegisters(**changes)
    assert str(caught.value) == message


def test_a_file_sets_them(tmp_path: Path) -> None:
    path = tmp_path / "run.toml"
    path.write_text("[motion]\nenable = 1\nside_max = 90\n", encoding="utf-8")
    base = PRESETS["davis346"]
    found = load_toml(path, base).cot.motion
    assert found == replace(base.cot.motion, enable=1, side_max=90)
    path.write_text("[motion]\nside = 90\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"\[motion\]: unknown field 'side'"):
        load_toml(path, base)


def test_the_preset_keeps_them_on_any_sensor() -> None:
    motion = PRESETS["motion"].cot.motion
    assert motion.enable == 1
    assert fit(PRESETS["motion"], 640, 480, 4).cot.motion == motion
    assert "motion" in PRESETS["motion"].to_dict()["cot"]
    assert "motion" not in PRESETS["traffic"].to_dict()["cot"]
