# SPDX-License-Identifier: Apache-2.0
"""The options of every command that simulates hardware: events, module and configuration."""

from __future__ import annotations

import argparse

from evcot.hardware.modules import DEFAULT_MODULE, MODULES
from evcot.scenes.registry import SCENES

from .filter_options import filter_options
from .options import damage_options
from .parsing import group_of, input_or_name, input_path

__all__ = ["DEFAULT_SCENE", "input_options"]

DEFAULT_SCENE = "boxes"


def input_options(parser: argparse.ArgumentParser, *, runs: bool = False) -> None:
    """Add what `job_from` reads; `runs`: the folder of a run is an input too."""
    source = f"a recording, or a scene: {', '.join(SCENES)} (default: {DEFAULT_SCENE})"
    run = "the folder of a run of `evcot cosim`; " if runs else ""
    parser.add_argument("recording", nargs="?", type=input_or_name, metavar="RUN" if runs else "FILE", help=run + source)
    parser.add_argument("--seed", type=int, metavar="N", help="seed of a scene (default: 1)")
    group = group_of(parser, "hardware")
    group.add_argument(
        "--preset",
        metavar="NAME",
        help="one of `evcot presets` (default: motion; of other hardware the one for the sensor)",
    )
    group.add_argument(
        "--config", type=input_path, metavar="TOML", help="a file that overrides the preset, or a whole run (--print-config)"
    )
    group.add_argument("--slots", type=int, metavar="N", help="tracker slots (default: the preset's)")
    group.add_argument(
        "--hardware", choices=MODULES, help=f"which RTL module (default: the preset's, {DEFAULT_MODULE} without one)"
    )
    group.add_argument("--stalls", type=int, metavar="SEED", help="stall the hardware's streams at random, from this seed")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress, no table")
    damage_options(parser)
    filter_options(parser)
