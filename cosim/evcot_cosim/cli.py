# SPDX-License-Identifier: Apache-2.0
"""The command line: one module per group of commands. Exit codes: 0 done, 1 hardware and model differ, 2 something that the
user can mend."""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import evcot
from evcot.errors import EvcotError, RecordingWarning

from .commands import anomalies, cosim, evaluate, presets, recordings, simulate, track, waves
from .commands import filter as filter_command
from .commands.cosim import MISMATCH
from .lockstep import MismatchError

__all__ = ["main"]

USER_ERROR = 2

_EXAMPLES = """examples:
  evcot cosim                                   the box experiment, nothing to download
  evcot cosim drive.aedat4                      a camera file, with the preset for its sensor
  evcot cosim drive.aedat4 --preset slow --slots 16 --stalls 7
  evcot waves drive.aedat4 --from 120 --to 125  a waveform of 5 ms, to open in GTKWave
  evcot presets --json
  evcot info drive.aedat4                       sensor, length, rates, busiest pixels
  evcot convert drive.aedat4 drive.csv --to 500 its first half second, as text
  evcot simulate highway -o highway.aedat4      a scene, and its truth beside it
  evcot cosim highway --activity 5              filters, then hardware, model and software tracker, on a scene
  evcot track highway.aedat4 --preset traffic -o log.npz       a software tracker alone, fast
  evcot evaluate log.npz --truth highway.truth.csv
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns its exit code. An interrupt is the caller's to report."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    options = _parser().parse_args(arguments)
    try:
        with _warnings_in_one_line():
            code: int = options.command(options, arguments)
        return code
    except MismatchError as error:
        print(f"evcot: MISMATCH: {error}", file=sys.stderr)
        return MISMATCH
    except EvcotError as error:
        print(f"evcot: {error}", file=sys.stderr)
        return USER_ERROR
    except BrokenPipeError:
        return 0
    except OSError as error:  # a full disk under a cache, and the like
        print(f"evcot: {error.filename or 'a file'}: {error.strerror or error}", file=sys.stderr)
        return USER_ERROR


@contextmanager
def _warnings_in_one_line() -> Iterator[None]:
    """What is left out of a recording is told as errors are."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", RecordingWarning)
        show = warnings.showwarning

        def show_in_one_line(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
            if issubclass(category, RecordingWarning):
                print(f"evcot: warning: {message}", file=sys.stderr)
            else:
                show(message, category, *place, **more)

        warnings.showwarning = show_in_one_line
        yield


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="evcot",
        description="Event-camera object tracking: hardware, model and software in lock-step.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"evcot {evcot.__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for group in (cosim, waves, track, simulate, recordings, filter_command, evaluate, anomalies, presets):
        group.add(commands)
    return parser
