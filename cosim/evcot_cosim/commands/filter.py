# SPDX-License-Identifier: Apache-2.0
"""`evcot filter A B`: a recording through the filters, into another recording."""

from __future__ import annotations

import argparse

from .filter_options import filter_options
from .options import recording_options
from .parsing import add_command, input_path, output_option

__all__ = ["add"]

_EXAMPLES = """
evcot filter drive.raw clean.raw --learn-hot-pixels --activity 5
evcot filter drive.aedat4 left.aedat4 --region 0,0,99,199 --polarity on
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(
        commands, "filter", "remove noise, hot pixels, or everything outside a region from a recording", _EXAMPLES
    )
    parser.add_argument("source", type=input_path, metavar="A", help="the recording, in any format that evcot reads")
    output_option(parser, "target", metavar="B", help="what to write; its suffix gives the format")
    recording_options(parser)
    parser.add_argument("--config", type=input_path, metavar="TOML", help="its table [filters] says what to filter")
    filter_options(parser)
    parser.add_argument("--json", action="store_true", help="print what was done as JSON instead of a table")
    parser.add_argument("-q", "--quiet", action="store_true", help="print nothing")
