# SPDX-License-Identifier: Apache-2.0
"""Logs that are read run by run, in memory that does not depend on their length."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..errors import TrackLogError
from .npz import NpzFile
from .parquet import LogFile
from .suffixes import PARQUET

__all__ = ["RecordRuns", "in_the_name_of", "open_log"]


class RecordRuns(Protocol):
    """A log whose records can be read run by run, as often as they are needed: a `TrackLog`, or the file of one."""

    @property
    def engine(self) -> str:
        """Name of the engine that made the log."""

    @property
    def recording(self) -> str:
        """Digest of the recording's events; empty if unknown."""

    def record_runs(self) -> Iterator[NDArray[np.void]]:
        """The records in order, in arrays of bounded length; from the beginning at each call."""

    def count_owners(self) -> int:
        """Number of owners, one for each event."""


def open_log(path: Path | str) -> LogFile | NpzFile:
    """The file of a log.

    Raises:
        TrackLogError: the file is missing, damaged, or not a TrackLog.
    """
    opened: Callable[[Path | str], LogFile | NpzFile] = LogFile if Path(path).suffix.lower() == PARQUET else NpzFile
    return opened(path)


@contextmanager
def in_the_name_of(path: Path | str) -> Iterator[None]:
    """Errors of a log name its file."""
    try:
        yield
    except TrackLogError as error:
        message = str(error)
        raise TrackLogError(message if message.startswith(f"{path}: ") else f"{path}: {message}") from error
