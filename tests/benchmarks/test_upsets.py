# SPDX-License-Identifier: Apache-2.0
"""benchmarks/upsets.py: what becomes of an upset, and which names of a module are registers."""

from __future__ import annotations

import numpy as np
import pytest

import upsets

TEXT = """
module half #(parameter W = 4) (
    input wire clk, output reg out, output reg [W-1:0] count
);
    reg signed [3:0] a, b;
    reg [7:0] words [0:15];
    reg next;
    wire less = (b <= a);
    skid_buffer #(
        .W(3)
    ) u_one (
        .clk(clk)
    );
    generate
        if (W > 1) begin : g_some
            fifo u_two (
                .clk(clk)
            );
        end
    endgenerate
    always @* next = less;
    always @(posedge clk) begin
        {out, count} <= {next, count + 1'b1};
        words[a] <= b;
        if (less) a <= b;
    end
endmodule
"""


def test_registers_are_what_a_clock_assigns() -> None:
    assert upsets._registers(TEXT) == {"out", "count", "words", "a"}


def test_parts_are_instances_of_modules() -> None:
    assert dict(upsets._parts(TEXT, ("fifo", "skid_buffer"))) == {"u_one": "skid_buffer", "u_two": "fifo"}


@pytest.fixture
def bench() -> upsets.Bench:
    """Without hardware."""
    bench = object.__new__(upsets.Bench)
    bench.columns = {"cm": ["m_cm_id", "m_cm_seq"], "own": ["m_own_seq"], "pass": ["m_pass_seq", "m_pass_x"]}
    return bench


def run(clocks: int = 90, ids: tuple[int, ...] = (0, 0, 0), owned: tuple[int, ...] = (2, 900), x: int = 5) -> upsets.Run:
    cm = np.array([ids, (1, 800, 1_000)], np.uint64).T
    return upsets.Run(clocks, cm, np.array([owned], np.uint64).T, np.array([[4, 4], [1_100, x]], np.uint64))


@pytest.mark.parametrize(
    ("found", "fate"),
    [
        (run(clocks=70), "masked"),
        (run(clocks=-1), "hangs"),
        (run(owned=(3, 900)), "heals"),
        (run(ids=(9, 0, 0)), "heals"),
        (run(ids=(0, 0, 9)), "ids"),
        (run(owned=(2, 901)), "wrong"),
        (run(x=6), "wrong"),
    ],
)
def test_what_becomes_of_an_upset(bench: upsets.Bench, found: upsets.Run, fate: str) -> None:
    assert bench.fate(found, run()) == fate
