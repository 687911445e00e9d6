# SPDX-License-Identifier: Apache-2.0
"""`evcot info` and `evcot convert`: what is in a recording, and the same recording in another format."""

from __future__ import annotations

import argparse

from evcot.recordings.formats import WRITABLE_NAMES

from .options import recording_options
from .parsing import add_command, input_path, output_option

__all__ = ["add"]

_EXAMPLES_INFO = """
evcot info drive.aedat4
evcot info drive.raw --from 1000 --to 2000 --json
"""

_EXAMPLES_CONVERT = """
evcot convert drive.bag drive.aedat4
evcot convert drive.aedat4 part.csv --from 500 --to 900
evcot convert events.txt drive.raw --format evt3 --sensor 640x480
zcat events.txt.gz | evcot convert - - --format npz > drive.npz
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the commands to the command line."""
    info = add_command(commands, "info", "describe a recording: sensor, length, rates, busiest pixels", _EXAMPLES_INFO)
    info.add_argument("recording", type=input_path, metavar="FILE", help="a recording in any format that evcot reads")
    recording_options(info)
    info.add_argument("--json", action="store_true", help="print every figure as JSON")

    convert = add_command(commands, "convert", "write a recording, or a part of it, in another format", _EXAMPLES_CONVERT)
    convert.add_argument("source", type=input_path, metavar="A", help="a recording in any format that evcot reads")
    output_option(convert, "target", metavar="B", help="what to write; its suffix gives the format")
    convert.add_argument("--format", metavar="NAME", help=f"{', '.join(WRITABLE_NAMES)} (default: by B's suffix)")
    recording_options(convert)
    convert.add_argument("--json", action="store_true", help="print what was written as JSON")
    convert.add_argument("-q", "--quiet", action="store_true", help="print nothing")
