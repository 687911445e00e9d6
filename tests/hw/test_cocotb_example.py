# SPDX-License-Identifier: Apache-2.0
"""hw/fpga/examples/cocotb_evcot.py: evcot_top in a cocotb test, with the golden model as its reference, in Icarus."""

from __future__ import annotations

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from evcot_cosim.rtl.files import verilog_dir
from support.four_state import needs_icarus
from support.testing import broken_copy

EXAMPLE = Path(__file__).parents[2] / "hw" / "fpga" / "examples" / "cocotb_evcot.py"

pytestmark = [
    needs_icarus,
    pytest.mark.skipif(find_spec("cocotb") is None, reason="cocotb is not installed: pip install 'evcot[test]'"),
]


def run(folder: Path, verilog: Path) -> tuple[int, str]:
    """Exit code of the example, and what it prints."""
    command = [sys.executable, str(EXAMPLE), str(verilog)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def test_the_rtl_passes(tmp_path: Path) -> None:
    code, printed = run(tmp_path, verilog_dir())
    assert code == 0, printed
    assert "as the golden model has them" in printed
    assert "TESTS=1 PASS=1 FAIL=0" in printed


def test_a_fault_in_the_rtl_fails(tmp_path: Path) -> None:
    right = "assign m_axis_tdata = word;"
    code, printed = run(tmp_path, broken_copy(tmp_path / "rtl", "axis_passed_out.v", right, right.replace(";", " ^ 1;")))
    assert code == 1, printed
    assert "m_axis_passed: beat 0 is 0x" in printed
