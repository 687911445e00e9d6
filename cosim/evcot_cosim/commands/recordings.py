# SPDX-License-Identifier: Apache-2.0
"""Commands about recordings: `evcot info`, `convert`, `filter` and `simulate`."""

from __future__ import annotations

import argparse

from evcot.recordings.formats import WRITABLE_NAMES

from .options import filter_options, recording_options
from .parsing import add_command, input_each, input_or_name, input_path, json_or_quiet, output_option

__all__ = ["add_filter", "add_recordings", "add_simulate"]


_EXAMPLES_INFO = """
evcot info drive.aedat4
evcot info drive.raw --from 1000 --to 2000 --json
evcot info *.aedat4
"""

_EXAMPLES_CONVERT = """
evcot convert drive.bag drive.aedat4
evcot convert drive.aedat4 part.csv --from 500 --to 900
evcot convert a.bag b.bag c.raw npz --format npz   # npz/a.npz, npz/b.npz, npz/c.npz
evcot convert events.txt drive.raw --format evt3 --sensor 640x480
zcat events.txt.gz | evcot convert - - --format npz > drive.npz
"""


def add_recordings(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the commands to the command line."""
    info = add_command(commands, "info", "describe a recording: sensor, length, rates, busiest pixels", _EXAMPLES_INFO)
    info.add_argument(
        "recordings", nargs="+", type=input_each, metavar="FILE", help="recordings in any format that evcot reads"
    )
    recording_options(info)
    info.add_argument("--json", action="store_true", help="print every figure as JSON")

    convert = add_command(commands, "convert", "write a recording, or a part of it, in another format", _EXAMPLES_CONVERT)
    convert.add_argument("sources", nargs="+", type=input_each, metavar="A", help="recordings in any format that evcot reads")
    target = "what to write; its suffix gives the format. Of several recordings a folder, for a file of the same name for each"
    output_option(convert, "target", metavar="B", several="sources", help=target)
    formats = f"{', '.join(WRITABLE_NAMES)} (default: by B's suffix; must be given with several recordings)"
    convert.add_argument("--format", metavar="NAME", help=formats)
    recording_options(convert)
    json_or_quiet(convert, "print what was written as JSON")


_FILTER_EXAMPLES = """
evcot filter drive.raw clean.raw --learn-hot-pixels --activity 5
evcot filter drive.aedat4 left.aedat4 --region 0,0,99,199 --polarity on
"""


def add_filter(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(
        commands, "filter", "remove noise, hot pixels, or everything outside a region from a recording", _FILTER_EXAMPLES
    )
    parser.add_argument("source", type=input_path, metavar="A", help="the recording, in any format that evcot reads")
    output_option(parser, "target", metavar="B", help="what to write; its suffix gives the format")
    recording_options(parser)
    parser.add_argument("--config", type=input_path, metavar="TOML", help="its table [filters] says what to filter")
    filter_options(parser)
    json_or_quiet(parser, "print what was done as JSON instead of a table")


_SIMULATE_EXAMPLES = """
evcot simulate highway -o highway.aedat4         # and highway.truth.csv beside it
evcot simulate highway -o highway.aedat4 --labels highway.json --set story=0   # boxes with classes for `evcot train`
evcot simulate discs -o discs.npz --seed 4 --duration 2 --set noise_hz=3
evcot simulate clip.mp4 -o clip.raw
evcot simulate highway --list                    # its settings
"""


def add_simulate(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(commands, "simulate", "simulate a scene, or make events of a video or images", _SIMULATE_EXAMPLES)
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
    output_option(
        parser, "--labels", suffixes=(".json",), metavar="JSON", help="write the truth as COCO boxes with classes, too"
    )
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="seed of all random numbers (default: 1)")
    parser.add_argument("--duration", type=float, metavar="S", help="length in seconds (default: the scene's; of a video, all)")
    parser.add_argument("--sensor", metavar="WxH", help="size in pixels (default: the scene's)")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="change a setting (see --list); may be repeated"
    )
    parser.add_argument("--list", action="store_true", help="list the scenes; with a scene, its settings")
    json_or_quiet(parser, "print what was written, or the list, as JSON")
