# SPDX-License-Identifier: Apache-2.0
"""`evcot report`: write the page for exploring a run, software trackers' logs, or two runs."""

from __future__ import annotations

import argparse

from evcot.metrics import RULES

from .options import damage_options, window_options
from .parsing import add_command, input_or_name, input_path, output_option

__all__ = ["add"]

_EXAMPLES = """
evcot report build/cosim/drive                              # writes build/cosim/drive/report.html anew
evcot report build/cosim/drive --truth drive.csv --rule traffic
evcot report log.npz --recording drive.aedat4 -o drive.html # for a log of `evcot track`
evcot report build/cosim/drive frames.npz -o all.html       # with further engines beside hardware and software
evcot report build/cosim/before build/cosim/after -o changed.html   # two runs compared: settings, figures, scores, tracks
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(commands, "report", "write the page for exploring a run, as one HTML file", _EXAMPLES)
    parser.add_argument(
        "run",
        type=input_path,
        nargs="+",
        metavar="RUN",
        help="the folder of a run of `evcot cosim`, or a track log (.npz, .parquet); "
        "further logs of the same recording are shown beside it; two folders are compared",
    )
    parser.add_argument("--recording", type=input_path, metavar="FILE", help="the events (default: the run's own recording)")
    parser.add_argument(
        "--truth", type=input_path, metavar="CSV", help="the ground truth (default: the scene's, or FILE.truth.csv)"
    )
    known = ", ".join(RULES)
    parser.add_argument(
        "--rule",
        type=input_or_name,
        metavar="RULE",
        help=f"how to read and score the truth: {known}, or a .toml file (default: by its columns)",
    )
    output_option(
        parser,
        "-o",
        "--output",
        suffixes=(".html", ".htm"),
        metavar="HTML",
        help="where to write (default: report.html in the folder, replaced there)",
    )
    parser.add_argument("--json", action="store_true", help="print what was written as JSON")
    parser.add_argument("-q", "--quiet", action="store_true", help="print nothing")
    window_options(parser)
    damage_options(parser)
