# SPDX-License-Identifier: Apache-2.0
"""Files of a live run, written while it runs: if the process is killed, less than a second is lost."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.errors import ConfigError, OutputError, RecordingError, reason_of
from evcot.events import Events
from evcot.outputs import check_file, new_file, spool_folder
from evcot.recordings.files import format_for
from evcot.recordings.formats.aedat4_sink import Aedat4Sink
from evcot.recordings.formats.evt_writers import Evt3Sink
from evcot.recordings.formats.source import Sensor
from evcot.tracks.log import TRACK, VERDICT, TrackLog
from evcot.tracks.record import NO_NAMES, ClassNames

__all__ = ["LogKeeper", "Recorder"]

FLUSH_S = 0.25  # the longest that an event waits in memory
_BUFFER_BYTES = 1 << 22


class Recorder:
    """Writes events to a file that is readable whenever the process ends.

    Args:
        path: `.aedat4` or `.raw` (EVT 3.0).
        force: replace a file that exists.

    Attributes:
        events: number of events written.

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
        """Append events; those older than `FLUSH_S` are flushed."""
        try:
            self._sink.write(events)
            self.events += len(events)
            self.flush_if_due()
        except RecordingError as error:
            raise RecordingError(f"{self.path}: {error}") from error
        except OSError as error:
            raise _unwritable(self.path, error) from error

    def flush_if_due(self) -> None:
        """Flush events that have been buffered for `FLUSH_S`."""
        now_s = time.monotonic()
        if now_s - self._flushed_s >= FLUSH_S:
            if isinstance(self._sink, Aedat4Sink):
                self._sink.flush()
            self._file.flush()
            self._flushed_s = now_s

    def close(self) -> None:
        """Complete the file as its format requires; further calls have no effect."""
        if self._file.closed:
            return
        try:
            with self._file:
                self._sink.close()
        except OSError as error:
            raise _unwritable(self.path, error) from error

    def drop(self) -> None:
        """Complete the file if that has not been done; a file without events is removed."""
        if not self._file.closed:
            self.close()
            if not self.events and self.path.is_file():
                self.path.resolve().unlink()


class LogKeeper:
    """Collects a log in temporary files until the run ends, so that memory does not grow.

    Args:
        class_names: as of `TrackLog`.
        force: replace a file that exists.

    Raises:
        ConfigError: another suffix than .npz.
        OutputError: the file exists, or nothing can be written there.
    """

    def __init__(self, path: Path, engine: str, class_names: ClassNames = NO_NAMES, *, force: bool = False) -> None:
        if path.suffix != ".npz":
            raise ConfigError(f"--save-log {path}: must end in .npz")
        check_file(path, force=force)
        self.path, self._engine, self._class_names, self._force = path, engine, class_names, force
        self._records = _Spool(path, TRACK)
        self._owner = _Spool(path, np.dtype(np.int16))
        self._verdicts = _Spool(path, VERDICT)

    def add(self, records: NDArray[np.void], owner: NDArray[np.int16], verdicts: NDArray[np.void]) -> None:
        """Append a tracker's records, owners and verdicts."""
        for spool, rows in ((self._records, records), (self._owner, owner), (self._verdicts, verdicts)):
            spool.add(rows)

    def close(self) -> None:
        """Write the log."""
        verdicts, names = self._verdicts.array(), self._class_names
        log = TrackLog(self._engine, self._records.array(), self._owner.array(), verdicts=verdicts, class_names=names)
        log.save_npz(self.path, force=self._force)
        self.drop()

    def drop(self) -> None:
        """Discard everything not yet written."""
        for spool in (self._records, self._owner, self._verdicts):
            spool.close()


class _Spool:
    """An append-only array on disk."""

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
    return OutputError(f"{path}: cannot be written: {reason_of(error, path)}")
