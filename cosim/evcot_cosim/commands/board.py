# SPDX-License-Identifier: Apache-2.0
"""`evcot board`: compare the records of a board with the golden model."""

from __future__ import annotations

import argparse

from ..fpga import RECORDS
from .parsing import add_command

__all__ = ["add"]


_EXAMPLES = """
evcot board /dev/ttyUSB1                         # its build and counters, and 256 records against the golden model
evcot board /dev/ttyUSB1 --records 10000 --json
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    board = add_command(commands, "board", "compare a board's records with the golden model, over its serial line", _EXAMPLES)
    board.add_argument("port", metavar="PORT", help="the line's device, such as /dev/ttyUSB1, or a URL of pyserial")
    board.add_argument("--records", type=int, default=RECORDS, metavar="N", help=f"records to compare (default: {RECORDS})")
    board.add_argument("--json", action="store_true", help="print one JSON object")
