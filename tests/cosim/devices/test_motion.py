# SPDX-License-Identifier: Apache-2.0
"""cot_motion in simulation: its shape, random registers and traffic for it, and the command that compares it with its model."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from evcot.hardware.config import MotionConfig
from evcot.hardware.contract import Shape
from evcot_cosim.cli import main
from evcot_cosim.devices.device import build_device
from evcot_cosim.lockstep.random_runs import random_motion_run, random_outlines

CONFIG = MotionConfig(Shape(n_slots=1))


def test_a_shape_that_differs_in_what_motion_does_not_have_is_the_same_hardware() -> None:
    built = build_device(CONFIG)
    assert built.key == build_device(replace(CONFIG, shape=replace(CONFIG.shape, frac=0, nev_w=12))).key
    assert {"FRAC", "NEV_W", "TC_W"}.isdisjoint(built.parameters)


def test_random_runs_have_records_of_every_kind() -> None:
    shape = Shape(n_slots=8, x_w=7, y_w=7, tc_w=12)
    lockstep = random_motion_run(shape, 7, 4_000)
    assert lockstep.events == 4_000
    assert lockstep.records > 0
    assert lockstep.latency.sum() <= lockstep.records


def test_outlines_stay_on_the_sensor() -> None:
    for seed in range(8):
        events = random_outlines(np.random.default_rng(seed), Shape(n_slots=2, x_w=5, y_w=9), 2_000, 2.0)
        assert events.x.max() < 32
        assert events.y.max() < 512
        assert np.all(np.diff(events.ticks) >= 0)


def test_a_command_compares_hardware_and_model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["cosim", "discs", "--to", "0.1", "--preset", "motion", "-o", "out"]) == 0
    assert tomllib.loads((tmp_path / "out" / "run.toml").read_text())["hardware"] == "cot_motion"
