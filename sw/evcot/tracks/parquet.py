# SPDX-License-Identifier: Apache-2.0
"""A TrackLog as one Parquet file, for pandas, polars, DuckDB and everything else that reads columns.

A row is a record: the fields of `TRACK`, `kind` by name, and `owners`, the owners of the events after those of the row
before, up to and with the record's own. The last row is no record: its kind is END, and its `owners` are those of the events
that are left. So all `owners` one after the other are the log's, in the order of the events. Engine and recording stand in the
metadata.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import TrackLogError
from ..outputs import note_input, path_written_aside

if TYPE_CHECKING:
    from .log import TrackLog

__all__ = ["SUFFIX", "read_log", "write_log"]

SUFFIX = ".parquet"
_END = "END"
_OWNERS = "owners"
_ROWS = 1 << 16  # of a row group
_NEEDED = "pyarrow is not installed: must be, for Parquet: pip install 'evcot[sweep]'"


def write_log(log: TrackLog, path: Path | str, *, force: bool = False) -> None:
    """Write a log; equal logs give identical files.

    Raises:
        TrackLogError: pyarrow is not installed.
        OutputError: the file exists, or cannot be written.
    """
    arrow = _arrow(path)
    from .log import TRACK, Kind

    records, owner = log.records, log.owner
    names = [kind.name for kind in Kind] + [_END]
    kinds = np.append(records["kind"], np.uint8(len(Kind))).astype(np.int8)
    columns: dict[str, Any] = {}
    for name in TRACK.names or ():
        if name == "kind":
            columns[name] = arrow.DictionaryArray.from_arrays(arrow.array(kinds), arrow.array(names)).cast(arrow.string())
        else:
            values = np.append(np.ascontiguousarray(records[name]), np.zeros(1, TRACK[name]))
            columns[name] = arrow.array(values, mask=np.arange(len(values)) == len(records))
    ends = np.minimum(np.maximum.accumulate(records["event_index"] + 1, dtype=np.int64), len(owner))
    offsets = np.concatenate(([0], np.maximum(ends, 0), [len(owner)])).astype(np.int64)
    columns[_OWNERS] = arrow.LargeListArray.from_arrays(arrow.array(offsets), arrow.array(np.asarray(owner, np.int16)))
    table = arrow.table(columns).replace_schema_metadata({"engine": log.engine, "recording": log.recording})
    with path_written_aside(Path(path), force=force) as aside:
        arrow.parquet.write_table(table, aside, compression="zstd", row_group_size=_ROWS, write_page_checksum=True)


def read_log(path: Path | str) -> TrackLog:
    """Read a log that `write_log` wrote.

    Raises:
        TrackLogError: the file is missing, damaged, or not a TrackLog; or pyarrow is not installed.
    """
    arrow = _arrow(path)
    from .log import TRACK, TrackLog

    note_input(path)
    try:
        with Path(path).open("rb") as file:
            table = arrow.parquet.read_table(file, page_checksum_verification=True)
    except (arrow.ArrowException, ValueError, OSError) as error:
        if isinstance(error, OSError) and error.strerror:
            raise TrackLogError(f"{path}: cannot be read: {error.strerror}") from error
        raise TrackLogError(f"{path}: is damaged, or no Parquet file: {' '.join(str(error).split())[:120]}") from error
    wanted = [*(TRACK.names or ()), _OWNERS]
    lacking = [name for name in wanted if name not in table.column_names]
    if lacking:
        raise TrackLogError(f"{path}: lacks {', '.join(lacking)}: must be a log as `evcot track -o LOG.parquet` writes it")
    codes = _kinds(path, table.column("kind").to_pylist())
    records = np.zeros(len(codes), TRACK)
    records["kind"] = codes
    for name in TRACK.names or ():
        if name != "kind":
            records[name] = _values(path, table.column(name).slice(0, len(codes)), name, TRACK[name])
    owners = _values(path, _flat(path, arrow, table.column(_OWNERS)), _OWNERS, np.dtype(np.int16))
    about = table.schema.metadata or {}
    text = {name: about.get(name.encode(), b"").decode(errors="replace") for name in ("engine", "recording")}
    return TrackLog(text["engine"], records, owners, text["recording"])


def _arrow(path: Path | str) -> Any:
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise TrackLogError(f"{path}: {_NEEDED}") from error
    return pyarrow


def _kinds(path: Path | str, names: list[str | None]) -> NDArray[np.uint8]:
    """The kinds of all rows but the last, which ends the log."""
    from .log import Kind

    if not names or names[-1] != _END:
        raise TrackLogError(f"{path}: the last row is no {_END}: must be a whole log")
    codes = {kind.name: int(kind) for kind in Kind}
    for row, name in enumerate(names[:-1]):
        if name not in codes:
            raise TrackLogError(f"{path}: row {row}: kind = {name!r}: must be one of {', '.join(codes)}")
    return np.array([codes[name or ""] for name in names[:-1]], np.uint8)


def _flat(path: Path | str, arrow: Any, column: Any) -> Any:
    kind = column.type
    if not (arrow.types.is_large_list(kind) or arrow.types.is_list(kind)):
        raise TrackLogError(f"{path}: {_OWNERS} is {kind}: must be a list of int16")
    return column.combine_chunks().flatten()


def _values(path: Path | str, column: Any, name: str, dtype: np.dtype[Any]) -> NDArray[Any]:
    if column.null_count or str(column.type) != {"float64": "double"}.get(dtype.name, dtype.name):
        what = "has no value in some rows" if column.null_count else f"is {column.type}"
        raise TrackLogError(f"{path}: {name} {what}: must be {dtype}")
    return np.asarray(column.to_numpy(), dtype)
