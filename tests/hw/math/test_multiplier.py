# SPDX-License-Identifier: Apache-2.0
"""multiplier.v: a product with sign, two clocks later; its ECP5 body likewise."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot_cosim.rtl.build import load
from evcot_cosim.rtl.files import copy_rtl, verilog_dir

ECP5 = verilog_dir().parent / "fpga" / "ecp5" / "multiplier.v"
WIDTHS = {"A_W": 18, "B_W": 15}

# The cell as Lattice describes it, as far as the body uses it: each operand, and the product, may have a register.
CELL = """
    parameter REG_INPUTA_CLK = "", REG_INPUTA_CE = "", REG_INPUTA_RST = "", REG_INPUTB_CLK = "", REG_INPUTB_CE = "",
        REG_INPUTB_RST = "", REG_PIPELINE_CLK = "", REG_OUTPUT_CLK = "", REG_OUTPUT_CE = "", REG_OUTPUT_RST = "",
        SOURCEB_MODE = "", MULT_BYPASS = "", RESETMODE = "";
    wire signed [17:0] a = A_IN, b = B_IN;
    reg signed [17:0] a_1, b_1;
    reg signed [35:0] p_2;
    wire signed [18:0] a_2 = REG_INPUTA_CLK == "CLK0" ? {SIGNEDA && a_1[17], a_1} : {SIGNEDA && a[17], a};
    wire signed [18:0] b_2 = REG_INPUTB_CLK == "CLK0" ? {SIGNEDB && b_1[17], b_1} : {SIGNEDB && b[17], b};
    wire signed [37:0] p = a_2 * b_2;
    always @(posedge CLK0) if (CE0) {a_1, b_1, p_2} <= {a, b, p[35:0]};
    assign OUT = REG_OUTPUT_CLK == "CLK0" ? p_2 : p[35:0];
endmodule
"""


def cell() -> str:
    """A model of the multiplier with the pins that the body connects."""
    pins = re.findall(r"\.(\w+)\(", ECP5.read_text().partition(") u_multiplier (")[2].partition(");")[0])
    ports = [f"{'output' if re.fullmatch(r'P[0-9]+', pin) else 'input'} {pin}" for pin in pins]
    a, b, p = (
        "{" + ", ".join(f"{name}{i}" for i in reversed(range(width))) + "}" for name, width in (("A", 18), ("B", 18), ("P", 36))
    )
    body = CELL.replace("A_IN", a).replace("B_IN", b).replace("assign OUT", f"assign {p}")
    off = "".join(f"/* verilator lint_off UNUSED{what} */\n" for what in ("PARAM", "SIGNAL"))
    return f"{off}module MULT18X18D ({', '.join(ports)});{body}"


def with_cells(folder: Path, body: str) -> Path:
    """The RTL with this body of multiplier and a model of the cell."""
    copy_rtl(folder)
    (folder / "multiplier.v").write_text(body)
    (folder / "MULT18X18D.v").write_text(cell())
    return folder


def differences(sim: PyVerilator, clocks: int = 2_000) -> int:
    """Random numbers and the ends of their ranges: clocks at which the product was another one."""
    rng, wrong = np.random.default_rng(3), 0
    expected = 0
    for clock in range(clocks):
        a, b = (
            int(rng.choice([-1 << width - 1, (1 << width - 1) - 1, int(rng.integers(-1 << width - 1, 1 << width - 1))]))
            for width in WIDTHS.values()
        )
        sim.io.a, sim.io.b = a % (1 << WIDTHS["A_W"]), b % (1 << WIDTHS["B_W"])
        sim.clock.tick()
        wrong += clock > 1 and int(sim.io.p) != expected
        expected = a * b % (1 << sum(WIDTHS.values()))
    return wrong


def test_products_two_clocks_later() -> None:
    assert differences(load("multiplier", WIDTHS)) == 0


def test_products_of_the_ecp5_cell(tmp_path: Path) -> None:
    assert differences(load("multiplier", WIDTHS, verilog=with_cells(tmp_path / "rtl", ECP5.read_text()))) == 0


@pytest.mark.parametrize("right", ['REG_INPUTB_CLK  ("CLK0")', 'REG_OUTPUT_CLK  ("CLK0")', ".SIGNEDA(1'b1)"])
def test_a_wrong_cell_is_noticed(tmp_path: Path, right: str) -> None:
    wrong = right.replace("CLK0", "NONE").replace("1'b1", "1'b0")
    text = ECP5.read_text()
    assert text.count(right) == 1
    folder = with_cells(tmp_path / "rtl", text.replace(right, wrong))
    assert differences(load("multiplier", WIDTHS, verilog=folder)) > 100
