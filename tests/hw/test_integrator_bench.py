# SPDX-License-Identifier: Apache-2.0
"""hw/fpga/examples/integrator_tb.v, plain Verilog written from the documents: run in Icarus, elaborated by Verilator."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from evcot_cosim.rtl.files import search_flags, verilog_dir
from evcot_cosim.rtl.toolchain import find_toolchain
from support.four_state import needs_icarus
from support.testing import broken_copy

BENCH = verilog_dir().parent / "fpga" / "examples" / "integrator_tb.v"


def icarus(folder: Path, verilog: Path) -> str:
    """What the bench prints in Icarus."""
    warnings = ["-Wall", "-Wno-sensitivity-entire-array", "-Wno-timescale"]
    command = ["iverilog", "-g2005", *warnings, *search_flags(verilog), "-s", "integrator_tb", "-o", "tb", str(BENCH)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    return subprocess.run(["vvp", "tb"], cwd=folder, capture_output=True, text=True, check=True, timeout=120).stdout


@needs_icarus
def test_it_passes_in_icarus(tmp_path: Path) -> None:
    assert icarus(tmp_path, verilog_dir()).splitlines()[0] == "PASS"


@needs_icarus
@pytest.mark.parametrize(
    ("file", "right", "wrong", "says"),
    [
        ("axis_records_out.v", "bytes[`EVCOT_RECORD_SUPPORT_LSB +: SUP_W] = s_cm_support;", "", "FAIL support"),
        ("axis_passed_out.v", "assign m_axis_tdata = word;", "assign m_axis_tdata = word << 1;", "FAIL passed.x"),
        ("axi_lite_words.v", "table_reg[31:0] <= id;", "table_reg[31:0] <= ~id;", "FAIL id"),
    ],
)  # fmt: skip
def test_it_notices_what_is_broken(tmp_path: Path, file: str, right: str, wrong: str, says: str) -> None:
    assert says in icarus(tmp_path, broken_copy(tmp_path / "rtl", file, right, wrong))


def test_verilator_elaborates_it(tmp_path: Path) -> None:
    tools = find_toolchain()
    command = [str(tools.executable), "--lint-only", "--timing", "-Wno-fatal", "--quiet", *search_flags(verilog_dir())]
    command += ["--top-module", "integrator_tb", str(BENCH)]
    done = subprocess.run(command, cwd=tmp_path, env=dict(tools.environment), capture_output=True, text=True, check=False)
    assert (done.returncode, "%Error" in done.stderr) == (0, False), done.stderr
