# SPDX-License-Identifier: Apache-2.0
"""`evcot completion`: what a shell needs to complete evcot's commands, options and their values."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import shtab

from .parsing import INPUT_TYPES, OUTPUT_TYPES, add_command

__all__ = ["add"]

_EXAMPLES = """
eval "$(evcot completion bash)"                  # in ~/.bashrc
evcot completion zsh > ~/.zfunc/_evcot           # a folder of zsh's fpath
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser], parser: argparse.ArgumentParser) -> None:
    """Add the command to the command line that `parser` is of."""
    completion = add_command(commands, "completion", "print the completion of a shell", _EXAMPLES)
    completion.add_argument("shell", choices=("bash", "zsh"), help="which shell")

    def print_script(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
        print(shtab.complete(_with_files(parser), options.shell))
        return 0

    completion.set_defaults(command=print_script)


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
