# SPDX-License-Identifier: Apache-2.0
"""The store of a sweep: a Parquet dataset, one row a run, and a journal of the rows that are not in it yet.

A row is in the journal as soon as its run has ended; every few seconds the journal's rows become a file of the dataset. So a
killed sweep loses no row, and a reader of the dataset sees whole files alone. Only one sweep writes to a store at a time.
"""

from __future__ import annotations

import fcntl
import json
import os
import time
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

from evcot.errors import ConfigError, OutputError

from .metrics import METRICS, TIMES

__all__ = ["COLUMNS", "RUNS", "Store", "read_rows", "require_pyarrow"]

RUNS = "runs"  # the folder of the dataset
_JOURNAL = "journal.jsonl"
_FLUSH_ROWS = 5_000
_FLUSH_S = 5.0
_SMALL_ROWS = 50_000  # files below this are put together at the end

COLUMNS: dict[str, str] = {
    "key": "string", "status": "string", "engine": "string", "hardware": "string", "preset": "string",
    "input": "string", "family": "string", "content": "string", "scene_seed": "int64", "seed": "int64",
    "from_us": "int64", "to_us": "int64",
    **METRICS, **TIMES,
    "error": "string", "warnings": "string", "attempts": "int64", "when": "string", "host": "string",
    "versions": "string", "code": "string", "design": "string", "command": "string", "task": "string",
}  # fmt: skip
"""Column -> type; each field that the sweep sets has a column of its name after these."""


def require_pyarrow() -> Any:
    """The modules of pyarrow; ConfigError where it is not installed."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise ConfigError("pyarrow is not installed: must be, for Parquet: pip install 'evcot[sweep]'") from error
    return pyarrow


class Store:
    """The store in a folder, open for writing.

    Args:
        folder: of the sweep; it exists.

    Attributes:
        status: key -> status of every run that is in the store.

    Raises:
        ConfigError: another process writes to it, or pyarrow is missing.
        OutputError: it cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        self._arrow = require_pyarrow()
        self.folder = folder
        self._runs = folder / RUNS
        self._new: list[dict[str, Any]] = []
        self._flushed = time.monotonic()
        try:
            self._runs.mkdir(exist_ok=True)
            self._journal = (folder / _JOURNAL).open("a+b", buffering=0)
        except OSError as error:
            raise OutputError(f"{folder}: cannot be written: {error.strerror or error}") from error
        try:
            self._begin()
        except BaseException:
            self._journal.close()
            raise

    def _begin(self) -> None:
        """Keep others out, and take over what a sweep that was killed has left."""
        try:
            fcntl.flock(self._journal, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise ConfigError(f"{self.folder}: another sweep writes here: must have ended") from error
        for left in self._runs.glob(".*.partial"):
            left.unlink()
        self.status: dict[str, str] = {row["key"]: row["status"] for row in self._rows(("key", "status"))}
        self._recover()

    def __enter__(self) -> Store:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        try:
            if kind is None:
                self.flush()
                self._put_together()
        finally:
            self._journal.close()

    def add(self, row: Mapping[str, Any]) -> None:
        """Append a row. Of a run that is in the store already the later row counts.

        Raises:
            OutputError: it cannot be written; what was written before stays.
        """
        line = (json.dumps(row, allow_nan=False) + "\n").encode()
        at = os.fstat(self._journal.fileno()).st_size
        try:
            written = 0
            while written < len(line):
                written += self._journal.write(line[written:]) or 0
        except OSError as error:
            self._journal.truncate(at)  # no half line
            raise OutputError(f"{self.folder / _JOURNAL}: cannot be written: {error.strerror or error}") from error
        self.status[row["key"]] = row["status"]
        self._new.append(dict(row))
        if len(self._new) >= _FLUSH_ROWS or time.monotonic() - self._flushed > _FLUSH_S:
            self.flush()

    def flush(self) -> None:
        """Make the journal's rows a file of the dataset."""
        self._flushed = time.monotonic()
        if self._new:
            self._write(self._table(self._new))
            self._journal.truncate(0)
            self._new = []

    def read(self, columns: Iterable[str] | None = None) -> list[dict[str, Any]]:
        """All rows, each run once, as they are in the dataset; see `read_rows`."""
        self.flush()
        return list(self._rows(columns))

    def _rows(self, columns: Iterable[str] | None = None) -> Iterator[dict[str, Any]]:
        return iter(read_rows(self.folder, columns))

    def _recover(self) -> None:
        """Take over the journal of a sweep that was killed; a last line that is cut off is left out."""
        self._journal.seek(0)
        whole = 0
        for line in self._journal.read().splitlines(keepends=True):
            if not line.endswith(b"\n"):
                break
            row = json.loads(line)
            self.status[row["key"]] = row["status"]
            self._new.append(row)
            whole += len(line)
        self._journal.truncate(whole)
        if self._new:
            self.flush()
        else:
            self._journal.truncate(0)

    def _table(self, rows: list[dict[str, Any]]) -> Any:
        """Rows as an Arrow table: the columns of all sweeps, then those of this one's fields."""
        arrow = self._arrow
        of_kind = {"int64": arrow.int64(), "double": arrow.float64(), "string": arrow.string()}
        names = sorted({name for row in rows for name in row["settings"]})
        columns = {name: arrow.array([row.get(name) for row in rows], of_kind[kind]) for name, kind in COLUMNS.items()}
        for name in names:
            columns[name] = _column_of_field(arrow, [row["settings"].get(name) for row in rows])
        return arrow.table(columns)

    def _write(self, table: Any) -> Path:
        taken = [int(path.stem.rpartition("-")[2]) for path in self._runs.glob("runs-*.parquet")]
        path = self._runs / f"runs-{max(taken, default=0) + 1:06d}.parquet"
        aside = self._runs / f".{path.name}.partial"
        try:
            self._arrow.parquet.write_table(table, aside, compression="zstd")
            with aside.open("rb") as file:
                os.fsync(file.fileno())
            os.link(aside, path)  # never in place of another
        except OSError as error:
            raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from error
        finally:
            aside.unlink(missing_ok=True)
        return path

    def _put_together(self) -> None:
        """Make one file of many small ones."""
        parquet = self._arrow.parquet
        small = [path for path in _files(self._runs) if parquet.read_metadata(path).num_rows < _SMALL_ROWS]
        if len(small) > 1:
            table = self._arrow.concat_tables([parquet.read_table(path) for path in small], promote_options="permissive")
            last = {key: i for i, key in enumerate(table.column("key").to_pylist())}
            self._write(table.take(sorted(last.values())))
            for path in small:
                path.unlink()


def read_rows(folder: Path, columns: Iterable[str] | None = None) -> list[dict[str, Any]]:
    """The rows of a store in the order of their files, each run once.

    Args:
        folder: of the sweep.
        columns: which; None: all.

    Raises:
        ConfigError: a file that is no Parquet, or pyarrow is missing.
    """
    arrow = require_pyarrow()
    wanted = None if columns is None else ["key", *(name for name in columns if name != "key")]
    rows: dict[str, dict[str, Any]] = {}
    for path in _files(folder / RUNS):
        try:
            table = arrow.parquet.read_table(path, columns=wanted)
        except (OSError, arrow.ArrowException) as error:
            raise ConfigError(f"{path}: cannot be read: {' '.join(str(error).split())[:120]}") from error
        for row in table.to_pylist():
            rows[row["key"]] = row
    return list(rows.values())


def _files(folder: Path) -> list[Path]:
    return sorted(folder.glob("runs-*.parquet"))


def _column_of_field(arrow: Any, values: list[Any]) -> Any:
    """Whole numbers, numbers, truth values or text; what is none of these as JSON."""
    kinds = {type(value) for value in values if value is not None}
    if kinds <= {int, float} and float in kinds:
        return arrow.array([None if value is None else float(value) for value in values], arrow.float64())
    if kinds in ({int}, {bool}, {str}):
        return arrow.array(values)
    return arrow.array([None if value is None else json.dumps(value) for value in values], arrow.string())
