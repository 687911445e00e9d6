# SPDX-License-Identifier: Apache-2.0
"""What a live run leaves on disk, written while it runs: a kill loses less than a second."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.errors import ConfigError, OutputError, RecordingError
from evcot.events import Events
from evcot.outputs import check_file, new_file, spool_folder
from evcot.recordings.files import format_for
from evcot.recordings.formats.aedat4_sink import Aedat4Sink
from evcot.recordings.formats.evt_writers import Evt3Sink
from evcot.recordings.formats.source import Sensor
from evcot.tracks.log import TRACK, TrackLog

__all__ = ["FLUSH_S", "LogKeeper", "Recorder"]

FLUSH_S = 0.25  # the longest that an event waits in memory
_BUFFER_BYTES = 1 << 22


class Recorder:
    """Events into a file that can be read whenever the process ends.

    Args:
        path: `.aedat4` or `.raw` (EVT 3.0).
        force: replace a file that exists.

    Attributes:
        events: how many have been written.

    Raises:
        ConfigError: another suffix.
        OutputError: the file exists, or cannot be written.
    """

    def __init__(self, path: Path, sensor: Sensor, *, force: bool = False) -> None:
        kind = format_for(path)
        if kind.begin not in (Aedat4Sink, Evt3Sink):
            raise ConfigError(f"--save {path}: must end in .aedat4 or .raw: only these can be read after a kill")
        self.path = path
        self.events = 0
        self._file = new_file(path, force=force, buffering=_BUFFER_BYTES)
        self._sink = kind.begin(self._file, sensor)
        self._file.flush()
        self._flushed_s = time.monotonic()

    def write(self, events: Events) -> None:
        """Append events; what has waited for `FLUSH_S` goes to the system."""
        try:
            self._sink.write(events)
            self.events += len(events)
            self.flush_if_due()
        except RecordingError as error:
            raise RecordingError(f"{self.path}: {error}") from error
        except OSError as error:
            raise _unwritable(self.path, error) from error

    def flush_if_due(self) -> None:
        """Give the system what has waited long enough."""
        now_s = time.monotonic()
        if now_s - self._flushed_s >= FLUSH_S:
            if isinstance(self._sink, Aedat4Sink):
                self._sink.flush()
            self._file.flush()
            self._flushed_s = now_s

    def close(self) -> None:
        """End the file as its format wants it; once is enough."""
        if self._file.closed:
            return
        try:
            with self._file:
                self._sink.close()
        except OSError as error:
            raise _unwritable(self.path, error) from error

    def drop(self) -> None:
        """End the file where nobody has; one in which nothing was recorded does not stay."""
        if not self._file.closed:
            self.close()
            if not self.events and self.path.is_file():
                self.path.resolve().unlink()


class LogKeeper:
    """Records and owners, kept in files without names until the run ends: memory does not grow.

    Args:
        force: replace a file that exists.

    Raises:
        ConfigError: another suffix than .npz.
        OutputError: the file exists, or nothing can be written there.
    """

    def __init__(self, path: Path, engine: str, *, force: bool = False) -> None:
        if path.suffix != ".npz":
            raise ConfigError(f"--save-log {path}: must end in .npz")
        check_file(path, force=force)
        self.path, self._engine, self._force = path, engine, force
        self._records = _Spool(path, TRACK)
        self._owner = _Spool(path, np.dtype(np.int16))

    def add(self, records: NDArray[np.void], owner: NDArray[np.int16]) -> None:
        """Append what a tracker told."""
        self._records.add(records)
        self._owner.add(owner)

    def close(self) -> None:
        """Write the log."""
        TrackLog(self._engine, self._records.array(), self._owner.array()).save_npz(self.path, force=self._force)
        self.drop()

    def drop(self) -> None:
        """Forget what has not been written."""
        self._records.close()
        self._owner.close()


class _Spool:
    """An array that grows on disk."""

    def __init__(self, path: Path, dtype: np.dtype[Any]) -> None:
        self._path, self._dtype = path, dtype
        try:
            self._file = tempfile.TemporaryFile(dir=spool_folder(path))  # noqa: SIM115
        except OSError as error:
            raise _unwritable(path, error) from error

    def add(self, rows: NDArray[Any]) -> None:
        try:
            self._file.write(np.ascontiguousarray(rows).view(np.uint8).data)
        except OSError as error:
            raise _unwritable(self._path, error) from error

    def array(self) -> NDArray[Any]:
        self._file.flush()
        return np.memmap(self._file, self._dtype, "r") if self._file.tell() else np.empty(0, self._dtype)

    def close(self) -> None:
        self._file.close()


def _unwritable(path: Path, error: OSError) -> OutputError:
    return OutputError(f"{path}: cannot be written: {error.strerror or error}")
