# SPDX-License-Identifier: Apache-2.0
"""The command line: one module per group of commands. Exit codes: 0 done, 1 hardware and model differ, 2 a mistake of the
user's."""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from typing import Any

import evcot
from evcot.errors import DamagedRecordingError, EvcotError, RecordingWarning

from .commands import (
    anomalies,
    bench,
    board,
    boxes,
    completion,
    cosim,
    evaluate,
    live,
    plot,
    presets,
    recordings,
    render,
    report,
    simulate,
    sweep,
    toggles,
    track,
    tune,
    waves,
)
from .commands import filter as filter_command
from .commands.exit_codes import MISMATCH, USER_ERROR
from .commands.parsing import HelpFormatter, Parser, claims_of
from .lockstep.mismatch import MismatchError

__all__ = ["main", "parser"]

_EXAMPLES = """examples:
  evcot cosim                                   # the box experiment, nothing to download
  evcot cosim drive.aedat4                      # a camera file; settings are chosen from what the recording shows
  evcot info drive.aedat4                       # sensor, length, rates, busiest pixels
  evcot simulate highway -o highway.aedat4      # a scene, and its truth beside it
  evcot track highway.aedat4 -o log.npz
  evcot evaluate log.npz --truth highway.truth.csv

`evcot COMMAND -h` shows the options of a command, and more examples.
"""


def main(argv: Sequence[str] | None = None, loaded: Callable[[], None] | None = None) -> int:
    """Run one command; returns its exit code. An interrupt is the caller's to report.

    Args:
        argv: the words after `evcot`; None: those of this process.
        loaded: called once, when all modules that the command begins with are loaded.
    """
    arguments = list(sys.argv[1:] if argv is None else argv) or ["--help"]
    options, unknown = parser().parse_known_args(arguments)
    if unknown:
        options.parser.error(f"unrecognized arguments: {' '.join(unknown)}")
    try:
        with _warnings_in_one_line(), claims_of(options) as options.claims:
            code: int = options.command(options, arguments, loaded)
        return code
    except MismatchError as error:
        print(f"evcot: MISMATCH: {error}", file=sys.stderr)
        return MISMATCH
    except DamagedRecordingError as error:
        rescue = " (--skip-damaged reads what can be read)" if hasattr(options, "skip_damaged") else ""
        _say(f"{error}{rescue}")
        return USER_ERROR
    except EvcotError as error:
        _say(str(error))
        return USER_ERROR
    except BrokenPipeError:
        return 0
    except OSError as error:  # a full disk under a cache, and the like
        _say(f"{error.filename or 'a file'}: {error.strerror or error}")
        return USER_ERROR


def _say(message: str) -> None:
    """Print an error or a warning in one line: the name of a file may hold a line break, or codes for a terminal."""
    shown = "".join(each if each.isprintable() else each.encode("unicode_escape").decode() for each in message)
    print(f"evcot: {shown}", file=sys.stderr)


@contextmanager
def _warnings_in_one_line() -> Iterator[None]:
    """Print a warning about a recording as errors are printed, in one line, and once, however often the recording is read."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", RecordingWarning)
        show = warnings.showwarning
        shown: set[str] = set()

        def show_in_one_line(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
            if issubclass(category, RecordingWarning):
                line = f"warning: {message}"
                if line not in shown:
                    _say(line)
                shown.add(line)
            else:
                show(message, category, *place, **more)

        warnings.showwarning = show_in_one_line
        yield


@cache
def parser() -> argparse.ArgumentParser:
    """The whole command line."""
    whole = Parser(
        prog="evcot",
        description=f"Event-camera object tracking: hardware, model and software in lock-step.\n\n{_EXAMPLES}",
        formatter_class=HelpFormatter,
    )
    whole.add_argument("--version", action="version", version=f"evcot {evcot.__version__}")
    commands: Any = whole.add_subparsers(required=True, metavar="COMMAND")
    for group in (
        cosim,
        track,
        live,
        recordings,
        filter_command,
        simulate,
        evaluate,
        report,
        plot,
        render,
        boxes,
        anomalies,
        sweep,
        tune,
        waves,
        toggles,
        board,
        bench,
        presets,
    ):
        group.add(commands)
    completion.add(commands, whole)
    return whole
