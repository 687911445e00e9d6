# SPDX-License-Identifier: Apache-2.0
"""The options of every command that has filters in front."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from typing import Any

from .parsing import input_path, output_option

__all__ = ["NUMBERS", "filter_options", "milliseconds", "region"]


def milliseconds(text: str) -> int:
    """Milliseconds as whole microseconds; less than one is none only where it says 0. The name is what argparse prints."""
    ms = float(text)
    if not math.isfinite(ms) or (ms != 0 and round(1000 * ms) == 0):
        raise ValueError(text)
    return round(1000 * ms)


def region(text: str) -> tuple[int, ...]:
    """`X0,Y0,X1,Y1`. The name is what argparse prints."""
    return tuple(int(part) for part in text.split(","))


# option -> (field of FilterConfig, type, argument, help)
NUMBERS: dict[str, tuple[str, Callable[[str], Any], str, str]] = {
    "--refractory": ("refractory_us", milliseconds, "MS", "silence a pixel for this long after each of its events"),
    "--activity": ("activity_us", milliseconds, "MS", "keep an event if a neighbour sent one at most this long before"),
    "--activity-support": ("activity_support", int, "N", "how many neighbours must have sent one (default: 1)"),
    "--activity-noise": (
        "activity_noise_hz",
        float,
        "HZ",
        "let so much noise pass, per pixel and second, by as many neighbours as that takes; needs --cell",
    ),
    "--recent": ("recent_us", milliseconds, "MS", "keep an event if one of the last few events, at most this old, was near"),
    "--recent-radius": ("recent_radius", int, "PX", "how near (default: 4)"),
    "--recent-support": ("recent_support", int, "N", "how many of them must be near (default: 1)"),
    "--recent-depth": ("recent_depth", int, "N", "how many of the last events are remembered (default: 32)"),
    "--decay-tau": (
        "decay_tau_us",
        milliseconds,
        "MS",
        "keep an event if its neighbours' weights, which decay with this time constant, add up",
    ),
    "--decay-epsilon": ("decay_epsilon", float, "W", "weight up to which an event is forgotten (default: 0.1)"),
    "--decay-support": ("decay_support", float, "W", "sum of weights needed (default: 1)"),
    "--rowcol": (
        "rowcol_us",
        milliseconds,
        "MS",
        "keep an event if the last one of a neighbouring row or column, at most this old, was near",
    ),
    "--rowcol-radius": ("rowcol_radius", int, "PX", "how near along the row or column (default: 1)"),
    "--rowcol-support": ("rowcol_support", int, "N", "how many rows and columns must have one (default: 1)"),
    "--cell": (
        "cell_px",
        int,
        "PX",
        "keep times per cell of 1, 2 or 4 pixels, in less memory (default: 0, a time per pixel and filter)",
    ),
}


def filter_options(parser: argparse.ArgumentParser) -> None:
    """Add an option for each filter's settings. A command that has done its work then calls `save_learned`."""
    group = parser.add_argument_group("filters", "on top of the table [filters] of --config; see docs/filters.md")
    group.add_argument("--region", type=region, metavar="X0,Y0,X1,Y1", help="keep these columns and rows, both bounds included")
    group.add_argument("--polarity", choices=("on", "off"), help="keep events of this polarity")
    group.add_argument(
        "--hot-pixels", type=input_path, metavar="FILE", help="silence the pixels listed there, one `x y` a line"
    )
    group.add_argument("--learn-hot-pixels", action="store_true", help="find hot pixels in the recording and silence them")
    listed = "write there the hot pixels that --learn-hot-pixels finds, for --hot-pixels"
    output_option(parser, "--save-hot-pixels", group=group, metavar="FILE", help=listed)
    for option, (field, kind, metavar, meaning) in NUMBERS.items():
        group.add_argument(option, dest=field, type=kind, metavar=metavar, help=meaning)
