# SPDX-License-Identifier: Apache-2.0
"""The registers of the extended contract: ranges, contradictions, and the file that sets them."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import pytest

from evcot.errors import ConfigError
from evcot.hardware.config import MotionConfig
from evcot.hardware.motion._state import STEP_LOG2
from evcot.hardware.motion.contract import MOTION_RANGES, MotionRegisters
from evcot.trackers.config import RunConfig, load_toml
from evcot.trackers.presets import PRESETS, fit

NAMES = [field.name for field in fields(MotionRegisters)]


def registers_of(config: RunConfig) -> MotionRegisters:
    assert isinstance(config.hardware, MotionConfig)
    return config.hardware.registers


def test_every_register_has_a_range() -> None:
    assert list(MOTION_RANGES) == NAMES
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


def test_values_at_the_limit_of_a_contradiction_are_taken() -> None:
    MotionRegisters(nev_low=20, nev_high=20, ring_px=8, ring_max=8, life_ticks=9, coast_ticks=9, seed_px=9, side_max=18)


def test_a_file_sets_them(tmp_path: Path) -> None:
    path = tmp_path / "run.toml"
    path.write_text('hardware = "cot_motion"\n[motion]\nside_max = 90\n', encoding="utf-8")
    base = PRESETS["motion"]
    assert registers_of(load_toml(path, base)) == replace(registers_of(base), side_max=90)
    assert registers_of(load_toml(path, PRESETS["davis346"])) == MotionRegisters(side_max=90), "no registers of it before"
    path.write_text("[motion]\nside = 90\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"\[motion\]: unknown field 'side'"):
        load_toml(path, base)


def test_the_preset_keeps_them_on_any_sensor() -> None:
    motion = PRESETS["motion"]
    assert motion.hardware.module == "cot_motion"
    assert registers_of(fit(motion, 640, 480, 4)) == registers_of(motion)
    hardware = {name: PRESETS[name].to_dict()["hardware"] for name in ("motion", "traffic")}
    assert [("registers" in values, "slots" in values) for values in hardware.values()] == [(True, False), (False, True)]
