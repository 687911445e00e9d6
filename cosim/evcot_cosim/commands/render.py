# SPDX-License-Identifier: Apache-2.0
"""`evcot render`: a film of tracks over events."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Sequence

from evcot.pictures.films import Look, render, side_of
from evcot.pictures.films.film import SUFFIXES, check_suffix, picture_times

from .parsing import add_command, output_option
from .progress import Progress
from .tracked import tracked_from, tracked_options

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
    output_option(parser, "-o", "--output", required=True, metavar="FILE", help=f"to write: {', '.join(SUFFIXES)}")
    parser.add_argument(
        "--speed", type=float, default=look.speed, metavar="X", help="of the recording (default: 1, real speed)"
    )
    parser.add_argument("--fps", type=float, default=look.fps, metavar="N", help=f"pictures per second (default: {look.fps:g})")
    decay = f"of the film, after which an event has faded to 1/e (default: {look.decay_ms:g})"
    parser.add_argument("--decay", type=float, default=look.decay_ms, metavar="MS", help=decay)
    width = f"enlarge small sensors to at least this (default: {look.width_px})"
    parser.add_argument("--width", type=int, default=look.width_px, metavar="PX", help=width)
    parser.add_argument("--json", action="store_true", help="print what was written as JSON")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress, print nothing")
    parser.set_defaults(command=_render)


def _render(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    look = Look(options.speed, options.fps, options.decay, options.width)
    check_suffix(options.output)
    begin_s = time.perf_counter()
    with tracked_from(options) as tracked:
        last_us = max(int(block.t_us[-1]) for block in tracked.blocks() if len(block))
        window = tracked.from_us, last_us
        total = len(picture_times(window, look))
        sides = [side_of(place, log.name, log.log) for place, log in enumerate(tracked.logs)]
        with Progress(options.output.name, total, enabled=not (options.quiet or options.json)) as progress:

            def told(pictures: int, t_us: int) -> None:
                rate = pictures / (time.perf_counter() - begin_s)
                progress.advance(pictures, f"{t_us / 1e6:.3f} s shown, {rate:.0f} pictures/s")

            render(tracked.blocks(), tracked.sensor, sides, options.output, window, look, told, force=options.force)
    took_s = time.perf_counter() - begin_s
    if options.json:
        print(json.dumps({"file": str(options.output), "pictures": total, "seconds": took_s}))
    elif not options.quiet:
        print(f"{options.output}: {total:,} pictures in {took_s:.1f} s")
    return 0
