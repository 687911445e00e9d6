# SPDX-License-Identifier: Apache-2.0
"""The rules of docs/motion.md in hardware: built for an array, refused in one line where there are none, used by commands."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.hardware.config import CotConfig
from evcot.hardware.contract import Shape
from evcot.hardware.motion.contract import MOTION_RECORD, MotionRegisters
from evcot_cosim.cli import main
from evcot_cosim.devices.device import Device, build_device
from evcot_cosim.devices.motion import MOTION_PARAMETERS
from evcot_cosim.lockstep.random_runs import random_motion, random_motion_run, random_outlines
from evcot_cosim.names import Top

CONFIG = CotConfig(Shape(n_slots=1), motion=MotionRegisters(enable=1))


@pytest.mark.parametrize("top", ["cot", "cot_chain"])
def test_only_an_array_has_motion(top: Top) -> None:
    for build in (build_device, Device):
        with pytest.raises(ConfigError) as caught:
            build(CONFIG, top)
        assert str(caught.value) == f"motion.enable = 1: must be 0 for {top}; only cot_array has motion"


def test_time_must_have_enough_bits() -> None:
    shape = Shape(n_slots=1, time_w=31, tc_w=17, tick_w=20)
    with pytest.raises(ConfigError, match=r"^shape.time_w = 31: must be from 32 to 48 with motion.enable = 1$"):
        build_device(random_motion(np.random.default_rng(1), shape))


def test_a_shape_that_differs_in_what_motion_does_not_have_is_the_same_hardware() -> None:
    other = replace(CONFIG, shape=replace(CONFIG.shape, frac=0, nev_w=12))
    assert build_device(CONFIG).key == build_device(other).key
    assert {"frac", "nev_w", "tc_w"}.isdisjoint(MOTION_PARAMETERS)


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
    assert tomllib.loads((tmp_path / "out" / "run.toml").read_text())["motion"]["enable"] == 1
    assert MOTION_RECORD.names is not None
