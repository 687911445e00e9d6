# SPDX-License-Identifier: Apache-2.0
"""`evcot completion`: print the script with which a shell completes commands, options, values and file names."""

from __future__ import annotations

import argparse

from .parsing import add_command

__all__ = ["add"]

_EXAMPLES = """
eval "$(evcot completion bash)"                  # in ~/.bashrc
evcot completion zsh > ~/.zfunc/_evcot           # a folder of zsh's fpath
evcot completion fish > ~/.config/fish/completions/evcot.fish
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser], whole: argparse.ArgumentParser) -> None:
    """Add the command to the command line that `whole` is of."""
    completion = add_command(commands, "completion", "print a shell's completion script", _EXAMPLES)
    completion.add_argument("shell", choices=("bash", "zsh", "fish"), metavar="SHELL", help="bash, zsh or fish")
    completion.set_defaults(whole=whole)
