# SPDX-License-Identifier: Apache-2.0
"""The RTL does not have the rules of docs/motion.md yet: whatever would build or write it with them is refused in one line."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from evcot.errors import ConfigError
from evcot.hardware.config import CotConfig
from evcot.hardware.contract import Shape
from evcot.hardware.motion.contract import MotionRegisters
from evcot_cosim.cli import main
from evcot_cosim.devices.device import Device, build_device
from evcot_cosim.devices.top_device import configuration
from evcot_cosim.names import Top

CONFIG = CotConfig(Shape(n_slots=1), motion=MotionRegisters(enable=1))
RULE = (
    "motion.enable = 1: must be 0 in hardware: the RTL does not have these rules yet, only the golden model has "
    "(evcot track --engine cot)"
)


@pytest.mark.parametrize("top", ["cot", "cot_array", "cot_chain"])
def test_no_rtl_is_built_with_motion(top: Top) -> None:
    for build in (build_device, Device):
        with pytest.raises(ConfigError) as caught:
            build(CONFIG, top)
        assert str(caught.value) == RULE


def test_registers_are_not_written_to_a_top_without_them() -> None:
    with pytest.raises(ConfigError) as caught:
        configuration(CONFIG)
    assert str(caught.value) == RULE
    assert configuration(replace(CONFIG, motion=MotionRegisters()))


@pytest.mark.parametrize("command", [["cosim", "-o", "out"], ["bench"]])
def test_a_command_says_so_and_leaves_nothing(
    command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main([*command, "--preset", "motion"]) == 2
    assert capsys.readouterr().err.strip() == f"evcot: {RULE}"
    assert list(tmp_path.iterdir()) == []
