# SPDX-License-Identifier: Apache-2.0
"""The options of the commands that read or write boxes in the field's formats: the time of frames, and formats."""

from __future__ import annotations

import argparse

from evcot.tracks.formats import FORMAT_NAMES

__all__ = ["FORMATS_TEXT", "clock_options"]

FORMATS_TEXT = f"one of {', '.join(FORMAT_NAMES)} (default: by the suffix: .txt, .json, .npy, .mcap)"


def clock_options(parser: argparse.ArgumentParser, origin: str) -> None:
    """Add --frame-us and --origin-us.

    Args:
        origin: what the origin is if it is not given.
    """
    parser.add_argument("--frame-us", type=float, metavar="US", help="time from frame to frame, for formats that number frames")
    parser.add_argument(
        "--origin-us", type=int, metavar="US", help=f"time of frame 1 on the recording's clock (default: {origin})"
    )
