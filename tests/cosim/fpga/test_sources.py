# SPDX-License-Identifier: Apache-2.0
"""Modules as one text: what it holds, and that comments do not change it."""

from __future__ import annotations

from pathlib import Path

import pytest

from evcot.errors import ConfigError
from evcot_cosim.fpga.sources import built, closure, flat, logic, without_comments
from evcot_cosim.rtl.files import copy_rtl, modules, rtl_files


def test_a_module_comes_with_all_below_it_and_after_them() -> None:
    assert closure(["cot"]) == ["parameter_check", "cot_window", "cot_regs", "cot_axis", "cot"]
    assert closure(["filter_region"])[-1] == "filter_region"
    assert closure(modules()) == modules()


def test_a_module_that_is_only_spoken_of_does_not_come() -> None:
    assert "multiplier" in rtl_files()["weighted_mean.v"].read_text()
    assert "multiplier" not in closure(["weighted_mean"])


def test_an_unknown_module_is_named() -> None:
    with pytest.raises(ConfigError, match=r"^module cto: not in manifest.txt, which has parameter_check, "):
        closure(["cto"])


def test_comments_go_and_strings_stay() -> None:
    text = 'wire a; // one\n\n/* two\n lines */ initial $display("// no comment"); // three\n'
    assert without_comments(text) == 'wire a;\n  initial $display("// no comment");\n'


def test_what_a_comment_parts_stays_apart() -> None:
    text = "reg/* of */q;\n`define A 8'h/* two */ff // three\n`ifdef NONE // four\nwire \\/*a ; // five\n`endif\n"
    assert without_comments(text) == "reg q;\n`define A 8'h ff\n`ifdef NONE\nwire \\/*a ;\n`endif\n"


def test_modules_come_that_are_instantiated_and_no_others(tmp_path: Path) -> None:
    instances = "genvar i; generate for (i = 0; i < 2; i = i + 1) begin : row if (i) dff #(.W(1)) one (); end endgenerate"
    names = 'wire fifo; // divider\ninitial $display("lfsr"); skid_buffer u (.approach(1\'b0));'
    copy_rtl(tmp_path)
    (tmp_path / "parameter_check.v").write_text("module parameter_check (); endmodule\n")
    (tmp_path / "dff.v").write_text("module dff (); endmodule\n")
    (tmp_path / "skid_buffer.v").write_text("module skid_buffer (); parameter_check rule (); endmodule\n")
    (tmp_path / "cot.v").write_text(f"module cot ();\n{instances}\n{names}\nendmodule\n")
    assert closure(["cot"], tmp_path) == ["parameter_check", "dff", "skid_buffer", "cot"]


def test_what_parameters_leave_out_is_not_built(tmp_path: Path) -> None:
    choice = "generate if (FIFO == 1) skid_buffer u (); else dff u (); endgenerate"
    copy_rtl(tmp_path)
    for name in ("dff", "skid_buffer"):
        (tmp_path / f"{name}.v").write_text(f"module {name} (); endmodule\n")
    (tmp_path / "cot.v").write_text(f"module cot #(parameter FIFO = 0) ();\n{choice}\nendmodule\n")
    assert built("cot", {}, tmp_path) == ["dff", "cot"]
    assert built("cot", {"FIFO": 1}, tmp_path) == ["skid_buffer", "cot"]


def test_a_top_without_trackers_of_another_kind() -> None:
    array = built("evcot_top", {"TRACKER": 0})
    assert "cot_array" in array
    assert not {"cot_chain", "cot_motion"} & {*array}


def test_what_is_not_verilog_is_named_with_its_place(tmp_path: Path) -> None:
    copy_rtl(tmp_path)
    (tmp_path / "cot_window.v").write_text("module cot_window (;\nendmodule\n")
    for read in (lambda: closure(["cot"], tmp_path), lambda: flat(["cot_window"], tmp_path)):
        with pytest.raises(ConfigError) as told:
            read()
        assert str(told.value).startswith(f"{tmp_path / 'cot_window.v'}:1:20: error: ")


def test_includes_are_in_their_places_once() -> None:
    text = flat(closure(["cot"]))
    assert "`include" not in text
    assert text.count("`define EVCOT_ST_IDLE ") == 1
    assert text.index("`define EVCOT_ST_IDLE ") < text.index("module cot ")
    assert "lfsr_taps" in flat(closure(["lfsr"]))


def test_rules_to_prove_are_left_out() -> None:
    assert "cot_array_rules" in rtl_files()["cot_array.v"].read_text()
    assert "FORMAL" not in flat(modules(), comments=True)


def test_a_comment_changes_nothing_and_code_does(tmp_path: Path) -> None:
    copy_rtl(tmp_path)
    before = flat(closure(["cot"], tmp_path), tmp_path)
    axis = tmp_path / "cot_axis.v"
    axis.write_text("// said once more\n\n" + axis.read_text())
    assert flat(closure(["cot"], tmp_path), tmp_path) == before
    axis.write_text(axis.read_text().replace("wire", "wire ", 1))
    assert flat(closure(["cot"], tmp_path), tmp_path) != before


def test_the_logic_is_neither_rules_nor_constants_nor_layout(tmp_path: Path) -> None:
    copy_rtl(tmp_path)
    modules = closure(["filter_region"])
    before = logic(modules, tmp_path)
    assert "parameter_check" not in before
    assert "`" not in before
    region, header = tmp_path / "filter_region.v", tmp_path / "evcot_defs.vh"
    text = region.read_text()
    header.write_text(header.read_text().replace("`define", "`define EVCOT_ONE_MORE 7\n`define", 1))
    rule = "    parameter_check #(.OK(X_W >= 1)) ONE_MORE ();\n"
    region.write_text(text.replace("    wire drops =", f"{rule}    // said\n    wire\n        drops  ="))
    assert logic(modules, tmp_path) == before
    region.write_text(text.replace("s_event && enable", "s_event || enable"))
    assert logic(modules, tmp_path) != before


def test_the_logic_follows_the_value_of_a_constant(tmp_path: Path) -> None:
    copy_rtl(tmp_path)
    before = logic(["cot_regs"], tmp_path)
    header = tmp_path / "evcot_defs.vh"
    header.write_text(header.read_text().replace("5'd0", "5'd31"))
    assert logic(["cot_regs"], tmp_path) != before
