# SPDX-License-Identifier: Apache-2.0
"""The headers of the hardware self-tests. Run as a program, it writes them to hw/fpga."""

from __future__ import annotations

import sys

from evcot.outputs import written_aside

from . import board, selftest

__all__ = ["HEADERS"]

HEADERS = {"evcot_selftest.vh": selftest.header, "board_selftest.vh": board.header}
"""File in hw/fpga -> function that returns its text."""


def _main() -> int:
    for name, text in HEADERS.items():
        path = board.board_dir() / name
        with written_aside(path, force=True) as file:
            file.write(text().encode())
        print(f"{path}: written")
    return 0


if __name__ == "__main__":
    sys.exit(_main())
