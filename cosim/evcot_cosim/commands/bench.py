# SPDX-License-Identifier: Apache-2.0
"""`evcot bench`: how fast everything runs on this machine, on any recording. Comparison with references: benchmarks/run.py."""

from __future__ import annotations

import argparse

from .job import input_options
from .options import window_options
from .parsing import add_command

__all__ = ["add"]

_EXAMPLES = """
evcot bench                                      # the box experiment
evcot bench drive.aedat4 --to 2000 --json
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(commands, "bench", "measure how fast reading, filters, trackers and hardware run here", _EXAMPLES)
    input_options(parser)
    window_options(parser)
    parser.add_argument("--json", action="store_true", help="print the figures as JSON instead of a table")
