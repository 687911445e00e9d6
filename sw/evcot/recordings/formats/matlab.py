# SPDX-License-Identifier: Apache-2.0
"""MATLAB files with a struct of events, as the tools around the ATIS and N-MNIST write it: TD.x, TD.y, TD.p, TD.ts.

MATLAB counts pixels from 1, and so do these tools; exports by others count from 0. The data tell: where some x or y is 0, both
are counted from 0, else from 1. A polarity of 2 tells the coding 1 and 2, one of -1 the coding -1 and 1, neither 0 and 1.
`ts` is in microseconds. Files of version 5 to 7 are decoded here; one of 7.3 is HDF5.
https://www.mathworks.com/help/pdf_doc/matlab/matfile_format.pdf
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import RecordingError
from ...events import Events
from .hdf5 import open_dataset, open_file
from .hdf5_survey import survey
from .numeric import whole_numbers
from .printable import printable, reason
from .source import Format
from .whole import WholeFile

__all__ = ["FORMATS"]

_FIELDS = ("x", "y", "p", "ts")
_HEADER_BYTES = 128
# Kinds of element, and what numbers they hold.
_INT8, _INT32, _UINT32, _MATRIX, _COMPRESSED = 1, 5, 6, 14, 15
_NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
# Classes of matrix; from 6 on, numbers.
_STRUCT, _DOUBLE, _UINT64 = 2, 6, 15
_COMPLEX = 0x0800

_Columns = dict[str, NDArray[Any]]


class _Elements:
    """Elements, one after another: each says what it is and how many bytes it has."""

    def __init__(self, content: bytes | memoryview, order: str, first_byte: int = 0) -> None:
        self._content, self.order = memoryview(content), order
        self._first_byte, self._at = first_byte, 0

    def __iter__(self) -> Iterator[tuple[int, memoryview]]:
        while self._at < len(self._content):
            yield self.next()

    @property
    def place(self) -> int:
        """The byte that the next element starts at."""
        return self._first_byte + self._at

    def next(self, *kinds: int) -> tuple[int, memoryview]:
        """(kind, content) of the next element, which must be of one of `kinds`, if any are given."""
        place = self.place
        tag = np.frombuffer(self._content[self._at : self._at + 8].tobytes().ljust(8, b"\0"), f"{self.order}u4")
        kind, length = (int(each) for each in tag)
        start = self._at + 8
        if kind >> 16:  # four bytes at most, in the tag itself
            kind, length, start = kind & 0xFFFF, kind >> 16, self._at + 4
            self._at += 8
        else:
            self._at = start + (length if kind == _COMPRESSED else -(-length // 8) * 8)
        if start + length > len(self._content):
            raise RecordingError(f"byte {place}: an element of {length} bytes: reaches beyond its end; is it cut off?")
        if kinds and kind not in kinds:
            raise RecordingError(f"byte {place}: an element of kind {kind}: must be of {' or '.join(map(str, kinds))}")
        return kind, self._content[start : start + length]

    def numbers(self, *kinds: int) -> NDArray[Any]:
        """The numbers of the next element."""
        place = self.place
        kind, content = self.next(*kinds)
        if kind not in _NUMBERS:
            raise RecordingError(f"byte {place}: an element of kind {kind}: must hold numbers")
        dtype = np.dtype(self.order + _NUMBERS[kind])
        if len(content) % dtype.itemsize:
            raise RecordingError(f"byte {place}: {len(content)} bytes of numbers: must be a multiple of {dtype.itemsize}")
        return np.frombuffer(content, dtype)


def _read_struct(matrix: _Elements) -> tuple[str, _Columns] | None:
    """Name and columns of a struct of events; None for any other matrix."""
    kind, size, name = _matrix_head(matrix)
    if kind != _STRUCT or size != 1:
        return None
    width = matrix.numbers(_INT32)
    names = bytes(matrix.next(_INT8)[1])
    if len(width) != 1 or not 0 < width[0] <= len(names):
        return None
    fields = [names[at : at + width[0]].split(b"\0")[0].decode("latin-1") for at in range(0, len(names), int(width[0]))]
    if not set(_FIELDS) <= set(fields):
        return None
    columns: _Columns = {}
    for field in fields:
        place = matrix.place
        _, content = matrix.next(_MATRIX)
        if field in _FIELDS:
            columns[field] = _read_numbers(field, _Elements(content, matrix.order, place + 8))
    return name, columns


def _matrix_head(matrix: _Elements) -> tuple[int, int, str]:
    """(class, number of values, name)."""
    flags = matrix.numbers(_UINT32)
    size = 1
    for side in matrix.numbers(_INT32).tolist():
        size *= side
    name = bytes(matrix.next(_INT8)[1]).decode("latin-1")
    if len(flags) != 2 or flags[0] & _COMPLEX:
        raise RecordingError(f"byte {matrix.place}: a matrix of flags {flags.tolist()}: must be of real numbers")
    return int(flags[0] & 0xFF), size, name


def _read_numbers(field: str, matrix: _Elements) -> NDArray[Any]:
    kind, size, _ = _matrix_head(matrix)
    if not _DOUBLE <= kind <= _UINT64:
        raise RecordingError(f"{field}: is a matrix of class {kind}: must hold numbers")
    numbers = matrix.numbers()
    if len(numbers) != size:
        raise RecordingError(f"{field}: holds {len(numbers)} of {size} numbers: must hold all")
    return numbers


def _read_version_5(path: Path) -> tuple[str, _Columns]:
    content = path.read_bytes()
    order = {b"IM": "<", b"MI": ">"}[content[126:128]]
    others = []
    for kind, element in _Elements(memoryview(content)[_HEADER_BYTES:], order, _HEADER_BYTES):
        if kind == _COMPRESSED:
            kind, element = _Elements(_inflated(element), order).next()
        found = _read_struct(_Elements(element, order)) if kind == _MATRIX else None
        if found is not None:
            return found
        others.append(kind)
    raise RecordingError(f"holds {len(others)} variables, and no struct with the fields {', '.join(_FIELDS)}")


def _inflated(element: memoryview) -> bytes:
    try:
        return zlib.decompress(element)
    except zlib.error as error:
        raise RecordingError(f"a compressed variable is damaged: {reason(error)}") from error


def _read_version_7_3(path: Path) -> tuple[str, _Columns]:
    found = survey(path, matlab=True)
    with open_file(path) as file:
        columns = {}
        for field, part in found["columns"].items():
            try:
                columns["ts" if field == "t" else field] = open_dataset(file, part)[()].ravel()
            except (OSError, RuntimeError, ValueError, MemoryError) as error:
                raise RecordingError(f"{part['dataset']}: cannot be read: {reason(error)}") from error
    return found["details"]["events"], columns


def _events(columns: _Columns) -> tuple[Events, Mapping[str, str]]:
    lengths = {field: len(columns[field]) for field in _FIELDS}
    if len(set(lengths.values())) > 1:
        held = ", ".join(f"{field} {length}" for field, length in lengths.items())
        raise RecordingError(f"{held} values: all must be the same")
    t_us = whole_numbers("ts", columns["ts"], np.int64)
    x, y, p = (whole_numbers(field, columns[field], np.int32) for field in "xyp")
    first = 0 if len(x) and not (x.all() and y.all()) else 1
    if 2 in p:
        p = p - 1
    events = Events(
        t_us=t_us,
        x=whole_numbers("x", x - first, np.uint16),
        y=whole_numbers("y", y - first, np.uint16),
        p=whole_numbers("p", p, np.uint8, signed=True),
    )
    return events, {"pixels": f"counted from {first}"}


def _open(path: Path) -> WholeFile:
    with path.open("rb") as file:
        is_hdf5 = _is_version_7_3(file.read(_HEADER_BYTES))
    name, columns = _read_version_7_3(path) if is_hdf5 else _read_version_5(path)
    events, details = _events(columns)
    return WholeFile(events, {"struct": printable(name), **details})


def _is_version_7_3(start: bytes) -> bool:
    return start.startswith(b"MATLAB 7.3 MAT-file")


def _matches(start: bytes, _: Path) -> bool:
    is_version_5 = start[124:128] in (b"\x00\x01IM", b"\x01\x00MI") and start.startswith(b"MATLAB")
    return is_version_5 or _is_version_7_3(start)


FORMATS = (Format("matlab", "MATLAB", _matches, _open),)
