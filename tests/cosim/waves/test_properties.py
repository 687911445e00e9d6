# SPDX-License-Identifier: Apache-2.0
"""Properties from a file: what holds, what is broken, and one line for a file that cannot be used."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.hardware.modules import Module
from evcot_cosim.waves import Wave
from evcot_cosim.waves.properties import judge, load_properties

HEAD = "from evcot_cosim.waves import *\n"


def written(folder: Path, text: str) -> Path:
    path = folder / "properties.py"
    path.write_text(HEAD + text)
    return path


def test_each_property_has_a_verdict_in_the_order_of_the_file(vcds: dict[Module, Path], tmp_path: Path) -> None:
    path = written(
        tmp_path,
        "def property_seldom(s): return sometime(s['TOP.m_cm_valid'])\n"
        "def helper(s): raise RuntimeError\n"
        "def property_never(s): return never(s['TOP.m_cm_valid'])\n"
        "def property_plain(s): assert len(s) == 0, 'has cycles'\n"
        "def property_bare(s): assert len(s) == 0\n",
    )
    seldom, broken, plain, bare = judge(load_properties(path), vcds["cot_array"], "TOP.clk")
    assert (seldom.name, seldom.holds, seldom.message) == ("seldom", True, "")
    assert seldom.cases > 0
    assert (broken.name, broken.holds) == ("never", False)
    assert re.match(r"never\(TOP\.m_cm_valid\): not false at ", broken.message)
    assert (plain.holds, plain.message) == (False, "has cycles")
    assert bare.message == "line 6: AssertionError"


def test_without_a_file_streams_hold_their_offers(vcds: dict[Module, Path], tmp_path: Path) -> None:
    (verdict,) = judge(load_properties(None), vcds["cot_array"], "TOP.clk")
    assert (verdict.name, verdict.holds) == ("streams_hold_their_offers", True)
    assert verdict.cases > 100

    offered = Wave.open(vcds["cot_array"]).sampled("TOP.clk")
    waits = np.flatnonzero((offered["TOP.m_cm_valid"] & ~offered["TOP.m_cm_ready"]).true)
    edge = offered.times[waits[len(waits) // 2] + 1]
    lines = vcds["cot_array"].read_text().splitlines(keepends=True)
    code = next(line.split()[3] for line in lines if line.split()[4:5] == ["m_cm_id"])
    lines.insert(lines.index(f"#{edge}\n"), f"b1010101010101010 {code}\n")  # another id, while the record waits
    (tmp_path / "x.vcd").write_text("".join(lines))
    (verdict,) = judge(load_properties(None), tmp_path / "x.vcd", "TOP.clk")
    assert not verdict.holds
    assert "m_cm_id changes, having been held since" in verdict.message


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("def property_x(s", "properties.py: line 2: '(' was never closed"),
        ("import nothing_like_this", "properties.py: line 2: No module named 'nothing_like_this'"),
        ("x = 1 / 0", "properties.py: line 2: division by zero"),
        ("raise SystemExit", "properties.py: line 2: SystemExit"),
        ("x = 1", "properties.py: holds no property: must have functions whose names begin with property_"),
        ("def property_x(): pass", "properties.py: property_x: must take one argument, the signals"),
    ],
)
def test_a_file_that_cannot_be_used(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigError) as error:
        load_properties(written(tmp_path, text))
    assert str(error.value) == f"{tmp_path}/{message}"


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"none\.py: cannot be read: No such file or directory"):
        load_properties(tmp_path / "none.py")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("always(s['TOP.nothing'])", "no signal TOP.nothing"),
        ("always(s['TOP.m_cm_slot'])", "TOP.m_cm_slot"),
        ("always(s['TOP.m_cm_slot'] / 2)", "unsupported operand"),
        ("s.what", "'Samples' object has no attribute 'what'"),
    ],
)
def test_a_property_that_makes_no_sense_is_named_with_its_line(
    text: str, message: str, vcds: dict[Module, Path], tmp_path: Path
) -> None:
    path = written(tmp_path, f"def property_x(s):\n    {text}\n")
    with pytest.raises(ConfigError) as error:
        judge(load_properties(path), vcds["cot_array"], "TOP.clk")
    assert str(error.value).startswith(f"{path}: line 3: ")
    assert message in str(error.value)
    assert "\n" not in str(error.value)
