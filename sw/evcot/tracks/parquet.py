# SPDX-License-Identifier: Apache-2.0
"""A track log as a Parquet file, for pandas, polars, DuckDB and everything else that reads columns.

A row is a record: the fields of `TRACK`, `kind` by name, and `owners`, the owners of the events after those of the row
before, up to and with the record's own. Where so many events have no record that a list would become long, rows of kind NONE
have owners alone. The last row is no record either: its kind is END, and its `owners` are those of the events that are left. So
all `owners` one after the other are the log's, in the order of the events. Engine and recording are in the metadata.

A log with verdicts begins with them: rows of kind VERDICT, in three more columns `class_id`, `margin` and `windows`, which are
empty in all other rows. The names of the classes are in the metadata.

Files are written and read a row group at a time. Arrow keeps 15 kB of each group until the file is closed, so a log of more
groups than a file may have goes on in another one: log.parquet, log.1.parquet and so on, of which only the last has a row END.
So memory does not depend on a log's length. The metadata of a file after the first say which part it is; no other is replaced.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Generator, Iterator
from contextlib import ExitStack, contextmanager
from itertools import chain, count, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import OutputError, TrackLogError
from ..outputs import note_input, path_written_aside
from .record import TRACK, VERDICT, ClassNames, Kind, class_names_from, class_names_text, no_verdicts

if TYPE_CHECKING:
    from .spool import LogColumns

__all__ = ["LogFile", "check_parquet", "write_log"]

_END, _NONE, _VERDICT = "END", "NONE", "VERDICT"
_OWNERS = "owners"
_COLUMNS = (*(TRACK.names or ()), _OWNERS)
_OF_VERDICT = tuple(name for name in VERDICT.names or () if name not in (TRACK.names or ()))
_REPEATED = ["kind", "track_id", "slot", "radius", "other_id", f"{_OWNERS}.list.element"]  # columns of few values
_RECORDS = 1 << 15  # of a row group, at most
_LIST_MAX = 1 << 16  # owners of a row, at most
_GROUP_OWNERS = 1 << 19  # of a row group, at most, and a row's more
_FILE_GROUPS = 1 << 9  # row groups of a file, at most
_NEEDED = "pyarrow is not installed: must be, for Parquet: pip install 'evcot[sweep]'"


def check_parquet(path: Path | str) -> None:
    """Raise TrackLogError if Parquet cannot be written here."""
    _arrow(path)


def write_log(log: LogColumns, path: Path | str, *, force: bool = False) -> None:
    """Write a log, a very long one into several files; equal logs give identical files.

    Raises:
        TrackLogError: pyarrow is not installed.
        OutputError: a file exists, or cannot be written.
    """
    arrow = _arrow(path)
    schema, about = _schema(arrow, classified=len(log.verdicts) > 0), {"engine": log.engine, "recording": log.recording}
    if log.class_names:
        about["class_names"] = class_names_text(log.class_names)
    tables = _tables(arrow, schema, log)
    with ExitStack() as files:  # the first gets its name last
        for number in count():
            if (first := next(tables, None)) is None:
                return
            own = _file_of(Path(path), number)
            if number and force and own.exists() and not _is_part(own, number, arrow):
                raise OutputError(f"{own}: exists, and is no part of {path}: must be moved away, or another log named")
            aside = files.enter_context(path_written_aside(own, force=force))
            of_file = schema.with_metadata(about | ({"part": str(number)} if number else {}))
            with arrow.parquet.ParquetWriter(
                aside, of_file, compression="zstd", use_dictionary=_REPEATED, write_page_checksum=True
            ) as writer:
                for table in chain([first], islice(tables, _FILE_GROUPS - 1)):
                    writer.write_table(table)


def _is_part(path: Path, number: int, arrow: Any) -> bool:
    """Whether a file that nobody has named is that part of a long log, so that another may replace it; not a log of its own."""
    try:
        schema = arrow.parquet.read_schema(path)
    except (OSError, ValueError, arrow.ArrowException):
        return False
    return set(_COLUMNS) <= set(schema.names) and (schema.metadata or {}).get(b"part") == str(number).encode()


def _file_of(path: Path, number: int) -> Path:
    """The file of this number of a log, from 0 on."""
    return path.with_name(f"{path.stem}.{number}{path.suffix}") if number else path


def _groups(log: LogColumns) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], int]]:
    """Row groups: the record of each row (-1: NONE, -2: END), the events decided after each row, and before the first."""
    n, n_records, begin = len(log.owner), len(log.records), 0
    for first in range(0, n_records + 1, _RECORDS):
        past = min(first + _RECORDS, n_records)
        ends = np.clip(np.maximum.accumulate(log.records[first:past]["event_index"].astype(np.int64) + 1), begin, max(n, begin))
        record = np.arange(first, past)
        if past == n_records:
            ends, record = np.append(ends, n), np.append(record, -2)
        more = np.maximum(np.diff(ends, prepend=begin) - 1, 0) // _LIST_MAX  # rows without a record, before each
        lists = np.full(len(ends) + int(more.sum()), _LIST_MAX)
        own = np.cumsum(more + 1) - 1
        lists[own] = np.diff(ends, prepend=begin) - more * _LIST_MAX
        rows = np.full(len(lists), -1)
        rows[own] = record
        ends = begin + np.cumsum(lists)
        for group in np.split(np.arange(len(rows)), np.flatnonzero(np.diff((ends - begin) // _GROUP_OWNERS)) + 1):
            yield rows[group], ends[group], int(ends[group[0]] - lists[group[0]])
        begin = int(ends[-1])
        if past == n_records:
            return


def _tables(arrow: Any, schema: Any, log: LogColumns) -> Iterator[Any]:
    """Row groups: the verdicts, then records and owners."""
    for begin in range(0, len(log.verdicts), _RECORDS):
        yield _verdict_table(arrow, schema, log.verdicts[begin : begin + _RECORDS])
    for record, ends, begin in _groups(log):
        yield _table(arrow, schema, log, record, ends, begin)


def _verdict_table(arrow: Any, schema: Any, verdicts: NDArray[np.void]) -> Any:
    count = len(verdicts)
    columns = {
        "kind": arrow.array([_VERDICT]).take(arrow.array(np.zeros(count, np.int8))),
        _OWNERS: arrow.array([[]], schema.field(_OWNERS).type).take(arrow.array(np.zeros(count, np.int8))),
        **{name: arrow.array(np.ascontiguousarray(verdicts[name])) for name in VERDICT.names or ()},
    }
    return arrow.Table.from_arrays(
        [columns[field.name] if field.name in columns else arrow.nulls(count, field.type) for field in schema], schema=schema
    )


def _schema(arrow: Any, *, classified: bool) -> Any:
    fields = [(name, arrow.string() if name == "kind" else arrow.from_numpy_dtype(TRACK[name])) for name in TRACK.names or ()]
    more = [(name, arrow.from_numpy_dtype(VERDICT[name])) for name in _OF_VERDICT if classified]
    return arrow.schema([*fields, (_OWNERS, arrow.large_list(arrow.int16())), *more])


def _table(arrow: Any, schema: Any, log: LogColumns, record: NDArray[np.int64], ends: NDArray[np.int64], begin: int) -> Any:
    there = record >= 0
    which = record[there]
    own = np.zeros(len(record), TRACK)
    if len(which):
        own[there] = log.records[int(which[0]) : int(which[-1]) + 1]
    names = [kind.name for kind in Kind] + [_END, _NONE]
    kinds = np.where(there, own["kind"], np.where(record == -2, names.index(_END), names.index(_NONE))).astype(np.int8)
    columns = []
    for name in TRACK.names or ():
        if name == "kind":
            columns.append(arrow.DictionaryArray.from_arrays(arrow.array(kinds), arrow.array(names)).cast(arrow.string()))
        else:
            columns.append(arrow.array(np.ascontiguousarray(own[name]), mask=~there))
    offsets = np.append(0, ends - begin).astype(np.int64)
    owner = np.ascontiguousarray(log.owner[begin : int(ends[-1])], np.int16)
    columns.append(arrow.LargeListArray.from_arrays(arrow.array(offsets), arrow.array(owner)))
    columns += [arrow.nulls(len(record), field.type) for field in list(schema)[len(columns) :]]
    return arrow.Table.from_arrays(columns, schema=schema)


class LogFile:
    """A log that `write_log` wrote, read a row group at a time.

    Attributes:
        path, engine, recording, class_names: the file, of several the first; as of `TrackLog`.

    Raises:
        TrackLogError: the file is missing, damaged, or not a TrackLog; or pyarrow is not installed.
    """

    def __init__(self, path: Path | str) -> None:
        self._arrow = _arrow(path)
        self.path = Path(path)
        with self._opened(self.path) as file:
            schema = file.schema_arrow
        lacking = [name for name in _COLUMNS if name not in schema.names]
        if lacking:
            rule = "must be a log as `evcot track -o LOG.parquet` writes it"
            raise TrackLogError(f"{path}: lacks {', '.join(lacking)}: {rule}")
        self.engine, self.recording = _about(schema)
        names = (schema.metadata or {}).get(b"class_names", b"{}").decode(errors="replace")
        self.class_names: ClassNames = class_names_from(names, self.path)
        self._classified = set(_OF_VERDICT) <= set(schema.names)

    def blocks(self, *, owners: bool = True) -> Iterator[tuple[NDArray[np.void], NDArray[np.int16]]]:
        """The log in runs: (m,) records of dtype `TRACK` and (n,) owners; those of a record's event are in its run or before.

        Args:
            owners: False leaves them out, and takes less time.

        Raises:
            TrackLogError: the file is damaged, or not a TrackLog.
        """
        for number in count():
            path = _file_of(self.path, number)
            if number and not path.exists():
                raise TrackLogError(f"{self.path}: the last row is no {_END}, and there is no {path.name}: must be a whole log")
            whole = yield from self._blocks_of(path, owners=owners)
            if whole:
                return

    def _blocks_of(self, path: Path, *, owners: bool) -> Generator[tuple[NDArray[np.void], NDArray[np.int16]], None, bool]:
        """The runs of one file; returns whether its last row is END."""
        row, whole = 0, False
        columns = list(_COLUMNS if owners else _COLUMNS[:-1])
        with self._opened(path) as file:
            if (about := _about(file.schema_arrow)) != (self.engine, self.recording):
                raise TrackLogError(f"{path}: is of engine, recording {about}: must go on with {self.path.name}")
            for group in range(file.num_row_groups):
                with self._in_one_line(path):
                    table = file.read_row_group(group, columns=columns)
                if whole:
                    raise TrackLogError(f"{path}: row {row - 1}: kind = {_END!r}: must be the last row's")
                kinds = self._kinds(path, table.column("kind"), row)
                row += len(kinds)
                whole = bool(len(kinds)) and kinds[-1] == -2
                yield self._records(path, table, kinds), self._owners(path, table) if owners else np.empty(0, np.int16)
        return whole

    def record_runs(self) -> Iterator[NDArray[np.void]]:
        """All records, run by run; every call gives them again. Errors as of `blocks`."""
        for records, _ in self.blocks(owners=False):
            yield records

    @property
    def verdicts(self) -> NDArray[np.void]:
        """See `TrackLog`; errors as of `blocks`."""
        return np.concatenate([no_verdicts(), *(self._verdict_runs() if self._classified else ())])

    def _verdict_runs(self) -> Iterator[NDArray[np.void]]:
        for number in count():
            path = _file_of(self.path, number)
            with self._opened(path) as file:
                for group in range(file.num_row_groups):
                    with self._in_one_line(path):
                        table = file.read_row_group(group, columns=["kind", *(VERDICT.names or ())])
                    if not table.num_rows or table.column("kind")[0].as_py() != _VERDICT:
                        return
                    verdicts = np.empty(table.num_rows, VERDICT)
                    for name in VERDICT.names or ():
                        verdicts[name] = _values(path, table.column(name), name, VERDICT[name])
                    yield verdicts

    def count_owners(self) -> int:
        """Number of owners, one for each event; errors as of `blocks`."""
        return sum(len(owner) for _, owner in self.blocks())

    def read(self, *, owners: bool = True) -> tuple[NDArray[np.void], NDArray[np.int16]]:
        """All records and owners, in memory; arguments and errors as of `blocks`."""
        records, decided = [np.empty(0, TRACK)], [np.empty(0, np.int16)]
        for some, own in self.blocks(owners=owners):
            records.append(some)
            decided.append(own)
        return np.concatenate(records), np.concatenate(decided)

    def _records(self, path: Path, table: Any, kinds: NDArray[np.int64]) -> NDArray[np.void]:
        there = kinds >= 0
        records = np.zeros(int(np.count_nonzero(there)), TRACK)
        records["kind"] = kinds[there]
        if not there.all():
            table = table.filter(self._arrow.array(there))
        for name in TRACK.names or ():
            if name != "kind":
                records[name] = _values(path, table.column(name), name, TRACK[name])
        return records

    def _owners(self, path: Path, table: Any) -> NDArray[np.int16]:
        column = table.column(_OWNERS)
        if not (self._arrow.types.is_large_list(column.type) or self._arrow.types.is_list(column.type)):
            raise TrackLogError(f"{path}: {_OWNERS} is {column.type}: must be a list of int16")
        flat = column.combine_chunks().flatten()
        return np.asarray(_values(path, flat, _OWNERS, np.dtype(np.int16)), np.int16)

    def _kinds(self, path: Path, column: Any, first: int) -> NDArray[np.int64]:
        """Kinds by number, -1 for NONE, -3 for VERDICT and -2, only at the end, for END."""
        codes = {kind.name: int(kind) for kind in Kind} | {_NONE: -1, _END: -2, _VERDICT: -3}
        rule = f"must be one of {', '.join(kind.name for kind in Kind)}, {_NONE}, {_VERDICT}, and of the last row {_END}"
        encoded = column.combine_chunks().dictionary_encode()
        for name in encoded.dictionary.to_pylist():
            if name not in codes or encoded.null_count:
                row = next(i for i, kind in enumerate(column.to_pylist()) if kind not in codes)
                raise TrackLogError(f"{path}: row {first + row}: kind = {column[row].as_py()!r}: {rule}")
        by_code = np.array([codes[name] for name in encoded.dictionary.to_pylist()], np.int64)
        kinds = by_code[encoded.indices.to_numpy(zero_copy_only=False)] if len(by_code) else np.empty(0, np.int64)
        if (kinds[:-1] == -2).any():
            raise TrackLogError(f"{path}: row {first + int(np.argmax(kinds == -2))}: kind = {_END!r}: {rule}")
        return kinds

    @contextmanager
    def _opened(self, path: Path) -> Iterator[Any]:
        note_input(path)
        with self._in_one_line(path):
            source = path.open("rb")
        with source:
            with self._in_one_line(path):
                file = self._arrow.parquet.ParquetFile(source, page_checksum_verification=True)
            yield file

    def _in_one_line(self, path: Path) -> _OneLine:
        return _OneLine(path, self._arrow.ArrowException)


def _about(schema: Any) -> tuple[str, str]:
    """Engine and recording of a file."""
    about = schema.metadata or {}
    return about.get(b"engine", b"").decode(errors="replace"), about.get(b"recording", b"").decode(errors="replace")


class _OneLine:
    """A context in which errors of Arrow become those of a log."""

    def __init__(self, path: Path, of_arrow: type[Exception]) -> None:
        self._path = path
        self._kinds = (of_arrow, ValueError, OSError)

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, self._kinds) and not isinstance(error, TrackLogError):
            if isinstance(error, OSError) and error.strerror:
                raise TrackLogError(f"{self._path}: cannot be read: {error.strerror}") from error
            what = " ".join(str(error).split())[:120]
            raise TrackLogError(f"{self._path}: is damaged, or no Parquet file: {what}") from error


def _arrow(path: Path | str) -> Any:
    if "pyarrow" not in sys.modules:  # its own allocator keeps a hundred megabytes that it does not use
        os.environ.setdefault("ARROW_DEFAULT_MEMORY_POOL", "system")
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise TrackLogError(f"{path}: {_NEEDED}") from error
    return pyarrow


def _values(path: Path | str, column: Any, name: str, dtype: np.dtype[Any]) -> NDArray[Any]:
    if column.null_count or str(column.type) != {"float64": "double"}.get(dtype.name, dtype.name):
        what = "has no value in some rows" if column.null_count else f"is {column.type}"
        raise TrackLogError(f"{path}: {name} {what}: must be {dtype}")
    return np.asarray(column.to_numpy(), dtype)
