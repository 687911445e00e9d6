# SPDX-License-Identifier: Apache-2.0
"""`evcot plot` and `evcot render`: a figure of tracks for a paper, and a film of tracks over events."""

from __future__ import annotations

import argparse

from evcot.pictures.films import SUFFIXES, Look
from evcot.pictures.style import COLUMN_MM, KINDS

from .options import tracked_options
from .parsing import add_command, json_or_quiet, output_option

__all__ = ["add_plot", "add_render"]


_PLOT_EXAMPLES = """
evcot plot drive.aedat4 log.npz -o drive.pdf
evcot plot drive.aedat4 log.npz -o drive.svg --kind xy,alive --columns 2 --from 1000 --to 3000
evcot plot build/cosim/boxes -o boxes.png --kind tracks,lifetimes
"""


def add_plot(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    title = "draw a figure for a paper: tracks over events, positions over time, tracks alive, lifetimes"
    parser = add_command(commands, "plot", title, _PLOT_EXAMPLES, "drawings:draw")
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
    json_or_quiet(parser, "print what was written as JSON")


_RENDER_EXAMPLES = """
evcot render drive.aedat4 log.npz -o drive.mp4
evcot render drive.aedat4 log.npz -o slow.gif --from 1000 --to 1500 --speed 0.1 --fps 20
evcot render build/cosim/boxes -o boxes.mp4 --decay 10
evcot render drive.aedat4 log.npz -o drive.rrd # for Rerun's viewer
"""


def add_render(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    title = "make a film of tracks over events: MP4, GIF, or a recording for Rerun"
    parser = add_command(commands, "render", title, _RENDER_EXAMPLES, "drawings:film")
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
    json_or_quiet(parser, "print what was written as JSON", "no progress, print nothing")
