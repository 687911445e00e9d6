# SPDX-License-Identifier: Apache-2.0
"""random_mutants.py: which places of Verilog and Python are mutated, and how."""

from __future__ import annotations

from random_mutants import python_mutants, rtl_mutants

MODULE = """\
module counter #(
    parameter W = 4 - 1
) (
    input  wire         clk,
    output reg  [W-1:0] count  // + 1
);
    localparam LAST = 4'd9;
    always @(posedge clk) begin
        if (count <= LAST) count <= count + 4'd15;
        for (k = 0; k < 3; k = k + 1) `MACRO(k)
    end
endmodule
"""
FUNCTION = '''\
LIMIT = 3


def clamp(value: int, unit: str = "µm") -> int:
    """Add 1 + 1."""
    if value > LIMIT and unit == "µm":  # 2 * 2
        raise ValueError(f"{value + 1}")
    return value * 2
'''


def test_verilog_is_mutated_in_its_statements_alone() -> None:
    assert {mutant.describe(MODULE) for mutant in rtl_mutants("counter.v", MODULE)} == {
        "counter.v:9: count <= LAST -> !(count <= LAST)",
        "counter.v:9: <= -> <",
        "counter.v:9: count <= count + 4'd15; -> ;",
        "counter.v:9: + -> -",
        "counter.v:9: 4'd15 -> 4'd0",
    }


def test_python_is_mutated_in_function_bodies_alone() -> None:
    assert {mutant.describe(FUNCTION) for mutant in python_mutants("clamp.py", FUNCTION)} == {
        'clamp.py:6: value > LIMIT and unit == "µm" -> (not (value > LIMIT and unit == "µm"))',
        "clamp.py:6: and -> or",
        "clamp.py:6: > -> >=",
        "clamp.py:6: == -> !=",
        "clamp.py:8: * -> +",
        "clamp.py:8: 2 -> 3",
    }


def test_a_mutant_differs_in_its_place_alone() -> None:
    (last,) = [one for one in python_mutants("clamp.py", FUNCTION) if one.wrong == "3"]
    assert last.text(FUNCTION) == FUNCTION.replace("value * 2", "value * 3")
