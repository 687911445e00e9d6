# SPDX-License-Identifier: Apache-2.0
"""NumPy files: .npz with an array per field, and .npy of records or of rows t, x, y, p, or in another order (`column_order`).

Fields may have any of the names in `fields`. Times are in the unit stated in their name (`t_us`, `t_s`); else integers are
microseconds, and floating-point numbers are seconds, or microseconds if those of the first block are all whole. They are
rounded to the nearest microsecond. Polarity is 1 or true where the pixel became brighter, 0, -1 or false where darker.

evcot writes .npz: arrays t_us, x, y, p, width, height, not compressed, readable with `numpy.load`. The format stores field by
field what arrives block by block, so blocks are spooled to an unnamed file on the same disk.
"""

from __future__ import annotations

import tempfile
import weakref
import zipfile
from bisect import bisect_left
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ...errors import RecordingError
from ...events import Events
from .numeric import SAMPLED_ROWS, UNITS, column_order, find_fields, microseconds, order_text, polarities, whole_numbers
from .numpy_arrays import StoredArray, npy_array, npz_arrays
from .source import BLOCK_EVENTS, AnySensor, Format, Sensor, WritableFormat

__all__ = ["FORMATS", "WRITABLE"]

_LATEST_US = 1 << 62
_EVIMO = "events"  # the array of EVIMO and of EVIMO2 in its first version: rows t, x, y, p, among depth, masks and objects
_EVIMO_2 = ("events_t", "events_xy", "events_p")


@dataclass(frozen=True)
class _Column:
    """A field of an event: a whole array, or a field of its records."""

    array: StoredArray
    field: str | None = None
    lowest_bit: bool = False

    @property
    def type(self) -> np.dtype[Any]:
        return self.array.dtype if self.field is None else self.array.dtype[self.field]

    def of(self, rows: NDArray[Any]) -> NDArray[Any]:
        values = rows if self.field is None else rows[self.field]
        return values & 1 if self.lowest_bit and values.dtype.kind in "iu" else values


class _NumpySource(AnySensor):
    """See `source.Source`.

    Args:
        columns: t, x, y, p.
        power: times are in units of 10**power us; None if not stated in a name.
    """

    def __init__(self, columns: Sequence[_Column], power: int | None, sensor: Sensor | None = None) -> None:
        self._columns = columns
        self._arrays = list({id(column.array): column.array for column in columns}.values())
        self._count = _common_count(columns)
        self._power = self._power_of_floats() if power is None and self._type_of_t.kind == "f" else power
        self.sensor = sensor
        self.details = {"times in": UNITS[self._power or 0]}
        self.left_out: Counter[str] = Counter()
        self.remarks: list[str] = []

    @property
    def _type_of_t(self) -> np.dtype[Any]:
        return self._columns[0].type

    def _power_of_floats(self) -> int | None:
        """The unit of floating-point times: seconds, or None for microseconds that are all whole numbers."""
        t = self._columns[0]
        with t.array.rows(0) as stream:
            first = t.of(t.array.read(stream, min(BLOCK_EVENTS, self._count)))
        return None if np.array_equal(first, np.rint(first)) else 6

    def blocks(self, from_us: int | None = None) -> Iterator[Events]:
        """See `source.Source`."""
        seekable = all(array.seekable for array in self._arrays)
        at = first = self._first_from(from_us) if from_us is not None and seekable else 0
        with ExitStack() as opened:
            streams = [opened.enter_context(array.rows(at)) for array in self._arrays]
            while at < self._count:
                wanted = min(BLOCK_EVENTS, self._count - at)
                parts = {id(array): array.read(stream, wanted) for array, stream in zip(self._arrays, streams, strict=True)}
                got = min(map(len, parts.values()))
                yield self._events([column.of(parts[id(column.array)][:got]) for column in self._columns], at)
                at += got
                if got < wanted:
                    raise RecordingError(f"ends after event {at - 1} of {self._count}; is it cut off?")
            if first == 0:
                for array, stream in zip(self._arrays, streams, strict=True):
                    array.check_end(stream)

    def _events(self, values: Sequence[NDArray[Any]], first_index: int) -> Events:
        t, x, y, p = values
        return Events(
            t_us=_microseconds(t, self._power, first_index),
            x=whole_numbers("x", x, np.uint16, first_index),
            y=whole_numbers("y", y, np.uint16, first_index),
            p=polarities(p, first_index),
        )

    def _first_from(self, from_us: int) -> int:
        """Index of the first event from a time on, by bisection."""
        t = self._columns[0]

        def time_of(i: int) -> int:
            with t.array.rows(i) as stream:
                found = t.of(t.array.read(stream, 1))
            # A truncated file is detected while reading, not here.
            return int(_microseconds(found, self._power, i)[0]) if len(found) else _LATEST_US

        return bisect_left(range(self._count), from_us, key=time_of)

    def close(self) -> None:
        """Do nothing: no file stays open between passes."""


def _microseconds(values: NDArray[Any], power: int | None, first_index: int) -> NDArray[np.int64]:
    """Convert times in units of 10**power us; for None, whole microseconds."""
    if values.dtype.kind == "f":
        if power == 6:
            return microseconds(values, first_index)
        scaled = values if power is None else np.rint(values * 10.0**power)
        return whole_numbers("t", scaled, np.int64, first_index)
    times = microseconds(values, first_index)
    if power is None or power == 0:
        return times
    if power < 0:
        unit = 10**-power
        return np.asarray((times + unit // 2) // unit)
    too_late = np.flatnonzero(np.abs(times) > _LATEST_US // 10**power)
    if len(too_late):
        i = int(too_late[0])
        raise RecordingError(f"event {first_index + i}: t = {times[i]}: must be below 2^62 us, in {UNITS[power]}")
    return np.asarray(times * 10**power)


def _common_count(columns: Sequence[_Column]) -> int:
    """The number of events; raises unless every column holds one number for each."""
    for name, column in zip("txyp", columns, strict=True):
        if len(column.array.shape) != 1 or column.type.kind not in "iubf":
            raise RecordingError(f"{name}: is {len(column.array.shape)}-D of {column.type}: must be a list of numbers")
    counts = [column.array.shape[0] for column in columns]
    if len(set(counts)) != 1:
        raise RecordingError(f"t, x, y, p hold {', '.join(map(str, counts))} values: all must be the same")
    return counts[0]


def _open_npy(path: Path) -> _NumpySource:
    return _of_one_array(npy_array(path))


def _of_one_array(array: StoredArray) -> _NumpySource:
    if array.dtype.names:
        naming = find_fields(array.dtype.names)
        return _NumpySource([_Column(array, array.dtype.names[i]) for i in naming.columns], naming.power)
    if len(array.shape) != 2 or array.shape[1] != 4:
        raise RecordingError(f"is an array {array.shape} of {array.dtype}: must be (n, 4), or have fields t, x, y, p")
    if array.fortran_order:
        columns = [_Column(each) for each in array.columns()]
    else:
        rows = array.rows_as_records()
        columns = [_Column(rows, name) for name in rows.dtype.names or ()]
    order = _order_of(columns) if array.dtype.kind in "iubf" else (0, 1, 2, 3)
    source = _NumpySource([columns[i] for i in order], None)
    assumed = f"{order_text(order)}, assumed by their values; an array with fields t, x, y, p names them"
    source.details["columns"] = assumed
    return source


def _order_of(columns: Sequence[_Column]) -> tuple[int, int, int, int]:
    """Which columns are t, x, y, p, by their first values."""
    values = [_first_values(column) for column in columns]
    shortest = min(map(len, values))
    return column_order(np.stack([each[:shortest] for each in values], axis=1))


def _first_values(column: _Column) -> NDArray[Any]:
    """The first numbers of a column; fewer than all columns have if the file ends there."""
    with column.array.rows(0) as stream:
        return column.of(column.array.read(stream, min(SAMPLED_ROWS, column.array.shape[0])))


def _open_npz(path: Path) -> _NumpySource:
    arrays = npz_arrays(path, beside=(_EVIMO, *_EVIMO_2))
    if not arrays:
        raise RecordingError("is a zip file without NumPy arrays")
    only = next(iter(arrays.values())) if len(arrays) == 1 else None
    if only is not None and (only.dtype.names or len(only.shape) == 2):
        return _of_one_array(only)
    if set(_EVIMO_2) <= arrays.keys() and len(arrays["events_xy"].shape) == 2:
        return _open_evimo_2(arrays)
    if _EVIMO in arrays and arrays[_EVIMO].shape[1:] == (4,):
        return _of_one_array(arrays[_EVIMO])
    names = list(arrays)
    try:
        naming = find_fields(names)
    except RecordingError as error:
        raise RecordingError(f"has arrays {', '.join(map(repr, names))}: {error}") from error
    sensor = (_number(arrays["width"]), _number(arrays["height"])) if {"width", "height"} <= arrays.keys() else None
    return _NumpySource([_Column(arrays[names[i]]) for i in naming.columns], naming.power, sensor)


def _open_evimo_2(arrays: Mapping[str, StoredArray]) -> _NumpySource:
    """The arrays of EVIMO2: times in seconds, places in pairs x, y, polarity 1 for ON, by the writer and the viewer in
    https://github.com/better-flow/evimo; that of the Samsung camera is inverted."""
    pairs = arrays["events_xy"]
    if pairs.shape[1] != 2 or pairs.fortran_order:
        raise RecordingError(f"events_xy: is {pairs.shape} of {pairs.dtype}: must be (n, 2), row by row")
    places = pairs.rows_as_records()
    x, y = places.dtype.names or ()
    columns = [
        _Column(arrays["events_t"]),
        _Column(places, x),
        _Column(places, y),
        _Column(arrays["events_p"], lowest_bit=True),
    ]
    source = _NumpySource(columns, 6)
    source.details["polarity"] = "the lowest bit of events_p; EVIMO2 states that of the Samsung camera as inverted"
    return source


def _number(array: StoredArray) -> int:
    if array.shape not in ((), (1,)) or array.dtype.kind not in "iu":
        raise RecordingError(f"{array.name}: is {array.shape} of {array.dtype}: must be one whole number")
    with array.rows(0) as stream:
        value = array.read(stream, 1)
        array.check_end(stream)
    if not len(value):
        raise RecordingError(f"{array.name}: ends before its value; is it cut off?")
    return int(value[0])


FORMATS = (
    Format("npz", "NumPy npz", lambda start, _: start.startswith(b"PK\x03\x04"), _open_npz),
    Format("npy", "NumPy npy", lambda start, _: start.startswith(b"\x93NUMPY"), _open_npy),
)


_FIELDS: dict[str, np.dtype[Any]] = {
    name: np.dtype(of) for name, of in (("t_us", "<i8"), ("x", "<u2"), ("y", "<u2"), ("p", "u1"))
}
_EVENT_BYTES = sum(dtype.itemsize for dtype in _FIELDS.values())


class _NpzSink:
    """See `source.Sink`."""

    def __init__(self, file: BinaryIO, sensor: Sensor) -> None:
        self._file, self._sensor = file, sensor
        self._counts: list[int] = []
        self._spool: IO[bytes] = tempfile.TemporaryFile(dir=Path(file.name).parent)  # noqa: SIM115
        weakref.finalize(self, self._spool.close)

    def write(self, events: Events) -> None:
        """See `source.Sink`."""
        for field, dtype in _FIELDS.items():
            self._spool.write(np.ascontiguousarray(getattr(events, field), dtype).data)
        self._counts.append(len(events))

    def close(self) -> None:
        """See `source.Sink`."""
        with zipfile.ZipFile(self._file, "w", zipfile.ZIP_STORED) as archive:
            skipped = 0
            for field, dtype in _FIELDS.items():
                with _member(archive, field) as member:
                    np.lib.format.write_array_header_1_0(
                        member, {"descr": dtype.str, "fortran_order": False, "shape": (sum(self._counts),)}
                    )
                    self._copy(member, skipped, dtype.itemsize)
                skipped += dtype.itemsize
            for name, size in zip(("width", "height"), self._sensor, strict=True):
                with _member(archive, name) as member:
                    np.lib.format.write_array(member, np.array(size), (1, 0))
        self._spool.close()

    def _copy(self, member: IO[bytes], skipped_bytes: int, item_bytes: int) -> None:
        """Copy one field of every block; in a block, `skipped_bytes` per event precede this field."""
        at = 0
        for count in self._counts:
            self._spool.seek(at + count * skipped_bytes)
            member.write(self._spool.read(count * item_bytes))
            at += count * _EVENT_BYTES


def _member(archive: zipfile.ZipFile, name: str) -> IO[bytes]:
    return archive.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True)


WRITABLE = (WritableFormat("npz", "NumPy npz", ".npz", _NpzSink),)
