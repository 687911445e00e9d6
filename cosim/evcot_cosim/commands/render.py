# SPDX-License-Identifier: Apache-2.0
"""`evcot render`: a film of tracks over events."""

from __future__ import annotations

import argparse

from evcot.pictures.films.look import SUFFIXES, Look

from .parsing import add_command, output_option
from .tracked import tracked_options

__all__ = ["add"]

_EXAMPLES = """
evcot render drive.aedat4 log.npz -o drive.mp4
evcot render drive.aedat4 log.npz -o slow.gif --from 1000 --to 1500 --speed 0.1 --fps 20
evcot render build/cosim/boxes -o boxes.mp4 --decay 10
evcot render drive.aedat4 log.npz -o drive.rrd # for Rerun's viewer
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    title = "make a film of tracks over events: MP4, GIF, or a recording for Rerun"
    parser = add_command(commands, "render", title, _EXAMPLES)
    look = Look()
    tracked_options(parser)
    output_option(parser, "-o", "--output", required=True, metavar="FILE", help=f"what to write: {', '.join(SUFFIXES)}")
    parser.add_argument(
        "--speed", type=float, default=look.speed, metavar="X", help="playback speed of the recording (default: 1, real speed)"
    )
    parser.add_argument("--fps", type=float, default=look.fps, metavar="N", help=f"pictures per second (default: {look.fps:g})")
    decay = f"time, in the film, in which an event fades to 1/e (default: {look.decay_ms:g})"
    parser.add_argument("--decay", type=float, default=look.decay_ms, metavar="MS", help=decay)
    width = f"enlarge the picture of a small sensor to at least this width (default: {look.width_px})"
    parser.add_argument("--width", type=int, default=look.width_px, metavar="PX", help=width)
    parser.add_argument("--json", action="store_true", help="print what was written as JSON")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress, print nothing")
