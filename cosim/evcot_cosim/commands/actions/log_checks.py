# SPDX-License-Identifier: Apache-2.0
"""The logs of a run or a recording; commands that take both refuse the log of another recording."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from evcot.errors import TrackLogError
from evcot.events import Events
from evcot.tracks.log import TrackLog
from evcot.tracks.log_files import Extent, RecordRuns, check_belongs
from evcot.tracks.suffixes import PARQUET

__all__ = ["check_logs", "log_of_run", "run_extent"]


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
