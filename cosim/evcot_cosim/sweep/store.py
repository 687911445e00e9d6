# SPDX-License-Identifier: Apache-2.0
"""The store of a sweep: a Parquet dataset, one row a run, and a journal of the rows that are not in it yet.

A row is in the journal as soon as its run has ended; every few seconds the journal's rows become a file of the dataset. So a
killed sweep loses no row, and a reader of the dataset sees whole files alone. Only one sweep writes to a store at a time.

The index names the files of the dataset. A name is in the index before its file is written and until its file is deleted, so
no file that the index does not name is read, merged or deleted.
"""

from __future__ import annotations

import fcntl
import json
import os
import re
import time
import warnings
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

from evcot.errors import ConfigError, OutputError, RecordingWarning, reason_of
from evcot.outputs import written_aside

from .metrics import METRICS, TIMES

__all__ = ["COLUMNS", "RUNS", "Store", "read_rows", "require_pyarrow"]

RUNS = "runs"  # the folder of the dataset
_JOURNAL, _INDEX = "journal.jsonl", "runs.json"
_FILE = re.compile(r"runs-[0-9]{6}\.parquet")  # of the dataset
_KEY = re.compile(r"[0-9a-f]{16}")
_PARTIAL = ".partial"
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
        OutputError: it cannot be written, or something in the way is not of a store.
    """

    def __init__(self, folder: Path) -> None:
        self._arrow = require_pyarrow()
        self.folder = folder
        self._runs = folder / RUNS
        self._new: list[dict[str, Any]] = []
        self._flushed = time.monotonic()
        try:
            if not (folder / _INDEX).exists():
                for name in (RUNS, _JOURNAL):
                    if os.path.lexists(folder / name):
                        raise OutputError(f"{folder / name}: exists, and no sweep made it: must be moved away")
                self._list([])
            self._runs.mkdir(exist_ok=True)
            self._journal = (folder / _JOURNAL).open("a+b", buffering=0)
        except OSError as error:
            raise OutputError(f"{folder}: cannot be written: {reason_of(error, folder)}") from error
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
        for path in _files(self.folder):
            _aside(path).unlink(missing_ok=True)  # of a sweep that was killed
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
            journal = self.folder / _JOURNAL
            raise OutputError(f"{journal}: cannot be written: {reason_of(error, journal)}") from error
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
        """Take over the journal of a sweep that was killed, without a last line that is cut off, and without damaged lines."""
        self._journal.seek(0)
        for number, line in enumerate(self._journal.read().splitlines(keepends=True), 1):
            if not line.endswith(b"\n"):
                break
            if (row := _row(line)) is None:
                rule = "is damaged and left out; its run is done again"
                warnings.warn(RecordingWarning(f"{self.folder / _JOURNAL}: line {number} {rule}"), stacklevel=2)
                continue
            self.status[row["key"]] = row["status"]
            self._new.append(row)
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
        files = _files(self.folder)
        taken = {path.name for path in files} | {name.strip(".").removesuffix(_PARTIAL) for name in os.listdir(self._runs)}
        last = max((int(name[5:11]) for name in taken if _FILE.fullmatch(name)), default=0)
        path = self._runs / f"runs-{last + 1:06d}.parquet"
        aside = _aside(path)
        try:
            self._list([*files, path])
            with aside.open("xb") as file:
                self._arrow.parquet.write_table(table, file, compression="zstd")
            with aside.open("rb") as file:
                os.fsync(file.fileno())
            os.link(aside, path)  # never in place of another
        except OSError as error:
            raise OutputError(f"{path}: cannot be written: {reason_of(error, path)}") from error
        finally:
            aside.unlink(missing_ok=True)
        return path

    def _put_together(self) -> None:
        """Make one file of many small ones."""
        parquet = self._arrow.parquet
        there = [path for path in _files(self.folder) if path.is_file()]
        small = [path for path in there if parquet.read_metadata(path).num_rows < _SMALL_ROWS]
        if len(small) > 1:
            table = self._arrow.concat_tables([parquet.read_table(path) for path in small], promote_options="permissive")
            last = {key: i for i, key in enumerate(table.column("key").to_pylist())}
            self._write(table.take(sorted(last.values())))
            for path in small:
                path.unlink()
            self._list([path for path in _files(self.folder) if path not in small])

    def _list(self, files: Iterable[Path]) -> None:
        """Write the index."""
        with written_aside(self.folder / _INDEX, force=True) as file:
            file.write((json.dumps({"evcot": "files of runs/", "files": [path.name for path in files]}) + "\n").encode())


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
    for path in _files(folder):
        if not path.is_file():  # named in the index, and not written any more when the sweep was killed
            continue
        try:
            table = arrow.parquet.read_table(path, columns=wanted)
        except (OSError, arrow.ArrowException) as error:
            raise ConfigError(f"{path}: cannot be read: {' '.join(str(error).split())[:120]}") from error
        for row in table.to_pylist():
            if not _KEY.fullmatch(str(row["key"])):  # pages of runs are named by it
                raise ConfigError(f"{path}: key = {row['key']!r}: must have 16 hexadecimal digits")
            rows[row["key"]] = row
    return list(rows.values())


def _files(folder: Path) -> list[Path]:
    """The files of the dataset of a sweep's folder, by its index; a name of another form is refused.

    Raises:
        ConfigError: the index is not one.
    """
    index = folder / _INDEX
    try:
        names = json.loads(index.read_bytes())["files"]
    except FileNotFoundError:
        return []
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise ConfigError(f"{index}: cannot be read: must be the index that `evcot sweep` writes") from error
    for name in names if isinstance(names, list) else [names]:
        if not isinstance(name, str) or not _FILE.fullmatch(name):
            raise ConfigError(f"{index}: files: {str(name)[:80]!r}: must be a name such as runs-000001.parquet")
    return [folder / RUNS / name for name in sorted(names)]


def _aside(path: Path) -> Path:
    """The file from which a file of the dataset is made."""
    return path.with_name(f".{path.name}{_PARTIAL}")


def _row(line: bytes) -> dict[str, Any] | None:
    """A line of the journal, None if it is damaged."""
    try:
        row = json.loads(line)
        good = _KEY.fullmatch(row["key"]) and isinstance(row["status"], str) and isinstance(row["settings"], dict)
        return row if good else None
    except (ValueError, KeyError, TypeError, RecursionError):
        return None


def _column_of_field(arrow: Any, values: list[Any]) -> Any:
    """Whole numbers, numbers, truth values or text; what is none of these as JSON."""
    kinds = {type(value) for value in values if value is not None}
    if kinds <= {int, float} and float in kinds:
        return arrow.array([None if value is None else float(value) for value in values], arrow.float64())
    if kinds in ({int}, {bool}, {str}):
        return arrow.array(values)
    return arrow.array([None if value is None else json.dumps(value) for value in values], arrow.string())
