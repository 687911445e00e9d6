# SPDX-License-Identifier: Apache-2.0
"""`evcot presets`: list the presets."""

from __future__ import annotations

import argparse

from evcot.trackers.engines import ENGINES

from .parsing import add_command

__all__ = ["add"]

_EXAMPLES = """
evcot presets                                    # of `evcot cosim`
evcot presets --engine rct                       # of `evcot track --engine rct`
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    presets = add_command(commands, "presets", "list the presets", _EXAMPLES)
    presets.add_argument("--engine", choices=ENGINES, help="presets of one engine of `evcot track` (default: of `evcot cosim`)")
    presets.add_argument("--json", action="store_true", help="print every field as JSON")
