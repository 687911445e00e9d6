# SPDX-License-Identifier: Apache-2.0
"""Files that a command takes: opened as the options say, each done on its own, long work on one continued; and the logs of a
run or a recording: commands that take both refuse the log of another recording."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from evcot.errors import EvcotError, RecordingError, TrackLogError
from evcot.events import Events
from evcot.tracks import PARQUET
from evcot.tracks.log import TrackLog
from evcot.tracks.log_files import Extent, RecordRuns, check_belongs

from ...rtl.files import code_fingerprint
from ...standard_streams import as_file
from ..options import sensor_from
from ..parsing import USER_ERROR, say_error

if TYPE_CHECKING:
    from evcot.recognition.weights import Weights
    from evcot.recordings.files import Damage, RecordingFile

__all__ = ["check_logs", "done_each", "log_of_run", "open_from", "run_extent", "say_resumed", "weights_from", "work_key"]

_File = TypeVar("_File")
_Result = TypeVar("_Result")


def done_each(options: argparse.Namespace, files: Sequence[_File], do: Callable[[_File], _Result]) -> tuple[list[_Result], int]:
    """The results of those files with which it could be done, and the exit code: 2 if there was an error, else 0.

    The error of one of several files is printed, and the others are done.

    Raises:
        EvcotError: that of a single file.
    """
    if len(files) == 1:
        return [do(files[0])], 0
    results, code = [], 0
    for file in files:
        try:
            results.append(do(file))
        except EvcotError as error:
            sys.stdout.flush()
            say_error(error, options)
            code = USER_ERROR
    return results, code


def weights_from(options: argparse.Namespace) -> Weights | None:
    """The weights of --classify, None without it.

    Raises:
        ConfigError: they cannot be read.
    """
    if options.classify is None:
        return None
    from evcot.recognition.weights import Weights  # with Numba

    return Weights.load(as_file(options.classify))


def open_from(options: argparse.Namespace, path: Path) -> RecordingFile:
    """Open a recording as the options say.

    Raises:
        ConfigError: --sensor that is no size.
        RecordingError: as `open_recording`.
    """
    from evcot.recordings.files import open_recording  # here, as commands that read logs alone do without all formats

    damage: Damage = "skip" if options.skip_damaged else "refuse"
    return open_recording(as_file(path), sensor_from(options), damage=damage, struct=options.struct)


def work_key(path: Path, *depends_on: object) -> str:
    """A text that changes with a recording's file, with the program, and with what else a result depends on.

    Args:
        depends_on: each with a `repr` that says all of it.
    """
    try:
        found = os.stat(path)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror or error}") from error
    identity = str(path.absolute()), found.st_size, found.st_mtime_ns, code_fingerprint()
    return blake2b(repr((identity, depends_on)).encode(), digest_size=16).hexdigest()


def say_resumed(name: str, events: int) -> None:
    """Say that work is continued, a line on stderr."""
    print(f"{name}: continues after {events:,} events, where it was ended before", file=sys.stderr)


def log_of_run(folder: Path, name: str) -> Path:
    """The log of an engine in the folder of a run, .npz, or .parquet of a long one; it need not exist."""
    parquet = folder / f"{name}{PARQUET}"
    return parquet if parquet.is_file() else folder / f"{name}.npz"


def check_logs(logs: Iterable[tuple[Path, RecordRuns]], recording: str, *extents: Extent) -> None:
    """Raise TrackLogError, in the name of its file, for a log that is of none of these extents of a recording.

    Args:
        extents: the first is that of which the message speaks.
    """
    for path, log in logs:
        errors = [error for extent in extents if (error := _error(log, extent)) is not None]
        if len(errors) == len(extents):
            raise TrackLogError(f"{path}: does not belong to {recording}: {errors[0]}") from errors[0]


def run_extent(events: Events, logs: Iterable[TrackLog], summary: Mapping[str, Any]) -> Extent:
    """What the logs of a run must fit: all its events or, where a mismatch ended it, those that were decided."""
    decided = min((len(log.owner) for log in logs), default=0) if "mismatch" in summary else len(events)
    return Extent.of([events[:decided]])


def _error(log: RecordRuns, extent: Extent) -> TrackLogError | None:
    try:
        check_belongs(log, extent)
    except TrackLogError as error:
        return error
    return None
