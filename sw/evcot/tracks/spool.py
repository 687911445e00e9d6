# SPDX-License-Identifier: Apache-2.0
"""A track log of any length on its way to its file: records and owners in two raw files that grow as a tracker goes on.

From there they are written in the form that is wanted. A raw file can be cut back to what a checkpoint knows of it, which a
finished file cannot.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Lock
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..errors import OutputError
from .record import TRACK

__all__ = ["Column", "LogColumns", "LogSpool", "RawColumn"]

_RUN = 1 << 16


class Column(Protocol):
    """Values of which a part can be had as an array."""

    def __len__(self) -> int: ...

    def __getitem__(self, part: slice, /) -> NDArray[Any]: ...


class LogColumns(Protocol):
    """A track log whose parts can be had one after the other: a `TrackLog`, or a `LogSpool`."""

    @property
    def engine(self) -> str: ...

    @property
    def recording(self) -> str: ...

    @property
    def records(self) -> Column: ...

    @property
    def owner(self) -> Column: ...


class RawColumn:
    """Values of one type in a raw file, appended at its end and read in parts.

    Args:
        path: made if it does not exist.
        dtype: of a value.
        length: values that it is cut back to.
    """

    def __init__(self, path: Path, dtype: np.dtype[Any], length: int = 0) -> None:
        self._dtype = dtype
        self._length = length
        self._file = path.open("r+b" if path.exists() else "x+b")
        self._one = Lock()  # several threads may read
        self._file.truncate(length * dtype.itemsize)

    def append(self, values: NDArray[Any]) -> None:
        """Add values at the end."""
        with self._named():
            self._file.seek(self._length * self._dtype.itemsize)
            self._file.write(np.ascontiguousarray(values, self._dtype).tobytes())
        self._length += len(values)

    def flush(self) -> None:
        """Hand everything to the operating system."""
        with self._named():
            self._file.flush()

    @contextmanager
    def _named(self) -> Iterator[None]:
        """OutputError, which names the file, where the disk is full."""
        try:
            yield
        except OSError as error:
            raise OutputError(f"{self._file.name}: cannot be written: {error.strerror or error}") from error

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, part: slice) -> NDArray[Any]:
        begin, end, step = part.indices(self._length)
        assert step == 1
        with self._one:
            self._file.seek(begin * self._dtype.itemsize)
            data = self._file.read(max(end - begin, 0) * self._dtype.itemsize)
        return np.frombuffer(data, self._dtype)


class LogSpool:
    """A log that grows in a folder.

    Args:
        folder: holds its two files.
        name: what their names begin with.
        lengths: records and owners to which files that are there are cut back.

    Attributes:
        engine, recording: as of `TrackLog`; to be set before the log is written.
        records, owner: what there is so far.
    """

    def __init__(self, folder: Path, name: str, lengths: tuple[int, int] = (0, 0)) -> None:
        self.engine = ""
        self.recording = ""
        self.records = RawColumn(folder / f"{name}.records", TRACK, lengths[0])
        self.owner = RawColumn(folder / f"{name}.owner", np.dtype(np.int16), lengths[1])

    def add(self, records: NDArray[np.void], owner: NDArray[np.int16]) -> None:
        """Append what a tracker returned for a run of events."""
        self.records.append(records)
        self.owner.append(owner)

    def record_runs(self) -> Iterator[NDArray[np.void]]:
        """All records, run by run, as `reading.RecordRuns`."""
        for begin in range(0, len(self.records), _RUN):
            yield self.records[begin : begin + _RUN].copy()

    def count_owners(self) -> int:
        """Number of owners."""
        return len(self.owner)

    @property
    def lengths(self) -> tuple[int, int]:
        """Number of records and of owners."""
        return len(self.records), len(self.owner)

    def flush(self) -> None:
        """Hand everything to the operating system."""
        self.records.flush()
        self.owner.flush()

    def close(self) -> None:
        """Close the files."""
        self.records.close()
        self.owner.close()
