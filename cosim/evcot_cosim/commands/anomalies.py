# SPDX-License-Identifier: Apache-2.0
"""`evcot anomalies`: flag unusual trajectories, or learn which are normal."""

from __future__ import annotations

import argparse

from .parsing import add_command, input_path, output_option

__all__ = ["add"]

_EXAMPLES = """
evcot anomalies --learn monday.npz tuesday.npz --sensor 346x260 -o normal.npz
evcot anomalies today.npz --normal normal.npz --zones zones.toml
evcot anomalies today.npz --normal normal.npz -o alarms.csv --picture alarms.png
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(commands, "anomalies", "flag unusual trajectories: zones, direction, speed, stays", _EXAMPLES)
    parser.add_argument("logs", type=input_path, nargs="+", metavar="LOG", help="a track log; with --learn one or more")
    parser.add_argument("--learn", action="store_true", help="learn normal motion from the logs, and write it to -o FILE.npz")
    parser.add_argument("--normal", type=input_path, metavar="NPZ", help="normal motion, as written by --learn")
    parser.add_argument("--zones", type=input_path, metavar="TOML", help="zones and counting lines (docs/anomalies.md)")
    parser.add_argument("--recording", type=input_path, metavar="FILE", help="refuse a log that is not of this recording")
    parser.add_argument("--sensor", metavar="WxH", help="size in pixels (default: the recording's, else the smallest)")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="a setting of the rules; may be repeated"
    )
    output_option(
        parser,
        "-o",
        "--output",
        suffixes=(".csv", ".json", ".npz"),
        metavar="FILE",
        help="write alarms as .csv or .json; with --learn, normal motion as .npz",
    )
    output_option(parser, "--picture", suffixes=(".png", ".svg", ".pdf"), metavar="PNG", help="draw tracks and alarms there")
    parser.add_argument("--json", action="store_true", help="print everything as JSON")
