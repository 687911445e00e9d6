# SPDX-License-Identifier: Apache-2.0
"""`evcot completion`: the script that a shell reads."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import shtab

from ..parsing import INPUT_TYPES, OUTPUT_TYPES

__all__ = ["run"]


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Print the script; 0."""
    print(shtab.complete(_with_files(options.whole), options.shell))
    return 0


def _with_files(parser: argparse.ArgumentParser) -> argparse.ArgumentParser:
    """Let every argument that is a path, of any command, complete to files."""
    for action in _actions(parser):
        if action.type in (*INPUT_TYPES, *OUTPUT_TYPES):
            action.complete = shtab.FILE  # type: ignore[attr-defined]
    return parser


def _actions(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    found = list(parser._actions)
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            found += [inner for choice in action.choices.values() for inner in _actions(choice)]
    return found
