# SPDX-License-Identifier: Apache-2.0
"""`evcot evaluate`: tracks against ground truth."""

from __future__ import annotations

import argparse

from evcot.metrics import RULES

from .box_options import FORMATS_TEXT, clock_options
from .parsing import add_command, input_or_name, input_path

__all__ = ["add"]

_EXAMPLES = """
evcot evaluate log.npz --truth highway.truth.csv
evcot evaluate build/cosim/highway --truth highway.truth.csv   # all engines of a run
evcot evaluate result.txt --truth gt.txt --frame-us 40000      # MOTChallenge, of any tracker
evcot evaluate log.npz --truth drive_bbox.npy
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(commands, "evaluate", "score tracks against ground truth: HOTA, CLEAR, ID scores, errors", _EXAMPLES)
    parser.add_argument(
        "log",
        type=input_path,
        metavar="LOG|RUN",
        help="a track log, such as hardware.npz of a run; boxes; or the folder of a run, to score all its engines",
    )
    parser.add_argument("--truth", type=input_path, required=True, metavar="TRUTH", help="the ground truth: CSV, or boxes")
    known = ", ".join(RULES)
    parser.add_argument(
        "--rule",
        type=input_or_name,
        metavar="RULE",
        help=f"how to read and score the truth: {known}, or a .toml file (default: the one with the truth's columns)",
    )
    parser.add_argument("--log-format", metavar="NAME", help=f"format of LOG if it has boxes: {FORMATS_TEXT}")
    parser.add_argument("--truth-format", metavar="NAME", help=f"the same of TRUTH: {FORMATS_TEXT}; .csv is read by the rule")
    clock_options(parser, "0")
    parser.add_argument("--sensor", metavar="WxH", help="size in pixels (default: the rule's)")
    parser.add_argument("--json", action="store_true", help="print every figure as JSON")
