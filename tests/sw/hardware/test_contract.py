# SPDX-License-Identifier: Apache-2.0
"""The contract's numbers, the layouts of streams, and the files generated from the contract and the register maps."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import ConfigError, RecordingError
from evcot.filters.contract import FILTER_REGISTERS
from evcot.hardware.config import SlotConfig
from evcot.hardware.contract import RECORD, REGISTERS, SHAPE_RANGES, Mode, Shape, State
from evcot.hardware.generate import render, stale, write
from evcot.hardware.lfsr import TAPS
from evcot.hardware.registers import register_map
from evcot.hardware.streams import pack_events, unpack, whole_numbers
from evcot.tracks.log import Kind
from support.refusals import refused

# The rest of a shape whose one field is at its lowest or highest.
ROOMY = {"tc_w": 1, "nev_w": 1, "tick_w": 1}


@pytest.mark.parametrize("name", SHAPE_RANGES)
def test_a_shape_takes_the_limits_and_nothing_beyond(name: str) -> None:
    low, high, meaning = SHAPE_RANGES[name]
    rest = {key: value for key, value in ROOMY.items() if key != name}
    for value in (low, high):
        assert getattr(Shape(**rest | {name: value}), name) == value
    for value in (low - 1, high + 1):
        with refused(ConfigError, f"shape.{name} = {value}: must be an integer from {low} to {high} ({meaning})"):
            Shape(**rest | {name: value})


def test_time_must_outlast_a_window_and_a_tick() -> None:
    assert [field.name for field in fields(Shape)] == list(SHAPE_RANGES)
    assert Shape(time_w=34).time_w == 34
    for changes, told in (
        ({"time_w": 33}, "time_w = 33: must be at least tc_w + nev_w = 34"),
        ({"time_w": 8, "tc_w": 4, "nev_w": 4, "tick_w": 9}, "time_w = 8: must be at least tick_w = 9"),
        ({"frac": 4.0}, "frac = 4.0: must be an integer"),
    ):
        with refused(ConfigError, start=f"shape.{told}"):
            Shape(**changes)  # type: ignore[arg-type]


@pytest.mark.parametrize(("n", "slot_w"), [(1, 1), (2, 1), (3, 2), (4, 2), (5, 3), (8, 3), (9, 4), (64, 6)])
def test_slot_numbers_and_addresses_are_as_wide_as_they_must_be(n: int, slot_w: int) -> None:
    assert Shape(n_slots=n).slot_w == slot_w
    assert (Shape(radix_w=5).r_w, Shape(radix_w=5).rel_w) == (6, 7)  # R up to 62, an address up to 124


def test_register_limits_follow_the_shape() -> None:
    shape = Shape(x_w=7, y_w=6, radix_w=5, nev_w=9, tc_w=12)
    assert {name: register.limits(shape) for name, register in REGISTERS.items()} == {
        "mode": (0, 2),
        "init_cm_x": (0, 127),
        "init_cm_y": (0, 63),
        **dict.fromkeys(("init_radix", "radix_th", "radix_step", "radix_min", "radix_max"), (0, 31)),
        "hist_avg": (0, 8),
        "max_ticks": (1, 4095),
        **dict.fromkeys(("clust_nev", "nev_min", "nev_max"), (1, 511)),
        "nev_th": (0, 4095),
        "detect_ticks": (1, 4095),
    }
    assert REGISTERS["mode"].bits(shape) == 2
    assert len({register.address for register in REGISTERS.values()}) == len(REGISTERS)
    assert [field.name for field in fields(SlotConfig)] == list(REGISTERS)


def test_a_record_has_no_hidden_gaps_and_room_for_every_width() -> None:
    assert RECORD.itemsize == sum(RECORD[name].itemsize for name in RECORD.names or ()) == 48
    widest = {"seq": "seq_w", "time": "time_w", "track_id": "id_w", "other_id": "id_w", "support": "sup_w", "n_ev": "nev_w"}
    for field, width in widest.items():
        assert SHAPE_RANGES[width][1] <= 8 * RECORD[field].itemsize
    assert SHAPE_RANGES["x_w"][1] + SHAPE_RANGES["frac"][1] <= 8 * RECORD["cm_x"].itemsize
    assert np.iinfo(RECORD["slot"]).max >= SHAPE_RANGES["n_slots"][1]
    assert [kind.name for kind in Kind] == ["BORN", "MOVED", "MERGED", "LOST"]


def test_an_event_stands_in_its_word_as_documented() -> None:
    words = pack_events(np.array([5]), np.array([3]), np.array([2]), np.array([1]))
    assert words.tolist() == [1 << 62 | 2 << 47 | 3 << 32 | 5]
    words = pack_events(np.array([(1 << 32) + 7, -1]), *np.zeros((3, 2), np.int64))
    assert unpack("event", words)["t"].tolist() == [7, (1 << 32) - 1], "of a time the low bits"


def test_events_survive_packing() -> None:
    rng = np.random.default_rng(1)
    columns = [rng.integers(0, 1 << bits, 1_000) for bits in (32, 15, 15, 1)]
    found = unpack("event", pack_events(*columns))
    for name, column in zip("txyp", columns, strict=True):
        assert np.array_equal(found[name], column)


@pytest.mark.parametrize(("field", "value", "top"), [("x", 1 << 15, 32767), ("y", -1, 32767), ("p", 2, 1)])
def test_refuses_what_a_field_cannot_hold(field: str, value: int, top: int) -> None:
    columns = {name: np.zeros(3, np.int64) for name in "txyp"}
    columns[field][2] = value
    with pytest.raises(RecordingError, match=f"event 2: {field} = {value}: must be from 0 to {top}"):
        pack_events(*columns.values())


def test_numbers_become_whole_even_when_slightly_out_of_order() -> None:
    whole = np.array([14, 13, 15, 16, 18, 17, 24, 31, 32, 39])
    assert whole_numbers(whole % 16, 4, 14).tolist() == whole.tolist()
    assert whole_numbers(np.array([3, 5]), 4).tolist() == [3, 5]
    assert whole_numbers(np.empty(0, np.int64), 4).tolist() == []


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


def test_generated_tables_are_those_of_the_models() -> None:
    files = render()
    rows = re.findall(r"^ +(\d+): lfsr_taps = 64'h([0-9a-f]{16});", files["hw/verilog/math/lfsr_taps.vh"], re.MULTILINE)
    taps = {int(width): [bit + 1 for bit in range(64) if int(mask, 16) >> bit & 1] for width, mask in rows}
    assert taps == {width: sorted(row) for width, row in TAPS.items()}
    rows = re.findall(r"^ +5'd(\d+): decay_weight = 9'd(\d+);", files["hw/verilog/filter/decay_table.vh"], re.MULTILINE)
    assert [(int(age), int(weight)) for age, weight in rows] == [(age, round(256 * 2 ** (-age / 32))) for age in range(32)]


def test_writes_only_what_is_stale_and_leaves_nothing_else(tree: Path) -> None:
    assert [path.relative_to(tree).as_posix() for path in write(tree)] == list(render())
    taps = tree / "hw" / "verilog" / "math" / "lfsr_taps.vh"
    taps.write_text("stale")
    assert stale(tree) == [taps]
    assert write(tree) == [taps]
    found = {path.relative_to(tree).as_posix(): path.read_text() for path in tree.rglob("*") if path.is_file()}
    assert found == render()
    with pytest.raises(ConfigError, match="nowhere/hw/verilog: no such directory"):
        write(tree / "nowhere")


def test_check_fails_on_a_stale_file_and_writes_nothing(tree: Path) -> None:
    command = [sys.executable, "-m", "evcot.hardware.generate", "--directory", str(tree)]
    check = subprocess.run([*command, "--check"], capture_output=True, text=True, check=False)
    assert (check.returncode, [path for path in tree.rglob("*") if path.is_file()]) == (1, [])
    first = f"{tree / 'hw/verilog/common/evcot_defs.vh'}: stale: run python -m evcot.hardware.generate"
    assert check.stdout.splitlines()[0] == first
    write(tree)
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
