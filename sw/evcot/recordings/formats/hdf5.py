# SPDX-License-Identifier: Apache-2.0
"""HDF5 event files: DSEC, Prophesee, M3ED, MVSEC, and the flat columns of E2VID's packagers.

Integer times are microseconds. Floating-point times are seconds, rounded to the nearest microsecond; or microseconds if those
of the first block are all whole.
https://dsec.ifi.uzh.ch/data-format, https://docs.prophesee.ai/stable/data/file_formats/hdf5.html, https://m3ed.io/data_overview
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import RecordingError
from ...events import Events
from . import ecf
from .blocks import in_order
from .hdf5_chunks import Chunks, joined
from .hdf5_survey import Part, Survey, survey
from .numeric import UNITS, events_from_numbers, events_from_records, microseconds, whole_numbers
from .printable import printable, reason
from .source import BLOCK_EVENTS, AnySensor, Format, Sensor

__all__ = ["FORMATS", "MAGIC", "Hdf5File", "Rows", "open_dataset", "open_file", "open_rows"]

MAGIC = b"\x89HDF\r\n\x1a\n"
_READ_ROWS = 1 << 17  # minimum rows per read: a call of the library has a high fixed cost


class Rows:
    """A dataset's rows, read in consecutive slices: every chunk is read and decompressed only once."""

    def __init__(self, dataset: Any, chunk_rows: int, axis: int = 0, line: int = 0) -> None:
        self._dataset, self._chunks = dataset, Chunks(dataset, axis, line)
        self._step = chunk_rows * -(-_READ_ROWS // chunk_rows)
        self._begin = self._end = 0
        self._held: NDArray[Any] = np.empty(0)

    def __len__(self) -> int:
        return len(self._chunks)

    @property
    def dtype(self) -> np.dtype[Any]:
        """The type of a row."""
        dtype: np.dtype[Any] = self._dataset.dtype
        return dtype

    def __getitem__(self, window: slice) -> NDArray[Any]:
        """The rows from window.start (inclusive) to window.stop (exclusive).

        Raises:
            RecordingError: they cannot be read.
        """
        begin, end = window.start, window.stop
        if end > self._end or begin < self._begin:
            kept = self._held[begin - self._begin :] if self._begin <= begin < self._end else None
            at = begin if kept is None else self._end
            stop = min(-(-end // self._step) * self._step, len(self._chunks))
            rows = self._read(at, stop)
            self._held = rows if kept is None else joined([kept, rows])
            self._begin, self._end = begin, stop
        return self._held[begin - self._begin : end - self._begin]

    def at(self, row: int) -> NDArray[Any]:
        """One row, as an array of length 1; does not change the buffer of the slices."""
        return self._read(row, row + 1)

    def _read(self, begin: int, end: int) -> NDArray[Any]:
        try:
            rows = self._chunks.read(begin, end)
        except RecordingError as error:
            raise RecordingError(f"{self._dataset.name}: values {begin} to {end - 1}: {error}") from error
        except (OSError, RuntimeError, ValueError, MemoryError) as error:
            raise RecordingError(
                f"{self._dataset.name}: values {begin} to {end - 1} cannot be read: {reason(error)}"
            ) from error
        if len(rows) != end - begin:
            raise RecordingError(f"{self._dataset.name}: {len(rows)} values from {begin} on: must be {end - begin}")
        return rows


class Hdf5File(AnySensor):
    """An HDF5 file of events as a `source.Source`."""

    def __init__(self, path: Path) -> None:
        found = survey(path)
        self._file = open_file(path)
        try:
            held = {part["dataset"]: open_rows(self._file, part) for part in found["columns"].values()}
        except BaseException:
            self._file.close()
            raise
        self._columns = {field: (held[part["dataset"]], part["pick"]) for field, part in found["columns"].items()}
        rows, _ = self._columns["t"]
        self._records = rows if all(self._columns[field] == (rows, field) for field in "txyp") else None
        self._count: int = found["count"]
        self._t_offset: int = found["t_offset"]
        self._index = open_rows(self._file, found["index"]) if found["index"] else None
        self.sensor: Sensor | None = _sensor(found)
        self.details: dict[str, str] = found["details"]
        self._has_whole_floats = False
        try:
            self._judge_floats()
        except BaseException:
            self._file.close()
            raise
        self.left_out: Counter[str] = Counter()
        self.remarks: list[str] = []

    def blocks(self, from_us: int | None = None) -> Iterator[Events]:
        """See `source.Source`."""
        first = 0 if from_us is None else self._place_of(from_us - self._t_offset)
        pieces = range(first, self._count, _READ_ROWS)
        # Columns need little work here while the library reads the next; records are best decoded on the core that read them.
        read = map(self._read, pieces) if self._records else in_order(self._read, pieces, workers=1)
        for piece, columns in zip(pieces, read, strict=True):
            for begin in range(0, len(columns[0]), BLOCK_EVENTS):
                yield self._events([column[begin : begin + BLOCK_EVENTS] for column in columns], piece + begin)

    def _judge_floats(self) -> None:
        """Decide the unit of floating-point times by the first block."""
        rows, pick = self._columns["t"]
        dtype = rows.dtype[pick] if isinstance(pick, str) else rows.dtype
        if dtype.kind != "f" or not self._count:
            return
        first = _pick(rows[slice(0, min(_READ_ROWS, self._count))], pick)[:BLOCK_EVENTS]
        self._has_whole_floats = bool(((first == np.rint(first)) & (np.abs(first) < 1 << 53)).all())
        self.details["times in"] = UNITS[0 if self._has_whole_floats else 6]

    def _times(self, t: NDArray[Any], first_index: int) -> NDArray[Any]:
        return whole_numbers("t", t, np.int64, first_index) if self._has_whole_floats else t

    def _read(self, begin: int) -> list[NDArray[Any]]:
        """The next values of the columns t, x, y, p; or of the one column of records."""
        window = slice(begin, min(begin + _READ_ROWS, self._count))
        if self._records:
            return [self._records[window]]
        return [_pick(rows[window], pick) for rows, pick in (self._columns[field] for field in "txyp")]

    def _events(self, columns: list[NDArray[Any]], first_index: int) -> Events:
        if len(columns) == 1:
            (records,) = columns
            columns = [records[field] for field in "txyp"]
            events = events_from_records(records, self._t_offset)
            if events is not None:
                return events
        t, x, y, p = columns
        return events_from_numbers(self._times(t, first_index), x, y, p, first_index, self._t_offset)

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _time_at(self, i: int) -> int:
        rows, pick = self._columns["t"]
        return int(microseconds(self._times(_pick(rows.at(i), pick), i), i)[0])

    def _place_of(self, t_us: int) -> int:
        """An index before which all events are earlier than `t_us`, a time without the file's offset."""
        indexed = self._indexed(t_us)
        if indexed is not None:
            return indexed
        low, high = 0, self._count
        while low < high:
            middle = (low + high) // 2
            if self._time_at(middle) < t_us:
                low = middle + 1
            else:
                high = middle
        return low

    def _indexed(self, t_us: int) -> int | None:
        """The same by the file's index of milliseconds; None where the index has no entry, or a wrong one."""
        ms = t_us // 1000
        if self._index is None or not 0 <= ms < len(self._index):
            return None
        try:
            place = int(self._index.at(ms)[0])
        except (OSError, RuntimeError, ValueError, TypeError):
            return None
        if not 0 <= place <= self._count:
            return None
        is_early = place == 0 or self._time_at(place - 1) < ms * 1000
        is_late = place == self._count or self._time_at(place) >= ms * 1000
        return place if is_early and is_late else None


def _pick(rows: NDArray[Any], pick: str | int | None) -> NDArray[Any]:
    if pick is None:
        return rows
    picked: NDArray[Any] = rows[pick] if isinstance(pick, str) else rows[:, pick]
    return picked


def _sensor(found: Survey) -> Sensor | None:
    return tuple(found["sensor"]) if found["sensor"] else None


def open_file(path: Path) -> Any:
    """Open an HDF5 file for reading.

    Raises:
        RecordingError: the library cannot open it.
    """
    import h5py

    try:
        return h5py.File(path, "r")
    except (OSError, RuntimeError) as error:
        raise RecordingError(f"cannot be opened as HDF5: {reason(error)}") from error


def open_dataset(file: Any, part: Part) -> Any:
    """Open the dataset of a part of a survey.

    Raises:
        RecordingError: it cannot be opened, or its compression needs a package that is not installed.
    """
    try:
        dataset = file[part["dataset"]]
    except (KeyError, OSError, RuntimeError, ValueError) as error:
        raise RecordingError(f"{part['dataset']}: cannot be opened: {reason(error)}") from error
    if not Chunks(dataset).is_ecf:
        for code, name in part["filters"]:
            _check_filter(part["dataset"], code, name)
    return dataset


def open_rows(file: Any, part: Part) -> Rows:
    """The rows of a part of a survey; raises as `open_dataset` does."""
    return Rows(open_dataset(file, part), part["chunk"], part["axis"], part["line"])


def _check_filter(dataset: str, code: int, name: str) -> None:
    from h5py import h5z

    if h5z.filter_avail(code):
        return
    if code == ecf.FILTER:
        need = "Prophesee's plugin hdf5_ecf in $HDF5_PLUGIN_PATH, or the recording as RAW"
    else:
        try:
            import hdf5plugin  # noqa: F401  (registers its filters with the library)
        except ImportError:
            need = "pip install 'evcot[hdf5]'"
        else:
            if h5z.filter_avail(code):
                return
            need = "its plugin in $HDF5_PLUGIN_PATH"
    called = {ecf.FILTER: "ECF", 32001: "Blosc"}.get(code, printable(name.split(";")[0]) or "unnamed")
    raise RecordingError(f"{dataset}: is compressed by {called} (HDF5 filter {code}): needs {need}")


def _is_hdf5(start: bytes, _: Path) -> bool:
    return start.startswith(MAGIC) or start[512:].startswith(MAGIC)


FORMATS = (Format("hdf5", "HDF5", _is_hdf5, Hdf5File),)
