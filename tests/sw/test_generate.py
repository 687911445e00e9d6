# SPDX-License-Identifier: Apache-2.0
"""The Verilog headers say what contract.py and lfsr.py say, and the committed ones are fresh."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from evcot.contract import REGISTERS, SHAPE_RANGES, Kind, Mode, State
from evcot.errors import ConfigError
from evcot.generate import render_headers, stale_headers, write_headers
from evcot.lfsr import TAPS


def defines() -> dict[str, str]:
    return dict(re.findall(r"^`define (\w+) (\S+)", render_headers()["evcot_defs.vh"], re.MULTILINE))


def test_the_committed_headers_are_fresh() -> None:
    assert stale_headers() == []


def test_codes_are_literals_of_one_width_per_group() -> None:
    found = defines()
    assert [found[f"EVCOT_ST_{state.name}"] for state in State] == [f"3'd{int(state)}" for state in State]
    assert [found[f"EVCOT_KIND_{kind.name}"] for kind in Kind] == [f"2'd{int(kind)}" for kind in Kind]
    assert [found[f"EVCOT_MODE_{mode.name}"] for mode in Mode] == [f"2'd{int(mode)}" for mode in Mode]
    assert [found[f"EVCOT_REG_{name.upper()}"] for name in REGISTERS] == [f"4'd{r.address}" for r in REGISTERS.values()]
    assert (found["EVCOT_ST_W"], found["EVCOT_KIND_W"], found["EVCOT_MODE_W"], found["EVCOT_REG_W"]) == ("3", "2", "2", "4")


def test_parameter_ranges_are_those_of_the_shape() -> None:
    found = defines()
    ranges = {name: (int(found[f"EVCOT_{name.upper()}_MIN"]), int(found[f"EVCOT_{name.upper()}_MAX"])) for name in SHAPE_RANGES}
    assert ranges == {name: (low, high) for name, (low, high, _) in SHAPE_RANGES.items()}


def test_the_tap_table_has_one_row_per_width() -> None:
    rows = re.findall(r"^ +(\d+): lfsr_taps = 64'h([0-9a-f]{16});", render_headers()["lfsr_taps.vh"], re.MULTILINE)
    taps = {int(width): [bit + 1 for bit in range(64) if int(mask, 16) >> bit & 1] for width, mask in rows}
    assert taps == {width: sorted(row) for width, row in TAPS.items()}


def test_the_decay_table_halves_in_32_steps() -> None:
    rows = re.findall(r"^ +5'd(\d+): decay_weight = 9'd(\d+);", render_headers()["decay_table.vh"], re.MULTILINE)
    assert [(int(age), int(weight)) for age, weight in rows] == [(age, round(256 * 2 ** (-age / 32))) for age in range(32)]


def test_writes_only_what_is_stale_and_leaves_nothing_else(tmp_path: Path) -> None:
    assert [path.name for path in write_headers(tmp_path)] == ["evcot_defs.vh", "decay_table.vh", "lfsr_taps.vh"]
    (tmp_path / "lfsr_taps.vh").write_text("stale")
    assert stale_headers(tmp_path) == [tmp_path / "lfsr_taps.vh"]
    assert write_headers(tmp_path) == [tmp_path / "lfsr_taps.vh"]
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == render_headers()


def test_refuses_a_missing_directory(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="nowhere: no such directory"):
        write_headers(tmp_path / "nowhere")


def test_check_fails_on_a_stale_header_and_writes_nothing(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "evcot.generate", "--directory", str(tmp_path)]
    check = subprocess.run([*command, "--check"], capture_output=True, text=True, check=False)
    assert (check.returncode, list(tmp_path.iterdir())) == (1, [])
    assert check.stdout.splitlines()[0] == f"{tmp_path / 'evcot_defs.vh'}: stale: run python -m evcot.generate"
    assert subprocess.run(command, capture_output=True, check=False).returncode == 0
    assert subprocess.run([*command, "--check"], capture_output=True, check=False).returncode == 0
