# SPDX-License-Identifier: Apache-2.0
"""`evcot simulate`: a scene, a video or a folder of images into a recording, and the truth beside it."""

from __future__ import annotations

import argparse

from .parsing import add_command, input_or_name, output_option

__all__ = ["add"]

_EXAMPLES = """
evcot simulate highway -o highway.aedat4         # and highway.truth.csv beside it
evcot simulate discs -o discs.npz --seed 4 --duration 2 --set noise_hz=3
evcot simulate clip.mp4 -o clip.raw
evcot simulate highway --list                    # its settings
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(commands, "simulate", "simulate a scene, or make events of a video or images", _EXAMPLES)
    parser.add_argument(
        "scene",
        nargs="?",
        type=input_or_name,
        metavar="SCENE",
        help="a scene (see --list), a video file, or a folder of images",
    )
    output_option(parser, "-o", "--output", metavar="FILE", help="the recording to write; its suffix gives the format")
    output_option(
        parser, "--truth", suffixes=(".csv",), metavar="CSV", help="the truth of a scene (default: NAME.truth.csv beside FILE)"
    )
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="seed of all random numbers (default: 1)")
    parser.add_argument("--duration", type=float, metavar="S", help="length in seconds (default: the scene's; of a video, all)")
    parser.add_argument("--sensor", metavar="WxH", help="size in pixels (default: the scene's)")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="change a setting (see --list); may be repeated"
    )
    parser.add_argument("--list", action="store_true", help="list the scenes; with a scene, its settings")
    parser.add_argument("--json", action="store_true", help="print what was written, or the list, as JSON")
    parser.add_argument("-q", "--quiet", action="store_true", help="print nothing")
