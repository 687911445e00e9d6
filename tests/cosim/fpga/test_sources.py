# SPDX-License-Identifier: Apache-2.0
"""Modules as one text: what it holds, and that comments do not change it."""

from __future__ import annotations

from pathlib import Path

import pytest

from evcot.errors import ConfigError
from evcot_cosim.build.rtl import copy_rtl, modules, rtl_files
from evcot_cosim.fpga.sources import closure, flat, without_comments


def test_a_module_comes_with_all_below_it_and_after_them() -> None:
    assert closure(["cot"]) == ["parameter_check", "approach", "cot_window", "cot_regs", "cot_update", "cot"]
    assert closure(["filter_region"])[-1] == "filter_region"
    assert closure(modules()) == modules()


def test_a_module_that_is_only_spoken_of_does_not_come() -> None:
    assert "skid_buffer" in rtl_files()["cot.v"].read_text()
    assert "skid_buffer" not in closure(["cot"])


def test_an_unknown_module_is_named() -> None:
    with pytest.raises(ConfigError, match=r"^module cto: not in manifest.txt, which has parameter_check, "):
        closure(["cto"])


def test_comments_go_and_strings_stay() -> None:
    text = 'wire a; // one\n\n/* two\n lines */ initial $display("// no comment"); // three\n'
    assert without_comments(text) == 'wire a;\n  initial $display("// no comment");\n'


def test_includes_are_in_their_places_once() -> None:
    text = flat(closure(["cot"]))
    assert "`include" not in text
    assert text.count("`define EVCOT_ST_IDLE ") == 1
    assert text.index("`define EVCOT_ST_IDLE ") < text.index("module cot ")
    assert "lfsr_taps" in flat(closure(["lfsr"]))


def test_a_comment_changes_nothing_and_code_does(tmp_path: Path) -> None:
    copy_rtl(tmp_path)
    before = flat(closure(["cot"], tmp_path), tmp_path)
    update = tmp_path / "cot_update.v"
    update.write_text("// said once more\n\n" + update.read_text())
    assert flat(closure(["cot"], tmp_path), tmp_path) == before
    update.write_text(update.read_text().replace("wire", "wire ", 1))
    assert flat(closure(["cot"], tmp_path), tmp_path) != before
