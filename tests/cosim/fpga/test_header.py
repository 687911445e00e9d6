# SPDX-License-Identifier: Apache-2.0
"""What is read of a module's header: expressions as written and with macros' values, the comment that belongs to each."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from evcot.errors import ConfigError, ToolchainError
from evcot_cosim.fpga.header import DeclaredPort, Header, Parameter, evaluate, read
from evcot_cosim.rtl.files import modules

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
    ],
)
def test_another_style_is_refused_with_its_place(tmp_path: Path, source: str, complaint: str) -> None:
    with pytest.raises(ConfigError) as told:
        header_of(tmp_path, source)
    assert str(told.value) == f"{tmp_path / 'taker.v'}: {complaint}"


@pytest.mark.parametrize(
    ("source", "complaint"),
    [
        ("module taker (input a;\nendmodule", "1:22: error: expected ')'"),
        ("\nmodule taker (input [`NONE:0] a); endmodule", "2:22: error: unknown macro or compiler directive '`NONE'"),
        ('`include "none.vh"\nmodule taker (input a); endmodule', "1:10: error: 'none.vh': No such file or directory"),
    ],
)
def test_what_is_not_verilog_is_refused_with_its_place(tmp_path: Path, source: str, complaint: str) -> None:
    with pytest.raises(ConfigError) as told:
        header_of(tmp_path, source)
    assert str(told.value) == f"{tmp_path / 'taker.v'}:{complaint}"


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
