# SPDX-License-Identifier: Apache-2.0
"""The options of every command that runs one tracker: which engine, and its settings."""

from __future__ import annotations

import argparse

from evcot.trackers.engines import DEFAULT, ENGINES

from .parsing import group_of, input_path

__all__ = ["engine_options"]


def engine_options(parser: argparse.ArgumentParser) -> None:
    """Add --engine, --preset, --config and --set."""
    engines = "; ".join(f"{name}: {engine.title}" for name, engine in ENGINES.items())
    group = group_of(parser, "engine")
    group.add_argument("--engine", choices=ENGINES, default=DEFAULT, help=f"{engines} (default: {DEFAULT})")
    group.add_argument("--preset", metavar="NAME", help="one of `evcot presets --engine ENGINE` (default: its first)")
    group.add_argument(
        "--config", type=input_path, metavar="TOML", help="a file whose table named after the engine overrides the preset"
    )
    group.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="change one setting of the engine; may be repeated"
    )
