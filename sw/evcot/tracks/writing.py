# SPDX-License-Identifier: Apache-2.0
"""Write a track log of any length: part by part, so that memory does not depend on it."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from ..outputs import suffix_of, written_aside
from .column import Column
from .parquet import check_parquet, write_log
from .record import TRACK, Kind
from .spool import LogColumns
from .suffixes import CSV, LOG_SUFFIXES, PARQUET

__all__ = ["check_log_path", "save_log", "write_csv", "write_npz"]

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

    Raises:
        OutputError: the file exists (without `force`), or cannot be written.
    """
    names = np.array([kind.name for kind in Kind])
    with written_aside(Path(path), force=force) as file:
        file.write((",".join(TRACK.names or ()) + "\n").encode())
        for begin in range(0, len(log.records), _ROWS):
            rows = log.records[begin : begin + _ROWS]
            columns = [
                names[rows["kind"]].tolist() if name == "kind" else [repr(value) for value in rows[name].tolist()]
                for name in TRACK.names or ()
            ]
            file.write("".join(",".join(row) + "\n" for row in zip(*columns, strict=True)).encode())
