# SPDX-License-Identifier: Apache-2.0
"""Makes the Verilog headers that carry what RTL and software share.

`python -m evcot.generate` writes them into hw/verilog; `--check` writes nothing and fails when one is stale.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path

import jinja2

from .contract import FILTER_REGISTERS, FILTER_SHAPE_RANGES, REGISTERS, SHAPE_RANGES, Filter, Kind, Mode, State
from .errors import ConfigError, EvcotError
from .filters.decay import CLOCK_FRAC, UNITS_PER_HALF_LIFE, weights
from .lfsr import TAPS, tap_mask
from .outputs import written_aside

__all__ = ["render_headers", "stale_headers", "write_headers"]

_VERILOG_DIR = Path(__file__).resolve().parents[2] / "hw" / "verilog"


@dataclass(frozen=True)
class _Codes:
    """One group of sized constants: `EVCOT_<prefix>_<name>`, all of one width."""

    prefix: str
    comment: str
    members: list[tuple[str, int]]

    @property
    def width(self) -> int:
        return max(1, max(value for _, value in self.members).bit_length())


def _codes(prefix: str, comment: str, enum: type[IntEnum]) -> _Codes:
    return _Codes(prefix, comment, [(member.name, int(member)) for member in enum])


def render_headers() -> dict[str, str]:
    """Returns file name -> text of every generated header."""
    templates = jinja2.Environment(
        loader=jinja2.PackageLoader("evcot"),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    registers = [(name, register.address) for name, register in REGISTERS.items()]
    filter_registers = [(name, register.address) for name, register in FILTER_REGISTERS.items()]
    enums = [
        _codes("ST", "States of the tracker FSM.", State),
        _codes("KIND", "Kinds of a record.", Kind),
        _codes("MODE", "How a slot starts a life: register `mode`.", Mode),
        _Codes("REG", "Word addresses of the registers of a slot.", registers),
        _codes("FILTER", "The filters of a chain, in their order: bits of `enable`.", Filter),
        _Codes("FREG", "Word addresses of the registers of a filter chain.", filter_registers),
    ]
    rows = [(width, tap_mask(width), taps) for width, taps in TAPS.items()]
    return {
        "evcot_defs.vh": templates.get_template("evcot_defs.vh.j2").render(
            shape_ranges=SHAPE_RANGES, filter_shape_ranges=FILTER_SHAPE_RANGES, enums=enums
        ),
        "decay_table.vh": templates.get_template("decay_table.vh.j2").render(
            units=UNITS_PER_HALF_LIFE, clock_frac=CLOCK_FRAC, weights=weights(0)[:UNITS_PER_HALF_LIFE]
        ),
        "lfsr_taps.vh": templates.get_template("lfsr_taps.vh.j2").render(rows=rows),
    }


def stale_headers(directory: Path = _VERILOG_DIR) -> list[Path]:
    """Returns the headers in `directory` that are missing or differ from what this package generates."""
    paths = [(directory / name, text) for name, text in render_headers().items()]
    return [path for path, text in paths if not path.is_file() or path.read_text(encoding="utf-8") != text]


def write_headers(directory: Path = _VERILOG_DIR) -> list[Path]:
    """Writes the stale headers of `directory`, each whole or not at all, and returns their paths.

    Raises:
        ConfigError: `directory` does not exist.
        OutputError: a header cannot be written.
    """
    if not directory.is_dir():
        raise ConfigError(f"{directory}: no such directory; headers are generated into hw/verilog of a source tree")
    headers = render_headers()
    stale = stale_headers(directory)
    for path in stale:
        with written_aside(path) as file:
            file.write(headers[path.name].encode())
    return stale


def _main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m evcot.generate", description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 when a header is stale")
    parser.add_argument("--directory", type=Path, default=_VERILOG_DIR, help="where the headers stand (default: hw/verilog)")
    options = parser.parse_args(arguments)
    try:
        paths = stale_headers(options.directory) if options.check else write_headers(options.directory)
    except EvcotError as error:
        print(f"evcot: {error}", file=sys.stderr)
        return 2
    for path in paths:
        print(f"{path}: {'stale: run python -m evcot.generate' if options.check else 'written'}")
    return 1 if options.check and paths else 0


if __name__ == "__main__":
    sys.exit(_main())
