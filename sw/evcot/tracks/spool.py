# SPDX-License-Identifier: Apache-2.0
"""A track log before it is written: records, owners and counts that grow while a tracker runs, in memory or in two files.

From there they are written in the form that is wanted. The files can be cut back to the length noted by a checkpoint, which a
finished file cannot.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from .column import Column, GrowingColumn, HeldColumn, PackedColumn
from .record import TRACK, ClassNames, no_verdicts
from .tally import Tally

__all__ = ["LogColumns", "LogSpool", "SpoolState"]

_RUN = 1 << 16
_OWNER = np.dtype(np.int16)


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


class SpoolState(NamedTuple):
    """What a checkpoint keeps of a log: numbers of records and of owners in its files, and its counts."""

    records: int = 0
    owners: int = 0
    tally: Tally | None = None


class LogSpool:
    """A log that grows.

    Args:
        folder: holds its two files; None keeps the log in memory.
        name: what the files' names begin with.
        state: to which files that are there are cut back.

    Attributes:
        engine, recording, verdicts, class_names: as of `TrackLog`; to be set before the log is written.
        records, owner: what there is so far.
        tally: what was counted in them.
    """

    def __init__(self, folder: Path | None, name: str, state: SpoolState | None = None) -> None:
        self.engine = ""
        self.recording = ""
        self.verdicts = no_verdicts()
        self.class_names: ClassNames = {}
        state = state or SpoolState()
        self.tally = state.tally or Tally()
        self._files: list[PackedColumn] = []
        self.records: GrowingColumn = HeldColumn(TRACK)
        self.owner: GrowingColumn = HeldColumn(_OWNER)
        if folder is not None:
            self.records = records = PackedColumn(folder / f"{name}.records", TRACK, state.records)
            self.owner = owner = PackedColumn(folder / f"{name}.owner", _OWNER, state.owners)
            self._files = [records, owner]

    def add(self, records: NDArray[np.void], owner: NDArray[np.int16]) -> None:
        """Append what a tracker returned for a run of events."""
        self.records.append(records)
        self.owner.append(owner)
        self.tally.add(records, owner)

    def record_runs(self) -> Iterator[NDArray[np.void]]:
        """All records, run by run, as `reading.RecordRuns`."""
        for begin in range(0, len(self.records), _RUN):
            yield self.records[begin : begin + _RUN].copy()

    def count_owners(self) -> int:
        """Number of owners."""
        return len(self.owner)

    def state(self) -> SpoolState:
        """Put everything on the disk; returns what a checkpoint must keep."""
        for file in self._files:
            file.flush()
        return SpoolState(len(self.records), len(self.owner), self.tally)

    def close(self) -> None:
        """Close the files."""
        for file in self._files:
            file.close()
