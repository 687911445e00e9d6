# SPDX-License-Identifier: Apache-2.0
"""`evcot track`: a recording through one tracker, into a track log."""

from __future__ import annotations

import argparse

from evcot.tracks.suffixes import CSV, LOG_SUFFIXES

from .box_options import FORMATS_TEXT, clock_options
from .engine_options import engine_options
from .filter_options import filter_options
from .options import checkpoint_option, recording_options
from .parsing import add_command, input_path, output_option

__all__ = ["add"]

_EXAMPLES = """
evcot track drive.aedat4 -o log.npz              # no settings needed
evcot track drive.aedat4 --engine adaptive -o log.npz  # a tracker in software that works in another way
evcot track drive.aedat4 --engine rct --preset traffic -o log.npz
evcot track drive.aedat4 --boxes result.txt --frame-us 40000   # MOTChallenge, 25 frames a second
evcot track drive.raw --engine rct --preset traffic --set radius_px=12 --learn-hot-pixels --json
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(commands, "track", "track the objects in a recording", _EXAMPLES)
    parser.add_argument("recording", type=input_path, metavar="FILE", help="the recording, in any format that evcot reads")
    engine_options(parser)
    output_option(
        parser,
        "-o",
        "--output",
        suffixes=LOG_SUFFIXES,
        metavar="LOG",
        help="write the track log, .npz, .parquet or .csv (records alone)",
    )
    output_option(parser, "--csv", suffixes=(CSV,), metavar="LOG.csv", help="write its records as text, too")
    output_option(parser, "--boxes", metavar="FILE", help="write the tracks' boxes, one per frame (--frame-us)")
    parser.add_argument("--boxes-format", metavar="NAME", help=f"format of the boxes: {FORMATS_TEXT}")
    clock_options(parser, "the first event")
    recording_options(parser)
    filter_options(parser)
    checkpoint_option(parser)
    parser.add_argument("--json", action="store_true", help="print what was found as JSON instead of a table")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress, no table")
