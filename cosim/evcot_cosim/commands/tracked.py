# SPDX-License-Identifier: Apache-2.0
"""The options of the commands that draw: a recording with its track logs, or the folder of a run."""

from __future__ import annotations

import argparse

from .options import recording_options
from .parsing import input_or_name, input_path

__all__ = ["RUN_DEFAULT", "RUN_LOGS", "tracked_options"]

RUN_LOGS = ("hardware", "software", "model")
RUN_DEFAULT = ("hardware", "software")


def tracked_options(parser: argparse.ArgumentParser) -> None:
    """Add what `tracked_from` reads."""
    parser.add_argument(
        "source", type=input_path, metavar="RECORDING|RUN", help="a recording, or the folder of a run of `evcot cosim`"
    )
    logs = f"track logs of the recording (.npz); of a run, any of {', '.join(RUN_LOGS)} (default: {' and '.join(RUN_DEFAULT)})"
    parser.add_argument("logs", nargs="*", type=input_or_name, metavar="LOG", help=logs)
    recording_options(parser)
