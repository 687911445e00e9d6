# SPDX-License-Identifier: Apache-2.0
"""`evcot completion`: print the script with which a shell completes commands, options, values and file names."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence

import shtab

from ..parsing import INPUT_TYPES, OUTPUT_TYPES

__all__ = ["run"]


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Print the script; 0."""
    if options.shell == "fish":
        print("\n".join(_fish(options.whole)))
    else:
        print(shtab.complete(_with_files(options.whole), options.shell))
    return 0


def _fish(whole: argparse.ArgumentParser) -> Iterator[str]:
    """The script for fish, which shtab does not write: commands, then each one's options and values."""
    (commands,) = (action for action in whole._actions if isinstance(action, argparse._SubParsersAction))
    yield "complete -c evcot -f"
    for named in commands._choices_actions:
        yield f"complete -c evcot -n __fish_use_subcommand -a {named.dest} -d {_quoted(named.help)}"
    for name, parser in commands.choices.items():
        here = f"complete -c evcot -n '__fish_seen_subcommand_from {name}'"
        for action in parser._actions:
            is_file = action.type in (*INPUT_TYPES, *OUTPUT_TYPES)
            if not action.option_strings:
                if is_file:
                    yield f"{here} -F"
                if action.choices is not None:
                    yield f"{here} -a {_quoted(' '.join(map(str, action.choices)))}"
                continue
            names = " ".join(
                f"-l {option.removeprefix('--')}" if option.startswith("--") else f"-s {option.removeprefix('-')}"
                for option in action.option_strings
            )
            value = "" if action.nargs == 0 else " -r -F" if is_file else " -x"
            if action.choices is not None:
                value = f" -x -a {_quoted(' '.join(map(str, action.choices)))}"
            yield f"{here} {names}{value} -d {_quoted(action.help)}"


def _quoted(text: str | None) -> str:
    """Text in single quotes, as fish reads it, on one line."""
    plain = " ".join((text or "").replace("%%", "%").split())
    return "'" + plain.replace("\\", "\\\\").replace("'", "\\'") + "'"


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
