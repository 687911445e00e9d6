# SPDX-License-Identifier: Apache-2.0
"""The options of every command that runs one tracker: which engine, and its settings."""

from __future__ import annotations

import argparse
from typing import Any

from evcot.trackers.engines import DEFAULT, ENGINES

from .parsing import group_of, input_path

__all__ = ["engine_options"]


def engine_options(parser: argparse.ArgumentParser) -> None:
    """Add --engine, --preset, --config and --set."""
    group = group_of(parser, "engine")
    group.add_argument("--engine", action=_Engine, choices=ENGINES, default=DEFAULT, metavar="NAME")
    group.add_argument("--preset", metavar="NAME", help="one of `evcot presets --engine ENGINE` (default: its first)")
    group.add_argument(
        "--config", type=input_path, metavar="TOML", help="a file whose table named after the engine overrides the preset"
    )
    group.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="change one setting of the engine; may be repeated"
    )


class _Engine(argparse.Action):
    """Stores the name; engines of other packages are looked for only to show the help, or where such a name is given."""

    def __call__(self, _parser: Any, namespace: argparse.Namespace, values: Any, _option: str | None = None) -> None:
        setattr(namespace, self.dest, values)

    @property
    def help(self) -> str:
        return "; ".join(f"{name}: {engine.title}" for name, engine in ENGINES.items()) + f" (default: {DEFAULT})"

    @help.setter
    def help(self, _: str | None) -> None: ...
