# SPDX-License-Identifier: Apache-2.0
"""Read and write logs of any length part by part, in bounded memory; check that a log belongs to a recording."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..digest import EventsDigest
from ..errors import TrackLogError
from ..events import Events
from ..outputs import suffix_of, written_aside
from . import CSV, LOG_SUFFIXES, PARQUET
from .column import Column
from .npz import NpzFile
from .parquet import LogFile, check_parquet, write_log
from .record import TRACK, VERDICT, ClassNames, Kind, class_names_text, classes_at
from .spool import LogColumns

__all__ = [
    "Extent",
    "RecordRuns",
    "check_belongs",
    "check_log_path",
    "in_the_name_of",
    "open_log",
    "save_log",
    "write_csv",
    "write_npz",
]


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

    @property
    def verdicts(self) -> NDArray[np.void]:
        """(k,) of dtype `VERDICT`, as of `TrackLog`."""

    @property
    def class_names(self) -> ClassNames:
        """As of `TrackLog`."""


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


_ROWS = 1 << 16  # written at a time


def check_log_path(path: Path | str) -> None:
    """Raise OutputError or TrackLogError, before the work, for an unknown suffix, and for Parquet without pyarrow."""
    if suffix_of(Path(path), LOG_SUFFIXES) == PARQUET:
        check_parquet(path)


def save_log(log: LogColumns, path: Path | str, *, force: bool = False) -> None:
    """Write a log in the format of its suffix, one of `LOG_SUFFIXES`; CSV has the records alone, without owners.

    Raises:
        OutputError: an unknown suffix, the file exists (without `force`), or it cannot be written.
        TrackLogError: pyarrow is not installed.
    """
    write = {PARQUET: write_log, CSV: write_csv}.get(suffix_of(Path(path), LOG_SUFFIXES), write_npz)
    write(log, path, force=force)


def write_npz(log: LogColumns, path: Path | str, *, force: bool = False) -> None:
    """Write a log as `np.savez_compressed` would; equal logs give identical files.

    Raises:
        OutputError: the file exists (without `force`), or cannot be written.
    """
    arrays: dict[str, tuple[np.dtype[Any], Column | NDArray[Any]]] = {
        "engine": (np.array(log.engine).dtype, np.array(log.engine)),
        "records": (TRACK, log.records),
        "owner": (np.dtype(np.int16), log.owner),
    }
    if log.recording:
        arrays["recording"] = (np.array(log.recording).dtype, np.array(log.recording))
    if len(log.verdicts):
        arrays["verdicts"] = (VERDICT, log.verdicts)
    if log.class_names:
        names = np.array(class_names_text(log.class_names))
        arrays["class_names"] = (names.dtype, names)
    with (
        written_aside(Path(path), force=force) as file,
        zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive,
    ):
        for name, (dtype, values) in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                _write_array(member, dtype, values)


def _write_array(member: IO[bytes], dtype: np.dtype[Any], values: Column | NDArray[Any]) -> None:
    text = isinstance(values, np.ndarray) and not values.ndim
    header = {"descr": np.lib.format.dtype_to_descr(dtype), "fortran_order": False, "shape": () if text else (len(values),)}
    np.lib.format.write_array_header_1_0(member, header)
    if text:
        member.write(np.asarray(values).tobytes())
        return
    for begin in range(0, len(values), _ROWS):
        member.write(np.ascontiguousarray(values[begin : begin + _ROWS], dtype).tobytes())


def write_csv(log: LogColumns, path: Path | str, *, force: bool = False) -> None:
    """Write the records as CSV: a header, kinds by name, every number with the fewest digits that round-trip exactly.

    A log with verdicts has one more column, `class_id`: the class of the record's track at its time, -1 for none.

    Raises:
        OutputError: the file exists (without `force`), or cannot be written.
    """
    names = np.array([kind.name for kind in Kind])
    with written_aside(Path(path), force=force) as file:
        classified = len(log.verdicts) > 0
        file.write((",".join((*(TRACK.names or ()), *(["class_id"] if classified else []))) + "\n").encode())
        for begin in range(0, len(log.records), _ROWS):
            rows = log.records[begin : begin + _ROWS]
            columns = [
                names[rows["kind"]].tolist() if name == "kind" else [repr(value) for value in rows[name].tolist()]
                for name in TRACK.names or ()
            ]
            if classified:
                columns.append([str(one) for one in classes_at(log.verdicts, rows["track_id"], rows["t_us"]).tolist()])
            file.write("".join(",".join(row) + "\n" for row in zip(*columns, strict=True)).encode())


# Check that a log belongs to a recording: by the fingerprint of the events, if the log has one, and by its extent.
#
# The extent matches if there are as many owners as events, and no record before, after or beyond them.


@dataclass(frozen=True)
class Extent:
    """What a log must match: number of events, first and last time, and the fingerprint (`digest.digest`)."""

    events: int
    first_us: int
    last_us: int
    digest: str

    @classmethod
    def of(cls, blocks: Iterable[Events]) -> Extent:
        """The extent of blocks of events; times are 0 without events."""
        count, first_us, last_us, summary = 0, 0, 0, EventsDigest()
        for block in blocks:
            if len(block):
                first_us = first_us if count else int(block.t_us[0])
                last_us = int(block.t_us[-1])
                count += len(block)
                summary.add(block)
        return cls(count, first_us, last_us, summary.hex())


def check_belongs(log: RecordRuns, to: Extent) -> None:
    """Raise TrackLogError for a log of other events than these."""
    owners = log.count_owners()
    if owners != to.events:
        raise TrackLogError(f"owner has {owners} entries: must be one for each of the recording's {to.events} events")
    if log.recording and log.recording != to.digest:
        raise TrackLogError(f"recording = {log.recording!r}: must be the digest of the recording's events, {to.digest!r}")
    first = 0
    for records in log.record_runs():
        for name, low, high in (("event_index", 0, to.events), ("t_us", to.first_us, to.last_us)):
            good = (records[name] >= low) & (records[name] <= high)
            if not good.all():
                row = int(np.argmin(good))
                rule = f"must be from {low} to {high}, as the recording's events are"
                raise TrackLogError(f"record {first + row}: {name} = {records[name][row]}: {rule}")
        first += len(records)
