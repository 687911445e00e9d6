# SPDX-License-Identifier: Apache-2.0
"""`evcot toggles` as a user meets it: the table, SAIF, JSON, and what is refused."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from evcot_cosim.cli import main

from ..conftest import Refused

Capture = pytest.CaptureFixture[str]
pytestmark = pytest.mark.usefixtures("home")


def test_array_and_chain_on_the_same_events_and_the_arrays_saif(capsys: Capture) -> None:
    words = ["--hardware", "cot_array", "--beside", "cot_chain", "--saif", "array.saif", "--json"]
    assert main(["toggles", "boxes", "--to", "2", *words]) == 0
    array, chain = json.loads(capsys.readouterr().out)
    assert (array["module"], chain["module"]) == ("cot_array", "cot_chain")
    assert array["n_events"] == chain["n_events"] > 100
    assert array["n_clocks"] < chain["n_clocks"]  # 3 an event
    for one in (array, chain):
        for name in ("registers", "register_toggles", "wires", "wire_toggles"):
            assert one["whole"][name] == sum(module[name] for module in one["modules"].values()) > 0
        assert one["modules"]["cot_window"]["registers"] == 0  # combinational
    assert chain["modules"]["cot"]["instances"] == 8
    saif = Path("array.saif").read_text()
    assert saif.count("(") == saif.count(")")
    (clk,) = re.findall(r"\(INSTANCE cot_array\n\(NET\n\(clk .*\(TC (\d+)\)", saif)
    assert abs(int(clk) - 2 * array["n_clocks"]) <= 1
    assert r"(av_x\[0\]\[12\] (T0" in saif  # a memory's word
    assert r"(N\[0\]" not in saif  # a parameter


def test_the_table_ends_in_sums_and_clocks(capsys: Capture) -> None:
    assert main(["toggles", "boxes", "--hardware", "cot_array", "--to", "2"]) == 0
    *rows, whole, clocks = capsys.readouterr().out.splitlines()
    assert rows[0].split("  ")[0] == "hardware"
    assert re.match(r"cot_array  all  +[\d,]+ +\d+\.\d +[\d,]+ +\d+\.\d$", whole)
    assert re.match(r"cot_array: [\d,]+ events, \d\.\d\d clocks an event$", clocks)
    assert not any("parameter_check" in row for row in rows)


def test_memories_too_large_for_a_waveform_are_named(capsys: Capture) -> None:
    assert main(["toggles", "boxes", "--to", "2", "--preset", "discs", "--saif", "x.saif"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == (
        "cot_array: not counted, since too large for a waveform: memories, 1 of filter_refractory"
    )
    saif = Path("x.saif").read_text()
    assert "INSTANCE u_refractory" in saif
    assert "stamps" not in saif


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--beside", "cot_array"], "--beside cot_array: must be another module than --hardware"),
        (["--from", "5", "--to", "4"], "--to 4: must be after --from 5"),
        (["--to", "2000"], "--from 0 --to 2000: 3[0-9,]+ events: must be at most 200,000"),
        (["--saif", "there.saif"], "--saif there.saif: exists: "),
    ],
)
def test_what_cannot_be_counted_is_refused_in_one_line(words: list[str], message: str, refused: Refused) -> None:
    Path("there.saif").write_text("mine")
    assert re.match(message, refused("toggles", "boxes", "--hardware", "cot_array", *words))
    assert Path("there.saif").read_text() == "mine"
