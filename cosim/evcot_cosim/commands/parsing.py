# SPDX-License-Identifier: Apache-2.0
"""The help of a command: a line on what it does, examples, options; and which of its arguments name files.

The type of an argument states whether it names a file to read or to write. So all files of a call are known, and checked,
before a command begins (`claims_of`).
"""

from __future__ import annotations

import argparse
import errno
import itertools
import os
import re
import sys
import textwrap
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from pkgutil import resolve_name
from typing import Any, NoReturn

from evcot.errors import DamagedRecordingError, EvcotError, RecordingError, meant
from evcot.outputs import Claims, suffix_of

from ..standard_streams import STANDARD_INPUT, STANDARD_OUTPUT, without_copy

__all__ = [
    "BROKEN",
    "INPUT_TYPES",
    "MISMATCH",
    "OUTPUT_TYPES",
    "USER_ERROR",
    "Action",
    "HelpFormatter",
    "Parser",
    "add_command",
    "claims_of",
    "group_of",
    "input_each",
    "input_or_name",
    "input_or_scene",
    "input_path",
    "json_or_quiet",
    "output_file",
    "output_folder",
    "output_option",
    "say",
    "say_error",
    "writes_standard_output",
]


MISMATCH = 1  # hardware and model differ
BROKEN = 1  # a property of a waveform does not hold
USER_ERROR = 2  # something that the user can mend


def say(message: str) -> None:
    """Print an error or a warning in one line: the name of a file may hold a line break, or codes for a terminal."""
    shown = "".join(each if each.isprintable() else each.encode("unicode_escape").decode() for each in without_copy(message))
    print(f"evcot: {shown}", file=sys.stderr)


def say_error(error: EvcotError, options: argparse.Namespace) -> None:
    """Print what a user can mend, and how to read the rest of a damaged recording."""
    is_rescued = isinstance(error, DamagedRecordingError) and hasattr(options, "skip_damaged")
    say(f"{error}{' (--skip-damaged reads what can be read)' if is_rescued else ''}")


def input_path(text: str) -> Path:
    """The type of an argument that names a file or a folder to read; - is standard input."""
    return STANDARD_INPUT if text == "-" else Path(text)


def input_each(text: str) -> Path:
    """The type of an argument of several files that are read one after the other; what is wrong with one stops no other."""
    return input_path(text)


def input_or_name(text: str) -> str:
    """The type of an argument that names a file or a folder to read, - standard input, or something else, such as a scene."""
    return str(STANDARD_INPUT) if text == "-" else text


def input_or_scene(text: str) -> str:
    """The type of an argument that names a file or a folder to read, - standard input, or a scene."""
    return input_or_name(text)


def output_file(text: str) -> Path:
    """The type of an argument that names a file to write, - standard output; `output_option` adds one."""
    return STANDARD_OUTPUT if text == "-" else Path(text)


def output_folder(text: str) -> Path:
    """The type of an argument that names a folder to write; `output_option` adds one.

    Raises:
        ArgumentTypeError: standard output.
    """
    if text == "-":
        raise argparse.ArgumentTypeError("-: must be a folder, which standard output is not (./- names one)")
    return Path(text)


_FILE_NAME = re.compile(r"[^:]+\.[A-Za-z]\w*")  # what names a file, and no scene, rule, camera or address
INPUT_TYPES = (input_path, input_each, input_or_name, input_or_scene)
OUTPUT_TYPES = (output_file, output_folder)


class HelpFormatter(argparse.RawDescriptionHelpFormatter):
    """Keeps the lines of a description that fit, and breaks the others so that commands can still be copied.

    Where a command with its remark is too long, every remark of the description gets a line of its own above its command; a
    command that is too long is continued behind a backslash.
    """

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        lines = [(*_INDENTED.fullmatch(line).groups(), line) for line in text.splitlines()]  # type: ignore[union-attr]
        apart = any(len(line) > width and _REMARK.search(line) for *_, line in lines)
        return "".join(f"{indent}{part}\n" for left, words, _ in lines for part in _broken(left, words, width, apart))


_INDENTED = re.compile(r"( *)(.*)")
_REMARK = re.compile(r" +# ")
_NO_BREAK = "\N{NO-BREAK SPACE}"
_TERM = re.compile(r"\S+ {2,}")


def _broken(left: str, words: str, width: int, apart: bool) -> Iterator[str]:
    """The lines of one indented line of a description; `apart`: a remark has its own."""
    command, remark = words, ""
    if apart and words.startswith("evcot "):
        command, _, remark = (part.strip() for part in _REMARK.sub("\0", words, count=1).partition("\0"))
    if remark:
        yield from textwrap.wrap(remark, width, initial_indent=f"{left}# ", subsequent_indent=f"{left}# ")
    if len(left + command) <= width:
        yield left + command
    elif command.startswith("evcot "):
        joined = re.sub(" (?!-)", _NO_BREAK, command)  # an option stays with its value
        *firsts, last = textwrap.wrap(
            joined, width - 2, initial_indent=left, subsequent_indent=f"{left}    ", break_on_hyphens=False
        )
        yield from (f"{first} \\".replace(_NO_BREAK, " ") for first in firsts)
        yield last.replace(_NO_BREAK, " ")
    else:
        term = _TERM.match(command)
        hanging = left + " " * len(term[0] if term is not None else "")
        yield from textwrap.wrap(command, width, initial_indent=left, subsequent_indent=hanging)


class Parser(argparse.ArgumentParser):
    """A parser with a usage of one line, and with a suggestion for a word that is misspelled."""

    _words: Sequence[str] = ()  # that are being parsed

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse does it; an error then knows all words, however early it ends the parsing."""
        self._words = sys.argv[1:] if args is None else list(args)
        return super().parse_known_args(self._words, namespace)

    def format_usage(self) -> str:
        """The usage: required options and positional arguments; the others are listed below it in the help."""
        formatter = self._get_formatter()
        formatter.add_usage(self._brief_usage(), (), ())
        return formatter.format_help()

    def format_help(self) -> str:
        """The whole help, with the brief usage."""
        before, self.usage = self.usage, self._brief_usage()
        try:
            return super().format_help()
        finally:
            self.usage = before

    def error(self, message: str) -> NoReturn:
        """Print usage and message, with what may have been meant, and exit with 2."""
        if message.startswith("the following arguments are required") and (unknown := self._unknown()) is not None:
            message += f"; unrecognized arguments: {unknown}"
        super().error(message + self._suggestion(message))

    def _unknown(self) -> str | None:
        """The first word that looks like an option and is none."""
        names = [word.partition("=")[0] for word in itertools.takewhile(lambda word: word != "--", self._words)]
        options = [name for name in names if name.startswith("--")]
        return next(
            (name for name in options if not self._get_option_tuples(name) and name not in self._option_string_actions), None
        )

    def _brief_usage(self) -> str:
        words = ["%(prog)s", "[options]"]
        for action in self._actions:
            name = str(action.metavar or action.dest)
            if action.option_strings:
                words += [action.option_strings[0], name] if action.required else []
            elif isinstance(action, argparse._SubParsersAction):
                words += [name, "..."]
            else:
                words.append({"?": f"[{name}]", "*": f"[{name} ...]", "+": f"{name} [{name} ...]"}.get(str(action.nargs), name))
        return " ".join(words)

    def _suggestion(self, message: str) -> str:
        choice = re.search(r"invalid choice: '([^']*)' \(choose from (.*)\)", message)
        if choice is not None:
            return meant(choice[1], re.findall(r"'([^']*)'", choice[2]) or choice[2].split(", "))
        unknown = re.search(r"unrecognized arguments: (--?[\w-]+)", message)
        return meant(unknown[1], self._option_string_actions) if unknown is not None else ""


def group_of(parser: argparse.ArgumentParser, title: str) -> argparse._ArgumentGroup:
    """The group of arguments with this title, begun if it is not there yet."""
    return next((group for group in parser._action_groups if group.title == title), None) or parser.add_argument_group(title)


def output_option(
    parser: argparse.ArgumentParser,
    *names: str,
    folder: bool = False,
    group: argparse._ArgumentGroup | None = None,
    suffixes: Sequence[str] = (),
    several: str = "",
    **more: Any,
) -> None:
    """Add an argument that names a file or a folder to write, listed in `group` if there is one.

    A file with a suffix that is none of `suffixes` is refused before any work; without `suffixes` the command checks itself.

    Where the argument `several` has more than one value, the output is a folder, and the command claims a file in it for each.

    The first file of a parser adds --force too, among the parser's own options: it holds for all files that are written.
    """
    action = (group or parser).add_argument(*names, type=output_folder if folder else output_file, **more)
    for default, value in (("suffixes", tuple(suffixes)), ("several", several)):
        parser.set_defaults(**{default: {**(parser.get_default(default) or {}), action.dest: value}})
    if not folder and "--force" not in parser._option_string_actions:
        parser.add_argument("--force", action="store_true", help="replace output files that exist")


def json_or_quiet(parser: argparse.ArgumentParser, as_json: str, quiet: str = "print nothing") -> None:
    """Add --json and --quiet, with the help of each."""
    parser.add_argument("--json", action="store_true", help=as_json)
    parser.add_argument("-q", "--quiet", action="store_true", help=quiet)


@dataclass(frozen=True)
class Action:
    """What a command does, imported when it is called: to show the options takes none of it.

    Attributes:
        place: `module:function` of `actions`.
        ahead: called before that is imported.
    """

    place: str
    ahead: Callable[[argparse.Namespace], None] | None = None

    def __call__(self, options: argparse.Namespace, arguments: Sequence[str], loaded: Callable[[], None] | None = None) -> int:
        """Run it; `loaded` is called when it is imported."""
        if self.ahead is not None:
            self.ahead(options)
        function = self.function
        if loaded is not None:
            loaded()
        return function(options, arguments)

    @property
    def function(self) -> Callable[[argparse.Namespace, Sequence[str]], int]:
        """The function itself: from the options and the whole command line to an exit code."""
        found: Callable[[argparse.Namespace, Sequence[str]], int] = resolve_name(f"{__package__}.actions.{self.place}")
        return found


def add_command(
    commands: argparse._SubParsersAction[argparse.ArgumentParser],
    name: str,
    title: str,
    examples: str,
    place: str = "",
    ahead: Callable[[argparse.Namespace], None] | None = None,
) -> argparse.ArgumentParser:
    """A command's parser: `evcot NAME -h` shows title, examples, one command with a remark per line, and options.

    Args:
        place, ahead: of what it does, as of `Action`; without a place `NAME:run`.
    """
    shown = "examples:\n" + "\n".join(f"  {line}".rstrip() for line in examples.strip().splitlines())
    description = f"{title[:1].upper()}{title[1:]}.\n\n{shown}"
    parser = commands.add_parser(name, help=title, description=description, formatter_class=HelpFormatter)
    parser.set_defaults(parser=parser, command=Action(place or f"{name}:run", ahead))
    return parser


def claims_of(options: argparse.Namespace) -> Claims:
    """All files that a command's arguments name.

    Raises:
        OutputError: one that is to be written may not be.
        RecordingError: one that is to be read does not exist. It is reported before the command's modules are imported.
    """
    claims = Claims()
    for action, path in _given(options, INPUT_TYPES):
        if _must_exist(options, action, path) and not path.exists():
            raise RecordingError(f"{path}: cannot be read: {os.strerror(errno.ENOENT)}")
        if action.type is input_or_scene:
            from evcot.scenes.registry import check_source  # which the commands with scenes have imported

            check_source(str(path))
        claims.read(path)
    for action, path in _given(options, OUTPUT_TYPES):
        several = options.several[action.dest]
        if several and len(getattr(options, several)) > 1:
            continue
        if action.type is output_file:
            claims.write(_title(action), path, force=options.force)
        else:
            claims.write_folder(_title(action), path, options.parser.prog.rpartition(" ")[2])
    for action, path in _given(options, (output_file,)):
        if suffixes := options.suffixes[action.dest]:
            suffix_of(path, suffixes, _title(action))
    return claims


def _must_exist(options: argparse.Namespace, action: argparse.Action, path: Path) -> bool:
    """Whether the command cannot begin without this input."""
    if action.type is input_each:
        return len(getattr(options, action.dest)) == 1
    return action.type is input_path or bool(_FILE_NAME.fullmatch(str(path)))


def writes_standard_output(options: argparse.Namespace) -> bool:
    """Whether standard output gets a file that the command writes."""
    return any(path == STANDARD_OUTPUT for _, path in _given(options, (output_file,)))


def _given(options: argparse.Namespace, types: Collection[object]) -> Iterator[tuple[argparse.Action, Path]]:
    """The arguments of these types that are given, with their values."""
    for action in options.parser._actions:
        if action.type in types:
            given = getattr(options, action.dest)
            for value in given if isinstance(given, list) else [] if given is None else [given]:
                yield action, Path(value)


def _title(action: argparse.Action) -> str:
    return action.option_strings[0] if action.option_strings else "output"
