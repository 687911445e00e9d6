# SPDX-License-Identifier: Apache-2.0
"""`evcot boxes`: tracks in the field's formats."""

from __future__ import annotations

import argparse

from .box_options import FORMATS_TEXT, clock_options
from .parsing import add_command, input_path, output_option

__all__ = ["add"]

_EXAMPLES = """
evcot boxes log.npz result.txt --frame-us 40000        # MOTChallenge, 25 frames a second
evcot boxes log.npz tracks.json --frame-us 40000 --origin-us 1718925184590631 --sensor 346x260
evcot boxes result.txt tracks_bbox.npy --frame-us 40000
evcot boxes log.npz tracks.mcap --frame-us 20000 --sensor 346x260   # for Foxglove; needs pip install evcot[mcap]
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(commands, "boxes", "write tracks as MOTChallenge text, COCO JSON, Prophesee boxes or MCAP", _EXAMPLES)
    parser.add_argument("source", type=input_path, metavar="A", help="a track log, or boxes in one of the formats")
    output_option(parser, "target", metavar="B", help="what to write")
    parser.add_argument("--source-format", metavar="NAME", help=f"format of A: {FORMATS_TEXT}; .npz is a track log")
    parser.add_argument("--format", metavar="NAME", help=f"format of B: {FORMATS_TEXT}")
    clock_options(parser, "0")
    parser.add_argument("--sensor", metavar="WxH", help="size in pixels, which COCO and MCAP state")
    parser.add_argument("--json", action="store_true", help="print what was written as JSON")
    parser.add_argument("-q", "--quiet", action="store_true", help="print nothing")
