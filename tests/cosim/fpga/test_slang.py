# SPDX-License-Identifier: Apache-2.0
"""What slang refuses: strict tools do so, too."""

from __future__ import annotations

from pathlib import Path

from evcot_cosim.fpga.slang import elaboration_errors
from evcot_cosim.rtl.files import modules


def test_every_module_elaborates() -> None:
    assert [error for top in modules() for error in elaboration_errors(top)] == []


def test_net_used_before_its_declaration_is_refused(tmp_path: Path) -> None:
    (tmp_path / "late.v").write_text("module late (input a, output b);\n    assign b = c;\n    wire c = a;\nendmodule\n")
    (tmp_path / "manifest.txt").write_text("late.v\n")
    (error,) = elaboration_errors("late", tmp_path)
    assert error.startswith(f"{tmp_path}/late.v:2: ")
    assert "UsedBeforeDeclared" in error
    assert error.endswith("['c']")
