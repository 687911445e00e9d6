# SPDX-License-Identifier: Apache-2.0
"""MATLAB files with a struct of events, as the tools around the ATIS and N-MNIST write it: TD.x, TD.y, TD.p, TD.ts; with
variables of these names; or with a matrix of four columns.

The fields may have any of the names in `hdf5_survey.NAMES`.

Of several structs, TD is read: in files of the ATIS it has the changes, and EM exposure measurements. Else the first.

MATLAB counts pixels from 1, and so do these tools; other exporters count from 0. The data decide: if some x or y is 0, both
are counted from 0, else from 1. A polarity of 2 implies the coding 1 and 2, one of -1 the coding -1 and 1, neither 0 and 1.
`ts` is in microseconds, or in seconds if the numbers of the first block are not all whole. Without a struct or such variables,
the longest matrix of four columns is read; `column_order` says what they are.

Files of version 5 to 7 are decoded here; one of 7.3 is HDF5.
https://www.mathworks.com/help/pdf_doc/matlab/matfile_format.pdf
"""

from __future__ import annotations

import io
import math
import zlib
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ...errors import RecordingError
from ...events import Events
from .hdf5 import open_file, open_rows
from .hdf5_survey import NAMES, survey
from .numeric import (
    SAMPLED_ROWS,
    UNITS,
    Order,
    column_order,
    microseconds,
    order_text,
    whole_numbers,
    without_unsigned_minus_one,
)
from .packing import Section
from .printable import printable, reason
from .source import BLOCK_EVENTS, AnySensor, Format, Sensor

__all__ = ["FORMATS"]

_CHANGES = "TD"  # the struct with change detection
_VARIABLES = "/"  # stands for the file's variables, as if they were a struct's fields
_FIELDS = ("x", "y", "p", "ts")
_NAMES_OF_FIELDS = frozenset(name for field in _FIELDS for name in NAMES[field.removesuffix("s")])
_HEADER_BYTES = 128
# Element types; those that hold numbers -> dtype.
_INT8, _INT32, _UINT32, _MATRIX, _COMPRESSED = 1, 5, 6, 14, 15
_NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
# Classes of matrix; from 6 on, numbers.
_STRUCT, _DOUBLE, _UINT64 = 2, 6, 15
_COMPLEX = 0x0800
_MOST_SIDES = 32
# A compressed variable up to this size is decompressed once and held; of a larger one, each column is decompressed separately.
_HELD_BYTES_MAX = 1 << 26
_PIECE_BYTES = 1 << 16
_SMALL_BYTES_MAX = 1 << 16  # for names, dimensions and flags


class _Stream(Protocol):
    """A sequential stream of bytes."""

    def read(self, size: int, /) -> bytes: ...

    def skip(self, size: int, /) -> None: ...


class _Held(io.BytesIO):
    """Bytes in memory."""

    def skip(self, size: int, /) -> None:
        self.seek(size, 1)


class _Inflated:
    """The content of a deflate stream, decompressed on demand."""

    def __init__(self, packed: Section) -> None:
        self._packed, self._stream, self._waiting = packed, zlib.decompressobj(), b""

    def read(self, size: int, /) -> bytes:
        """The next bytes; fewer only at the end of the stream, after its checksum has been verified."""
        parts: list[bytes] = []
        left = size
        while left and not self._stream.eof:
            try:
                part = self._stream.decompress(self._waiting, min(left, 1 << 20))
            except zlib.error as error:
                raise RecordingError(f"a compressed variable is damaged: {reason(error)}") from error
            self._waiting = self._stream.unconsumed_tail
            if not part and not self._waiting and not self._stream.eof:
                self._waiting = self._packed.read(_PIECE_BYTES)
                if not self._waiting:
                    raise RecordingError("a compressed variable is damaged: its deflate stream has no end")
            parts.append(part)
            left -= len(part)
        return b"".join(parts)

    def skip(self, size: int, /) -> None:
        """Skip `size` bytes."""
        while size and (part := self.read(min(size, 1 << 20))):
            size -= len(part)


class _Elements:
    """A sequence of elements: each has a tag with its type and its number of bytes.

    Attributes:
        at: offset of the next byte in the stream.
        behind: offset of the end of the element whose tag was read last.
    """

    def __init__(self, stream: _Stream, order: str, end: int, first_byte: int = 0) -> None:
        self._stream, self.order, self._end, self._first_byte = stream, order, end, first_byte
        self.at = self.behind = 0

    @property
    def place(self) -> int:
        """The offset of the next byte, for messages."""
        return self._first_byte + self.at

    def tag(self, *kinds: int) -> tuple[int, int]:
        """Read the next tag, which must be of one of `kinds`, if any are given: (kind, length). The content follows."""
        place = self.place
        start = self._stream.read(4).ljust(4, b"\0")
        kind = int(np.frombuffer(start, f"{self.order}u4")[0])
        if kind >> 16:  # four bytes at most, in the tag itself
            kind, length = kind & 0xFFFF, kind >> 16
            self.at += 4
            self.behind = self.at + 4
        else:
            length = int(np.frombuffer(self._stream.read(4).ljust(4, b"\0"), f"{self.order}u4")[0])
            self.at += 8
            self.behind = self.at + (length if kind == _COMPRESSED else -(-length // 8) * 8)
        if self.at + length > self._end:
            raise RecordingError(f"byte {place}: an element of {length} bytes: reaches beyond its end; is it cut off?")
        if kinds and kind not in kinds:
            raise RecordingError(f"byte {place}: an element of kind {kind}: must be of {' or '.join(map(str, kinds))}")
        return kind, length

    def end_at(self, end: int) -> None:
        """Set the limit beyond which no further element may reach."""
        self._end = min(self._end, end)

    def go_to(self, at: int) -> None:
        """Skip to a byte."""
        self._stream.skip(at - self.at)
        self.at = at

    def content(self, *kinds: int) -> bytes:
        """The content of the next element, which must be small."""
        place = self.place
        _, length = self.tag(*kinds)
        if length > _SMALL_BYTES_MAX:
            raise RecordingError(f"byte {place}: an element of {length} bytes: must be at most {_SMALL_BYTES_MAX} here")
        data = self._stream.read(length)
        self.at += len(data)
        self.go_to(self.behind)
        if len(data) < length:
            raise RecordingError(f"byte {place}: an element of {length} bytes: reaches beyond its end; is it cut off?")
        return data

    def whole_numbers(self, kind: int) -> list[int]:
        """The 32-bit numbers of the next element."""
        place = self.place
        data = self.content(kind)
        if len(data) % 4:
            raise RecordingError(f"byte {place}: {len(data)} bytes of numbers: must be a multiple of 4")
        return [int(each) for each in np.frombuffer(data, f"{self.order}{_NUMBERS[kind]}")]


_Opener = Callable[[], _Stream]


@dataclass(frozen=True)
class _Place:
    """Location of the numbers of a column: the offset in the variable at which they begin, their type and count."""

    dtype: np.dtype[Any]
    at: int
    count: int


def _find_events(elements: _Elements) -> tuple[str, dict[str, _Place]] | None:
    """The name and columns of a struct of events, of a matrix of four columns, which are called 0 to 3, or of a vector called
    like a field, whose column has no name; None for any other variable."""
    kind, _ = elements.tag()
    if kind != _MATRIX:
        return None
    elements.end_at(elements.behind)
    matrix, sides, name = _matrix_head(elements)
    if _DOUBLE <= matrix <= _UINT64 and len(sides) == 2 and sides[0] > 0 and sides[1] == 4:
        rows, whole = sides[0], _find_values(name, math.prod(sides), elements)
        step = rows * whole.dtype.itemsize
        return name, {str(i): _Place(whole.dtype, whole.at + i * step, rows) for i in range(4)}
    if _DOUBLE <= matrix <= _UINT64 and len(sides) == 2 and min(sides) == 1 and name in _NAMES_OF_FIELDS:
        return name, {"": _find_values(name, math.prod(sides), elements)}
    if matrix != _STRUCT or math.prod(sides) != 1:
        return None
    width = elements.whole_numbers(_INT32)
    names = elements.content(_INT8)
    if len(width) != 1 or not 0 < width[0] <= len(names):
        return None
    fields = [names[at : at + width[0]].split(b"\0")[0].decode("latin-1") for at in range(0, len(names), width[0])]
    called = _called(fields)
    if called is None:
        return None
    places: dict[str, _Place] = {}
    for field in fields:
        elements.tag(_MATRIX)
        behind = elements.behind
        if field in called:
            places[called[field]] = _find_numbers(field, elements)
        elements.go_to(behind)
    return name, places


def _called(names: Collection[str]) -> dict[str, str] | None:
    """Name -> which of `_FIELDS` it means; None unless all of them are there."""
    called = {next((name for name in NAMES[field.removesuffix("s")] if name in names), ""): field for field in _FIELDS}
    return None if "" in called else called


def _matrix_head(elements: _Elements) -> tuple[int, list[int], str]:
    """(class, numbers of rows, columns and so on, name)."""
    flags = elements.whole_numbers(_UINT32)
    sides = elements.whole_numbers(_INT32)[:_MOST_SIDES]
    name = elements.content(_INT8).decode("latin-1")
    if len(flags) != 2 or flags[0] & _COMPLEX:
        raise RecordingError(f"byte {elements.place}: a matrix of flags {flags[:2]}: must be of real numbers")
    return flags[0] & 0xFF, sides, name


def _find_numbers(field: str, elements: _Elements) -> _Place:
    kind, sides, _ = _matrix_head(elements)
    if not _DOUBLE <= kind <= _UINT64:
        raise RecordingError(f"{field}: is a matrix of class {kind}: must hold numbers")
    return _find_values(field, math.prod(sides), elements)


def _find_values(name: str, size: int, elements: _Elements) -> _Place:
    place = elements.place
    kind, length = elements.tag()
    if kind not in _NUMBERS:
        raise RecordingError(f"byte {place}: an element of kind {kind}: must hold numbers")
    dtype = np.dtype(elements.order + _NUMBERS[kind])
    if length != size * dtype.itemsize:
        raise RecordingError(f"{printable(name)}: holds {length / dtype.itemsize:g} of {size} numbers: must hold all")
    return _Place(dtype, elements.at, size)


class _Column(Protocol):
    """One field of all events."""

    @property
    def count(self) -> int: ...

    def blocks(self) -> Iterator[NDArray[Any]]:
        """The numbers, `BLOCK_EVENTS` at a time."""
        ...


@dataclass(frozen=True)
class _Stored:
    """A column of a file of version 5."""

    name: str
    place: _Place
    open: _Opener

    @property
    def count(self) -> int:
        return self.place.count

    def blocks(self) -> Iterator[NDArray[Any]]:
        stream = self.open()
        stream.skip(self.place.at)
        for first in range(0, self.count, BLOCK_EVENTS):
            wanted = min(BLOCK_EVENTS, self.count - first) * self.place.dtype.itemsize
            data = stream.read(wanted)
            if len(data) < wanted:
                raise RecordingError(f"{self.name}: ends within its {self.count} numbers; is it cut off?")
            yield np.frombuffer(data, self.place.dtype)


@dataclass(frozen=True)
class _InHdf5:
    """A column of a file of version 7.3."""

    rows: Any

    @property
    def count(self) -> int:
        return len(self.rows)

    def blocks(self) -> Iterator[NDArray[Any]]:
        for first in range(0, self.count, BLOCK_EVENTS):
            yield self.rows[first : min(first + BLOCK_EVENTS, self.count)].ravel()


# Its name, its columns, the names of the others, and the order of the columns of a matrix.
_Struct = tuple[str, dict[str, _Column], list[str], Order | None]


def _choose(names: list[str], wanted: str | None) -> str:
    """The struct to read."""
    if wanted is None:
        return _CHANGES if _CHANGES in names else names[0]
    if wanted not in names:
        raise RecordingError(f"has no struct {wanted!r} of events: must be one of {', '.join(map(printable, names))}")
    return wanted


def _read_version_5(file: io.BufferedReader, wanted: str | None) -> _Struct:
    start = file.read(_HEADER_BYTES)
    order = {b"IM": "<", b"MI": ">"}[start[126:128]]
    size = file.seek(0, 2)
    at = _HEADER_BYTES
    others = 0
    structs: dict[str, dict[str, _Column]] = {}
    matrices: dict[str, dict[str, _Column]] = {}
    vectors: dict[str, _Column] = {}
    while at < size:
        outer = _Elements(Section(file, at, size - at), order, size - at, at)
        kind, length = outer.tag()
        begin, place = at, at
        at += outer.behind
        if kind == _COMPRESSED:
            begin = place + outer.at
            open_variable = _opener(file, begin, length, order)
            found = _find_events(_Elements(open_variable(), order, 1 << 32))
        else:
            open_variable = _section_opener(file, begin, size - begin)
            found = _find_events(_Elements(open_variable(), order, size - begin, begin))
        if found is not None:
            name, places = found
            columns: dict[str, _Column] = {
                field: _Stored(field or name, place, open_variable) for field, place in places.items()
            }
            if "" in columns:
                vectors[name] = columns[""]
            else:
                (matrices if "0" in places else structs)[name] = columns
        others += found is None
    called = _called(vectors)
    if called is not None:
        structs[_VARIABLES] = {field: vectors[name] for name, field in called.items()}
    if not structs and matrices:
        return _of_matrices(matrices, wanted)
    if not structs:
        others += len(vectors)
        count = "1 variable" if others == 1 else f"{others} variables"
        raise RecordingError(f"holds {count}, no struct with the fields {', '.join(_FIELDS)}, and no matrix of four columns")
    name = _choose([*structs], wanted)
    return name, structs[name], [other for other in structs if other != name], None


def _of_matrices(matrices: dict[str, dict[str, _Column]], wanted: str | None) -> _Struct:
    """The longest matrix, or the one of a name, with its columns in the order that their first values show."""
    name = _choose(sorted(matrices, key=lambda each: -matrices[each]["0"].count), wanted)
    columns = matrices[name]
    sample = np.stack([next(columns[str(i)].blocks())[:SAMPLED_ROWS].astype(np.float64) for i in range(4)], axis=1)
    sample -= (sample == 2).any(axis=0) & np.isin(sample, (1, 2)).all(axis=0)  # polarities 1 and 2
    try:
        order = column_order(sample)
    except RecordingError as error:
        raise RecordingError(f"{printable(name)}: {error}") from error
    fields = {field: columns[str(i)] for field, i in zip(("ts", "x", "y", "p"), order, strict=True)}
    return name, fields, [other for other in matrices if other != name], order


def _section_opener(file: io.BufferedReader, begin: int, length: int) -> _Opener:
    return lambda: Section(file, begin, length)


def _opener(file: io.BufferedReader, begin: int, length: int, order: str) -> _Opener:
    """Make a function that opens a compressed variable, after verifying the checksum."""
    stream = _Inflated(Section(file, begin, length))
    content = stream.read(_HELD_BYTES_MAX + 1)
    if len(content) <= _HELD_BYTES_MAX:
        return lambda: _Held(content)
    content = b""
    while stream.read(1 << 20):
        pass
    return lambda: _Inflated(Section(file, begin, length))


def _read_version_7_3(path: Path, wanted: str | None) -> tuple[_Struct, Any]:
    found = survey(path, matlab=True, first=wanted or _CHANGES)
    if wanted is not None and found["details"]["events"] != wanted:
        _choose([found["details"]["events"], *found["others"]], wanted)
    file = open_file(path)
    try:
        held = {field: open_rows(file, part) for field, part in found["columns"].items()}
    except BaseException:
        file.close()
        raise
    name, others = found["details"]["events"], found["others"]
    columns: dict[str, _Column] = {"ts" if field == "t" else field: _InHdf5(rows) for field, rows in held.items()}
    if "0" not in columns:
        return (name, columns, others, None), file
    try:
        name, columns, _, order = _of_matrices({name: columns}, None)
    except BaseException:
        file.close()
        raise
    return (name, columns, others, order), file


class _MatlabFile(AnySensor):
    """A struct of events as a `source.Source`."""

    def __init__(self, path: Path, wanted: str | None = None) -> None:
        self._file: Any = path.open("rb")
        try:
            if _is_version_7_3(self._file.read(_HEADER_BYTES)):
                self._file.close()
                (name, self._columns, others, order), self._file = _read_version_7_3(path, wanted)
            else:
                self._file.seek(0)
                name, self._columns, others, order = _read_version_5(self._file, wanted)
            self._look_over()
            self._in_seconds = _has_fractions(self._columns["ts"])
        except BaseException:
            self._file.close()
            raise
        self.sensor: Sensor | None = None
        self.left_out: Counter[str] = Counter()
        self.remarks: list[str] = []
        kind = "struct" if order is None else "matrix"
        details = {"variables": ", ".join(_FIELDS)} if name == _VARIABLES else {kind: printable(name)}
        details |= {"pixels": f"counted from {self._first}"}
        if self._in_seconds or order is not None:
            details["times in"] = UNITS[6 if self._in_seconds else 0]
        if order is not None:
            named = f"{order_text(order)}, assumed by their values; a struct with the fields {', '.join(_FIELDS)} names them"
            details["columns"] = named
        self.details: Mapping[str, str] = details | ({"also holds": ", ".join(map(printable, others))} if others else {})

    def _look_over(self) -> None:
        """Detect the coding of pixels and polarities."""
        lengths = {field: self._columns[field].count for field in _FIELDS}
        if len(set(lengths.values())) > 1:
            held = ", ".join(f"{field} {length}" for field, length in lengths.items())
            raise RecordingError(f"{held} values: all must be the same")
        zero = any(not block.all() for field in "xy" for block in self._columns[field].blocks())
        self._first = 0 if zero else 1
        self._p_first = 1 if any((block == 2).any() for block in self._columns["p"].blocks()) else 0

    def blocks(self, from_us: int | None = None) -> Iterator[Events]:
        """See `source.Source`; `from_us` is ignored."""
        first = 0
        for ts, x, y, p in zip(*(self._columns[field].blocks() for field in ("ts", "x", "y", "p")), strict=True):
            p = without_unsigned_minus_one(p)
            columns = [whole_numbers(field, values, np.int32, first) for field, values in (("x", x), ("y", y), ("p", p))]
            yield Events(
                t_us=microseconds(ts, first) if self._in_seconds else whole_numbers("ts", ts, np.int64, first),
                x=whole_numbers("x", columns[0] - self._first, np.uint16, first),
                y=whole_numbers("y", columns[1] - self._first, np.uint16, first),
                p=whole_numbers("p", columns[2] - self._p_first, np.uint8, first, signed=True),
            )
            first += len(ts)

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def _has_fractions(column: _Column) -> bool:
    """Whether some number of the first block is not whole."""
    values = next(column.blocks(), np.empty(0))
    return bool((values != np.rint(values)).any())


def _is_version_7_3(start: bytes) -> bool:
    return start.startswith(b"MATLAB 7.3 MAT-file")


def _matches(start: bytes, _: Path) -> bool:
    is_version_5 = start[124:128] in (b"\x00\x01IM", b"\x01\x00MI") and start.startswith(b"MATLAB")
    return is_version_5 or _is_version_7_3(start)


FORMATS = (Format("matlab", "MATLAB", _matches, _MatlabFile, _MatlabFile),)
