# SPDX-License-Identifier: Apache-2.0
"""Commands about runs: `evcot cosim` compares hardware, model and software tracker; `evcot report` writes the page for it."""

from __future__ import annotations

import argparse

from evcot.metrics import RULES

from .options import checkpoint_option, classify_option, damage_options, input_options, window_options
from .parsing import add_command, input_or_name, input_path, json_or_quiet, output_option

__all__ = ["add_cosim", "add_report"]


_COSIM_EXAMPLES = """
evcot cosim                                    # the box experiment, nothing to download
evcot cosim drive.aedat4                       # a camera file; settings are chosen from what the recording shows
evcot cosim drive.aedat4 --preset slow --slots 16 --stalls 7
evcot cosim highway --activity 5               # filters, then hardware, model and software tracker, on a scene
evcot cosim drive.aedat4 --classify digits.npz # the class of each track, with weights of `evcot train`
evcot cosim drive.raw --print-config           # a file that repeats the run: save it as run.toml
evcot cosim --config run.toml
"""


_TERMS = """words in the output:
  record      a line of a track log: a track was born, has moved, has merged into another, or was lost
  owner       the tracker slot that took an event
  CM          a cluster's centre, updated after every N_ev of its events
  TC          the time since a cluster's last event
  isolated    an event without another one on the eight pixels around it in the 10 ms before
  short       a track that ended within 0.2 s, where it began
"""


def add_cosim(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    title = "run hardware, model and software tracker on a recording and compare them"
    cosim = add_command(commands, "cosim", title, _COSIM_EXAMPLES)
    cosim.epilog = _TERMS
    input_options(cosim)
    window_options(cosim)
    output_option(cosim, "-o", "--output", folder=True, metavar="DIR", help="where to write (default: build/cosim/NAME)")
    classify_option(cosim)
    checkpoint_option(cosim)
    cosim.add_argument("--no-waves", action="store_true", help="write no waveform")
    cosim.add_argument("--print-config", action="store_true", help="print a run.toml that repeats the run, and run nothing")
    cosim.add_argument("--json", action="store_true", help="print summary.json instead of the table")


_REPORT_EXAMPLES = """
evcot report build/cosim/drive                              # writes build/cosim/drive/report.html anew
evcot report build/cosim/drive --truth drive.csv --rule traffic
evcot report log.npz --recording drive.aedat4 -o drive.html # for a log of `evcot track`
evcot report build/cosim/drive frames.npz -o all.html       # with further engines beside hardware and software
evcot report build/cosim/before build/cosim/after -o changed.html   # two runs compared: settings, figures, scores, tracks
"""


def add_report(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(commands, "report", "write the page for exploring a run, as one HTML file", _REPORT_EXAMPLES)
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
    json_or_quiet(parser, "print what was written as JSON")
    window_options(parser)
    damage_options(parser)
