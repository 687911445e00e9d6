# SPDX-License-Identifier: Apache-2.0
"""What is read of a module's header: expressions as written and with macros' values, the comment that belongs to each."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from evcot.errors import ConfigError, ToolchainError
from evcot_cosim.fpga.header import DeclaredPort, Header, Parameter, evaluate, read
from evcot_cosim.fpga.sources import built, closure, flat, logic, without_comments
from evcot_cosim.rtl.files import copy_rtl, modules, rtl_files

DEFINES = "`define WORD_W 16\n"
SOURCE = """\
// SPDX-License-Identifier: Apache-2.0
// Takes words, gives bits. For this test.
//
// Stall: none.
`default_nettype none
`include "defs.vh"
// not of the header

module taker #(
    // bits of a word, or of half a one
    parameter W = `WORD_W,
    parameter [3:0] H = (W > 1) ? W/2 : 1,

    parameter DEPTH = 4, DEPTH_W = $clog2(DEPTH)  // derived: leave it alone
) (
    input  wire                clk,

    // words,
    // lowest first
    input  wire [W-1:0]        s_data,  // a word
    input  wire                s_first, s_last, // its place
    output wire                s_ready,

    output reg  [`WORD_W+1:0]  do  /* no remark */
);
    wire logic;  // a name in Verilog-2005
endmodule
"""


def header_of(folder: Path, source: str, top: str = "taker") -> Header:
    (folder / "defs.vh").write_text(DEFINES)
    (folder / f"{top}.v").write_text(source)
    return read(top, folder)


def test_all_of_a_header_is_read(tmp_path: Path) -> None:
    header = header_of(tmp_path, SOURCE)
    assert header.comment == ("Takes words, gives bits. For this test.", "", "Stall: none.")
    assert header.title == "Takes words, gives bits"
    group = "bits of a word, or of half a one"
    assert header.parameters == (
        Parameter("W", "16", "`WORD_W", group),
        Parameter("H", "(W > 1) ? W/2 : 1", "(W > 1) ? W/2 : 1", group),
        Parameter("DEPTH", "4", "4", "derived: leave it alone"),
        Parameter("DEPTH_W", "$clog2(DEPTH)", "$clog2(DEPTH)", "derived: leave it alone"),
    )
    words = "words, lowest first"
    assert header.ports == (
        DeclaredPort("clk", "in", None, "", "", ""),
        DeclaredPort("s_data", "in", "W-1", "[W-1:0]", "a word", words),
        DeclaredPort("s_first", "in", None, "", "its place", words),
        DeclaredPort("s_last", "in", None, "", "its place", words),
        DeclaredPort("s_ready", "out", None, "", "", words),
        DeclaredPort("do", "out", "16+1", "[`WORD_W+1:0]", "", ""),
    )
    assert header.values({}) == {"W": 16, "H": 8, "DEPTH": 4, "DEPTH_W": 2}
    assert header.values({"W": 1, "DEPTH": 5}) == {"W": 1, "H": 1, "DEPTH": 5, "DEPTH_W": 3}


def test_every_module_can_be_read() -> None:
    headers = [read(top) for top in modules()]
    assert all(header.title for header in headers)
    assert sum(len(header.ports) for header in headers) > 1000


@pytest.mark.parametrize(
    ("source", "complaint"),
    [
        ("module taker (inout a); endmodule", "port a: inout: neither input nor output"),
        ("module taker (input [3:1] a); endmodule", "port a: [3:1]: not one range that ends at 0"),
        ("module taker (input a [3:0][1:0]); endmodule", "port a: [3:0][1:0]: not one range that ends at 0"),
        ("module taker (input [3] a); endmodule", "port a: [3]: not one range that ends at 0"),
        ("module taker (input .a(b)); endmodule", "port input .a(b): has another name inside the module"),
        ("module taker (a); input a; endmodule", "module taker: its ports are not declared in the parentheses behind its name"),
        ("module taker #(parameter A) (input a); endmodule", "parameter A: has no default"),
        ("module other (input a); endmodule", "no module taker"),
        # What is no Verilog.
        ("module taker (input a;\nendmodule", "1:22: error: expected ')'"),
        ("\nmodule taker (input [`NONE:0] a); endmodule", "2:22: error: unknown macro or compiler directive '`NONE'"),
        ('`include "none.vh"\nmodule taker (input a); endmodule', "1:10: error: 'none.vh': No such file or directory"),
    ],
)
def test_another_style_is_refused_with_its_place(tmp_path: Path, source: str, complaint: str) -> None:
    with pytest.raises(ConfigError) as told:
        header_of(tmp_path, source)
    assert str(told.value).removeprefix(f"{tmp_path / 'taker.v'}:").lstrip() == complaint


def test_a_module_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=rf"^module taker: no taker\.v in {tmp_path}$"):
        read("taker", tmp_path)


@pytest.mark.parametrize(
    ("expression", "value"),
    [("N + 1", 9), ("-7/2", -3), ("(N > 1) ? $clog2(N) : 1", 3), ("(N > 8) ? 5 : N%3", 2), ("1 << N", 256), ("4'd9", 9)],
)
def test_expressions_have_verilogs_values(expression: str, value: int) -> None:
    assert evaluate(expression, {"N": 8}) == value


@pytest.mark.parametrize("expression", ["M", "N +", "$clog2(N", "1.5", "N/0"])
def test_what_has_no_value_is_refused(expression: str) -> None:
    with pytest.raises(ConfigError) as told:
        evaluate(expression, {"N": 8})
    assert str(told.value) == f"expression {expression}: no whole number from N"


def test_without_the_reader_of_verilog_it_names_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyslang", None)
    with pytest.raises(ToolchainError, match=r"^pyslang: not installed: pip install 'evcot\[fpga\]'$"):
        read("dff")


def test_a_module_comes_with_all_below_it_and_after_them() -> None:
    assert closure(["cot"]) == ["parameter_check", "cot_window", "cot_regs", "cot_axis", "cot"]
    assert closure(["filter_region"])[-1] == "filter_region"
    assert closure(modules()) == modules()
    with pytest.raises(ConfigError, match=r"^module cto: not in manifest.txt, which has parameter_check, "):
        closure(["cto"])


def test_a_module_that_is_only_spoken_of_does_not_come() -> None:
    assert "multiplier" in rtl_files()["weighted_mean.v"].read_text()
    assert "multiplier" not in closure(["weighted_mean"])


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
    for expand in (lambda: closure(["cot"], tmp_path), lambda: flat(["cot_window"], tmp_path)):
        with pytest.raises(ConfigError) as told:
            expand()
        assert str(told.value).startswith(f"{tmp_path / 'cot_window.v'}:1:20: error: ")


def test_includes_are_in_their_places_once() -> None:
    text = flat(closure(["cot"]))
    assert "`include" not in text
    assert text.count("`define EVCOT_ST_IDLE ") == 1
    assert text.index("`define EVCOT_ST_IDLE ") < text.index("module cot ")
    assert "lfsr_taps" in flat(closure(["lfsr"]))


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
