# SPDX-License-Identifier: Apache-2.0
"""`evcot live`: events tracked and shown while they happen."""

from __future__ import annotations

import argparse

from ..live import PORT
from .engine_options import engine_options
from .options import filter_options, recording_options
from .parsing import add_command, input_or_name, output_option

__all__ = ["add"]


_EXAMPLES = """
evcot live drive.aedat4                        # a file in real time, in the terminal
evcot live drive.aedat4 --web --speed 0.5      # and on a page, at half speed; engine and place are chosen there
evcot live drive.aedat4 --web --with-hardware  # hardware in simulation beside the software tracker
evcot live tcp://127.0.0.1:7777 --engine rct --preset traffic --save seen.aedat4
evcot live camera --web                        # needs pip install evcot[camera]
evcot live drive.aedat4 --json
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    title = "track and show events while they happen: a file at real speed, a network stream, a camera"
    parser = add_command(commands, "live", title, _EXAMPLES)
    source = "a recording; tcp://HOST:PORT, where DV or dv-processing sends AEDAT4; camera, or camera:SERIAL"
    parser.add_argument("source", type=input_or_name, metavar="SOURCE", help=source)
    parser.add_argument(
        "--speed", type=float, default=1.0, metavar="X", help="playback speed of a recording (default: 1, real speed)"
    )
    parser.add_argument("--web", nargs="?", type=int, const=PORT, metavar="PORT", help=f"show a page (default port: {PORT})")
    parser.add_argument(
        "--bind", metavar="ADDRESS", help="address that serves the page (default: 127.0.0.1, this machine only)"
    )
    beside = "run the hardware beside the engine: RTL in simulation while it keeps up, else its golden model"
    parser.add_argument("--with-hardware", action="store_true", help=beside)
    parser.add_argument("--loop", action="store_true", help="play a recording again and again")
    output_option(
        parser, "--save", metavar="FILE", help="record everything received: .aedat4 or .raw; readable even after a kill"
    )
    output_option(parser, "--save-log", suffixes=(".npz",), metavar="LOG.npz", help="write the track log when the run ends")
    parser.add_argument("--for", dest="for_s", type=float, metavar="S", help="stop after so many seconds")
    engine_options(parser)
    recording_options(parser)
    filter_options(parser)
    parser.add_argument("--json", action="store_true", help="print a line of figures a second, and one at the end")
    parser.add_argument("-q", "--quiet", action="store_true", help="no dashboard, no table")
