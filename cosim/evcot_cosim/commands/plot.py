# SPDX-License-Identifier: Apache-2.0
"""`evcot plot`: a figure of tracks for a paper."""

from __future__ import annotations

import argparse

from evcot.pictures.style import COLUMN_MM, KINDS

from .parsing import add_command, output_option
from .tracked import tracked_options

__all__ = ["add"]

_EXAMPLES = """
evcot plot drive.aedat4 log.npz -o drive.pdf
evcot plot drive.aedat4 log.npz -o drive.svg --kind xy,alive --columns 2 --from 1000 --to 3000
evcot plot build/cosim/boxes -o boxes.png --kind tracks,lifetimes
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    title = "draw a figure for a paper: tracks over events, positions over time, tracks alive, lifetimes"
    parser = add_command(commands, "plot", title, _EXAMPLES)
    tracked_options(parser)
    output_option(parser, "-o", "--output", required=True, metavar="FILE", help="what to write: .png, .svg or .pdf")
    parser.add_argument("--kind", default="tracks", metavar="KIND,...", help=f"panels: {', '.join(KINDS)} (default: tracks)")
    parser.add_argument(
        "--columns", type=int, choices=COLUMN_MM, default=1, help="width in columns of a paper, 85 or 178 mm (default: 1)"
    )
    parser.add_argument("--width", type=float, metavar="MM", help="another width, in place of --columns")
    parser.add_argument("--height", type=float, metavar="MM", help="height (default: what the panels need)")
    parser.add_argument(
        "--dpi",
        type=float,
        default=300,
        metavar="N",
        help="resolution of a PNG, and of images in the others (default: 300)",
    )
    parser.add_argument("--json", action="store_true", help="print what was written as JSON")
    parser.add_argument("-q", "--quiet", action="store_true", help="print nothing")
