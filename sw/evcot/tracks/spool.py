# SPDX-License-Identifier: Apache-2.0
"""A track log of any length before it is written: records and owners in two files that grow while a tracker runs.

From there they are written in the form that is wanted. These files can be cut back to the length noted by a checkpoint, which a
finished file cannot.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .column import Column, PackedColumn
from .record import TRACK, ClassNames, no_verdicts

__all__ = ["LogColumns", "LogSpool"]

_RUN = 1 << 16


class LogColumns(Protocol):
    """A track log that can be read part by part: a `TrackLog`, or a `LogSpool`."""

    @property
    def engine(self) -> str: ...

    @property
    def recording(self) -> str: ...

    @property
    def records(self) -> Column: ...

    @property
    def owner(self) -> Column: ...

    @property
    def verdicts(self) -> NDArray[np.void]: ...

    @property
    def class_names(self) -> ClassNames: ...


class LogSpool:
    """A log that grows in a folder.

    Args:
        folder: holds its two files.
        name: what their names begin with.
        lengths: records and owners to which files that are there are cut back.

    Attributes:
        engine, recording, verdicts, class_names: as of `TrackLog`; to be set before the log is written.
        records, owner: what there is so far.
    """

    def __init__(self, folder: Path, name: str, lengths: tuple[int, int] = (0, 0)) -> None:
        self.engine = ""
        self.recording = ""
        self.verdicts = no_verdicts()
        self.class_names: ClassNames = {}
        self.records = PackedColumn(folder / f"{name}.records", TRACK, lengths[0])
        self.owner = PackedColumn(folder / f"{name}.owner", np.dtype(np.int16), lengths[1])

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
        """Put everything on the disk."""
        self.records.flush()
        self.owner.flush()

    def close(self) -> None:
        """Close the files."""
        self.records.close()
        self.owner.close()
