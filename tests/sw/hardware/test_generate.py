# SPDX-License-Identifier: Apache-2.0
"""The generated files match contract.py, lfsr.py and the register maps, and the committed ones are up to date."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from evcot.errors import ConfigError
from evcot.filters.contract import FILTER_REGISTERS
from evcot.hardware.contract import RECORD, REGISTERS, SHAPE_RANGES, Mode, State
from evcot.hardware.generate import render, stale, write
from evcot.hardware.lfsr import TAPS
from evcot.hardware.registers import register_map
from evcot.tracks.log import Kind


def defines() -> dict[str, str]:
    return dict(re.findall(r"^`define (\w+) (\S+)", render()["hw/verilog/common/evcot_defs.vh"], re.MULTILINE))


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A source tree with nothing in it."""
    (tmp_path / "hw" / "verilog").mkdir(parents=True)
    return tmp_path


def test_codes_are_literals_of_one_width_per_group() -> None:
    found = defines()
    assert [found[f"EVCOT_ST_{state.name}"] for state in State] == [f"3'd{int(state)}" for state in State]
    assert [found[f"EVCOT_KIND_{kind.name}"] for kind in Kind] == [f"2'd{int(kind)}" for kind in Kind]
    assert [found[f"EVCOT_MODE_{mode.name}"] for mode in Mode] == [f"2'd{int(mode)}" for mode in Mode]
    assert [found[f"EVCOT_REG_{name.upper()}"] for name in REGISTERS] == [f"5'd{r.address}" for r in REGISTERS.values()]
    assert (found["EVCOT_ST_W"], found["EVCOT_KIND_W"], found["EVCOT_MODE_W"], found["EVCOT_REG_W"]) == ("3", "2", "2", "5")


def test_parameter_ranges_are_those_of_the_shape() -> None:
    found = defines()
    ranges = {name: (int(found[f"EVCOT_{name.upper()}_MIN"]), int(found[f"EVCOT_{name.upper()}_MAX"])) for name in SHAPE_RANGES}
    assert ranges == {name: (low, high) for name, (low, high, _) in SHAPE_RANGES.items()}


def test_the_tap_table_has_one_row_per_width() -> None:
    rows = re.findall(r"^ +(\d+): lfsr_taps = 64'h([0-9a-f]{16});", render()["hw/verilog/math/lfsr_taps.vh"], re.MULTILINE)
    taps = {int(width): [bit + 1 for bit in range(64) if int(mask, 16) >> bit & 1] for width, mask in rows}
    assert taps == {width: sorted(row) for width, row in TAPS.items()}


def test_the_decay_table_halves_in_32_steps() -> None:
    rows = re.findall(r"^ +5'd(\d+): decay_weight = 9'd(\d+);", render()["hw/verilog/filter/decay_table.vh"], re.MULTILINE)
    assert [(int(age), int(weight)) for age, weight in rows] == [(age, round(256 * 2 ** (-age / 32))) for age in range(32)]


def test_writes_only_what_is_stale_and_leaves_nothing_else(tree: Path) -> None:
    assert [path.relative_to(tree).as_posix() for path in write(tree)] == list(render())
    taps = tree / "hw" / "verilog" / "math" / "lfsr_taps.vh"
    taps.write_text("stale")
    assert stale(tree) == [taps]
    assert write(tree) == [taps]
    found = {path.relative_to(tree).as_posix(): path.read_text() for path in tree.rglob("*") if path.is_file()}
    assert found == render()


def test_refuses_what_is_no_source_tree(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="nowhere/hw/verilog: no such directory"):
        write(tmp_path / "nowhere")


def test_check_fails_on_a_stale_file_and_writes_nothing(tree: Path) -> None:
    command = [sys.executable, "-m", "evcot.hardware.generate", "--directory", str(tree)]
    check = subprocess.run([*command, "--check"], capture_output=True, text=True, check=False)
    assert (check.returncode, [path for path in tree.rglob("*") if path.is_file()]) == (1, [])
    assert (
        check.stdout.splitlines()[0]
        == f"{tree / 'hw/verilog/common/evcot_defs.vh'}: stale: run python -m evcot.hardware.generate"
    )
    assert subprocess.run(command, capture_output=True, check=False).returncode == 0
    assert subprocess.run([*command, "--check"], capture_output=True, check=False).returncode == 0


def test_the_c_header_compiles_and_says_what_the_contract_says(tmp_path: Path) -> None:
    compiler = shutil.which("gcc")
    if compiler is None:
        pytest.skip("gcc is not installed")
    slots = register_map().banks["slot"]
    told = {
        "EVCOT_SLOT(3, EVCOT_SLOT_RADIX_MAX)": slots.base + 3 * 4 * slots.words + 4 * REGISTERS["radix_max"].address,
        "EVCOT_FILTER_DECAY_RATE": register_map().banks["filter"].base + 4 * FILTER_REGISTERS["decay_rate"].address,
        "EVCOT_PUT(5, EVCOT_SOURCE_SELECT)": 5,
        "EVCOT_GET(0x12340000u, EVCOT_STATUS_HELD)": 0x1234,
        "sizeof(struct evcot_record)": RECORD.itemsize,
        "offsetof(struct evcot_record, support)": RECORD.fields["support"][1],
        "EVCOT_EVENT_Y(0x4000800000000007u)": 1,
        "EVCOT_EVENT_T(0x4000800000000007u)": 7,
        "EVCOT_EVENT_P(0x4000800000000007u)": 1,
        "EVCOT_OWNED_SEQ(0xffffffffffffffffu)": (1 << 29) - 1,
    }
    prints = "".join(f'printf("%lu\\n", (unsigned long)({text}));' for text in told)
    source = f'#include "evcot_regs.h"\n#include <stddef.h>\n#include <stdio.h>\nint main(void) {{ {prints} return 0; }}\n'
    (tmp_path / "evcot_regs.h").write_text(render()["hw/include/evcot_regs.h"])
    (tmp_path / "main.c").write_text(source)
    flags = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror"]
    subprocess.run([compiler, *flags, "main.c", "-o", "main"], cwd=tmp_path, check=True)
    out = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=True).stdout
    assert dict(zip(told, map(int, out.split()), strict=True)) == told


def test_the_published_map_is_that_of_the_published_hardware() -> None:
    found = dict(re.findall(r"^`define (\w+) (\S+)", render()["hw/verilog/published/published_regs.vh"], re.MULTILINE))
    addresses = {name.removeprefix("PUBLISHED_REG_"): value for name, value in found.items() if "_REG_" in name}
    assert list(addresses.values()) == [f"8'd{a}" for a in (127, 78, 79, 80, 81, 82, 86, 87, 88, 89, 90, 91)]
    assert found["PUBLISHED_RESET_MAX_TIME"] == "32'd20000000"
