# SPDX-License-Identifier: Apache-2.0
"""Icarus Verilog, in which a register without a value is X: plays a program to `evcot_top`, with random stalls."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.hardware.contract import RECORD
from evcot_cosim.devices.top_device import Command
from evcot_cosim.rtl.files import search_flags

__all__ = [
    "Beats",
    "commands",
    "compile_icarus",
    "needs_icarus",
    "play_top",
    "quiet",
    "replay",
    "reset",
    "run_icarus",
    "words",
]

needs_icarus = pytest.mark.skipif(shutil.which("iverilog") is None, reason="Icarus Verilog is not installed")

_BENCH = Path(__file__).with_name("top_tb.v")
_WRITE, _POLL, _WORD, _QUIET, _RESET = 1, 2, 3, 4, 5
_OPERATIONS = {1: _WRITE, 2: _POLL}  # of a Command

Line = tuple[int, int, int]
"""Operation, address, data: a line of a program."""


class Beats(NamedTuple):
    """Whatever came out: records, owned and passed words, and the response to each write."""

    records: NDArray[np.void]
    owned: list[int]
    user: list[int]
    passed: list[int]
    responses: list[int]


def commands(given: Iterable[Command]) -> list[Line]:
    """The writes and polls of commands, in a program."""
    return [
        (_OPERATIONS[int(op)], address, data if _OPERATIONS[int(op)] == _WRITE else mask << 32 | data)
        for _, op, address, data, mask in given
    ]


def words(given: NDArray[np.uint64]) -> list[Line]:
    """Input words, in a program."""
    return [(_WORD, 0, int(word)) for word in given]


def quiet(clocks: int) -> Line:
    """Wait until nothing has come out for this long."""
    return _QUIET, 0, clocks


def reset() -> Line:
    """A reset of four clocks."""
    return _RESET, 0, 0


def compile_icarus(folder: Path, top: str, sources: Iterable[Path], parameters: Mapping[str, int]) -> Path:
    """Compile a test bench and the RTL; returns what `run_icarus` runs."""
    out = folder / f"{top}.vvp"
    settings = [f"-P{top}.{name}={value}" for name, value in parameters.items()]
    command = ["iverilog", "-g2005", "-o", str(out), "-s", top, *settings, *search_flags(), *map(str, sources)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return out


def run_icarus(compiled: Path, *plus: str) -> list[str]:
    """What a simulation prints, line by line."""
    done = subprocess.run(["vvp", "-n", str(compiled), *plus], capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def play_top(
    folder: Path, program: Iterable[Line], parameters: Mapping[str, int], seed: int, record: np.dtype[np.void] = RECORD
) -> Beats:
    """Play a program to `evcot_top`, whose records are of this dtype.

    Raises:
        AssertionError: a handshake line is X, some output has an X in its data, or the hardware stands still.
    """
    lines = [*program, (0, 0, 0)]
    path = folder / "program.hex"
    path.write_text("".join(f"{op << 96 | address << 64 | data:026x}\n" for op, address, data in lines))
    compiled = compile_icarus(folder, "top_tb", [_BENCH], {**parameters, "SEED": seed})
    printed = run_icarus(compiled, f"+program={path}")
    assert printed[-1] == "DONE", f"{printed[-1]}, {lines[int(printed[-1].split()[2].rstrip(':'))]}"
    found: dict[str, list[list[str]]] = {"RECORDS": [], "OWNED": [], "PASSED": [], "WRITTEN": []}
    for line in printed[:-1]:
        kind, *values = line.split()
        if kind in found:
            assert not set("".join(values)) & set("xXzZ"), line
            found[kind].append(values)
    beats = np.array([int(word, 16) for (word,) in found["RECORDS"]], np.uint64)
    return Beats(
        beats.view(np.uint8)[: len(beats) * 8].view(record),
        [int(word, 16) for word, _ in found["OWNED"]],
        [int(user, 16) for _, user in found["OWNED"]],
        [int(word, 16) for (word,) in found["PASSED"]],
        [int(code, 2) for (code,) in found["WRITTEN"]],
    )


def replay(
    folder: Path,
    top: str,
    parameters: Mapping[str, int],
    inputs: NDArray[np.void],
    outputs: np.dtype[np.void],
    deposits: Mapping[int, Mapping[str, int]] | None = None,
    ties: Mapping[str, int] | None = None,
) -> list[dict[str, str]]:
    """The output ports of a module just before each clock edge, in binary, for given input ports, none wider than its field.

    `deposits` are values that its registers are given at the beginning of a clock, `ties` those of inputs that do not change.
    """
    given = dict(inputs.dtype.fields or {})
    told = outputs.names or ()
    row_bits = 8 * inputs.dtype.itemsize
    settings = ", ".join(f".{name}({value})" for name, value in parameters.items())
    given_values = [(clock, name, value) for clock, values in (deposits or {}).items() for name, value in values.items()]
    widths = {name: 8 * outputs[name].itemsize for name in told}
    bench = f"""`timescale 1ns / 1ns
module replay;
    reg clk = 0;
    reg [{row_bits - 1}:0] rows [0:{len(inputs) - 1}];
    reg [{row_bits - 1}:0] row;
    {" ".join(f"wire [{width - 1}:0] {name};" for name, width in widths.items())}
    {top} #({settings}) dut (
        .clk(clk), {", ".join(f".{name}(row[{8 * at} +: {8 * kind.itemsize}])" for name, (kind, at, *_) in given.items())},
        {"".join(f".{name}({value}), " for name, value in (ties or {}).items())}
        {", ".join(f".{name}({name})" for name in told)}
    );
    integer i;
    initial begin
        $readmemh("{folder / "rows.hex"}", rows);
        for (i = 0; i < {len(inputs)}; i = i + 1) begin
            row = rows[i];
            {" ".join(f"if (i == {clock}) dut.{name} = {value};" for clock, name, value in given_values)}
            #1 $display("{" ".join("%b" for _ in told)}", {", ".join(told)});
            clk = 1;
            #1 clk = 0;
            #1;
        end
        $finish;
    end
endmodule
"""
    (folder / "replay.v").write_text(bench)
    numbers = (int.from_bytes(row.tobytes(), "little") for row in inputs)
    (folder / "rows.hex").write_text("".join(f"{number:0{row_bits // 4}x}\n" for number in numbers))
    printed = run_icarus(compile_icarus(folder, "replay", [folder / "replay.v"], {}))
    return [dict(zip(told, line.split(), strict=True)) for line in printed]
