# SPDX-License-Identifier: Apache-2.0
"""The command line: one module per group of commands. Exit codes: 0 done, 1 hardware and model differ, 2 a mistake of the
user's."""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from functools import cache
from pkgutil import resolve_name
from typing import Any

import evcot
from evcot.errors import EvcotError, RecordingWarning, reason_of

from .commands.parsing import (
    MISMATCH,
    USER_ERROR,
    HelpFormatter,
    Parser,
    add_command,
    claims_of,
    say,
    say_error,
    writes_standard_output,
)
from .lockstep.mismatch import MismatchError
from .standard_streams import as_file, begin_command

__all__ = ["main", "parser"]

# Commands, as the help lists them, and the functions of `commands` that add them.
_ADDED_BY = {
    "cosim": "runs:add_cosim", "track": "tracking:add_track", "live": "tracking:add_live", "info": "recordings:add_recordings",
    "convert": "recordings:add_recordings", "filter": "recordings:add_filter", "simulate": "recordings:add_simulate",
    "train": "tracking:add_train", "evaluate": "tracking:add_evaluate", "report": "runs:add_report",
    "plot": "drawings:add_plot", "render": "drawings:add_render", "boxes": "tracking:add_boxes",
    "anomalies": "tracking:add_anomalies", "sweep": "sweeps:add_sweep", "tune": "sweeps:add_tune",
    "waves": "hardware:add_waves", "assert": "hardware:add_waves", "vectors": "hardware:add_vectors",
    "toggles": "hardware:add_toggles", "board": "hardware:add_board", "bench": "hardware:add_bench",
    "presets": "tracking:add_presets",
}  # fmt: skip

_EXAMPLES = """examples:
  evcot cosim                                   # the box experiment, nothing to download
  evcot cosim drive.aedat4                      # a camera file; settings are chosen from what the recording shows
  evcot info drive.aedat4                       # sensor, length, rates, busiest pixels
  evcot simulate highway -o highway.aedat4      # a scene, and its truth beside it
  evcot track highway.aedat4 -o log.npz
  evcot evaluate log.npz --truth highway.truth.csv

`evcot COMMAND -h` shows the options of a command, and more examples.
"""

_COMPLETION_EXAMPLES = """
eval "$(evcot completion bash)"                  # in ~/.bashrc
evcot completion zsh > ~/.zfunc/_evcot           # a folder of zsh's fpath
evcot completion fish > ~/.config/fish/completions/evcot.fish
"""


def main(argv: Sequence[str] | None = None, loaded: Callable[[], None] | None = None) -> int:
    """Run one command; returns its exit code. An interrupt is the caller's to report.

    Args:
        argv: the words after `evcot`; None: those of this process.
        loaded: called once, when all modules that the command begins with are loaded.
    """
    arguments = list(sys.argv[1:] if argv is None else argv) or ["--help"]
    options, unknown = parser(arguments[0] if arguments[0] in _ADDED_BY else None).parse_known_args(arguments)
    if unknown:
        options.parser.error(f"unrecognized arguments: {' '.join(unknown)}")
    begin_command()
    try:
        if getattr(options, "config", None) is not None:
            options.config = as_file(options.config)  # is read more than once
        said = sys.stderr if writes_standard_output(options) else sys.stdout
        with _warnings_in_one_line(), redirect_stdout(said), claims_of(options) as options.claims:
            code: int = options.command(options, arguments, loaded)
        return code
    except MismatchError as error:
        print(f"evcot: MISMATCH: {error}", file=sys.stderr)
        return MISMATCH
    except EvcotError as error:
        say_error(error, options)
        return USER_ERROR
    except BrokenPipeError:
        return 0
    except OSError as error:  # a full disk under a cache, and the like
        say(reason_of(error) if error.filename else f"a file: {reason_of(error)}")
        return USER_ERROR


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
                    say(line)
                shown.add(line)
            else:
                show(message, category, *place, **more)

        warnings.showwarning = show_in_one_line
        yield


@cache
def parser(command: str | None = None) -> argparse.ArgumentParser:
    """The whole command line, or the part of it that has a command: modules of other commands are not imported."""
    whole = Parser(
        prog="evcot",
        description=f"Event-camera object tracking: hardware, model and software in lock-step.\n\n{_EXAMPLES}",
        formatter_class=HelpFormatter,
    )
    whole.add_argument("--version", action="version", version=f"evcot {evcot.__version__}")
    commands: Any = whole.add_subparsers(required=True, metavar="COMMAND")
    for adds in [_ADDED_BY[command]] if command else dict.fromkeys(_ADDED_BY.values()):
        resolve_name(f"{__package__}.commands.{adds}")(commands)
    if command is None:
        _add_completion(commands, whole)
    return whole


def _add_completion(commands: Any, whole: argparse.ArgumentParser) -> None:
    """Add `evcot completion`: print the script with which a shell completes commands, options, values and file names."""
    completion = add_command(commands, "completion", "print a shell's completion script", _COMPLETION_EXAMPLES)
    completion.add_argument("shell", choices=("bash", "zsh", "fish"), metavar="SHELL", help="bash, zsh or fish")
    completion.set_defaults(whole=whole)
