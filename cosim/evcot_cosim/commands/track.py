# SPDX-License-Identifier: Apache-2.0
"""`evcot track`: a recording through one tracker, into a track log."""

from __future__ import annotations

import argparse

from .engine_options import engine_options
from .filter_options import filter_options
from .options import recording_options
from .parsing import add_command, input_path, output_option

__all__ = ["add"]

_EXAMPLES = """
evcot track drive.aedat4 -o log.npz              # nothing to set
evcot track drive.aedat4 --engine kalman --preset traffic -o log.npz
evcot track drive.raw --engine rct --preset traffic --set radius_px=12 --learn-hot-pixels --json
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(commands, "track", "track the objects in a recording", _EXAMPLES)
    parser.add_argument("recording", type=input_path, metavar="FILE", help="the recording, in any format that evcot reads")
    engine_options(parser)
    output_option(parser, "-o", "--output", metavar="LOG.npz", help="write the track log")
    output_option(parser, "--csv", metavar="LOG.csv", help="write its records as text")
    recording_options(parser)
    filter_options(parser)
    parser.add_argument("--json", action="store_true", help="print what was found as JSON instead of a table")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress, no table")
