# SPDX-License-Identifier: Apache-2.0
"""FlatBuffers from untrusted files: every offset is checked before it is followed.

Layout: flatbuffers.dev, "FlatBuffers internals". A buffer starts with the offset of its root table and a four-letter schema
identifier. A table starts with the offset back to its vtable: 16-bit vtable size, table size, and one offset per field, 0 or
missing where the field has its default. Strings, vectors and tables are referenced by a 32-bit offset, relative to itself.
"""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import RecordingError

__all__ = ["Table", "root_table", "size_prefixed", "table_columns", "usual_vector", "vector_head"]

_PREFIX_BYTES = 4
_ROWS = 1 << 16  # gathered at once
_USUAL_VECTOR = struct.Struct("<I24sI")  # the buffer's length, `vector_head`, number of items


def size_prefixed(data: bytes) -> memoryview:
    """The buffer after its length prefix.

    Raises:
        RecordingError: the length does not match the data.
    """
    if len(data) < _PREFIX_BYTES:
        raise RecordingError(f"{len(data)} bytes: must start with a length")
    stated = int.from_bytes(data[:_PREFIX_BYTES], "little")
    if stated != len(data) - _PREFIX_BYTES:
        raise RecordingError(f"{len(data) - _PREFIX_BYTES} bytes, {stated} by its own length: must be the same")
    return memoryview(data)[_PREFIX_BYTES:]


def root_table(data: memoryview, identifier: bytes) -> Table:
    """The root table of a buffer.

    Raises:
        RecordingError: the buffer has another schema, or is too short.
    """
    found = bytes(data[4:8])
    if found != identifier:
        raise RecordingError(f"is marked {found!r}: must be {identifier!r}")
    return Table(data, _number(data, "<I", 0))


class Table:
    """A table at an offset in a buffer. Every method raises RecordingError for an offset outside the buffer."""

    def __init__(self, data: memoryview, at: int) -> None:
        self._data = data
        self._at = at
        self._fields = at - _number(data, "<i", at)
        self._fields_bytes = _number(data, "<H", self._fields)

    def _field(self, index: int) -> int | None:
        slot = 4 + 2 * index
        offset = _number(self._data, "<H", self._fields + slot) if slot + 2 <= self._fields_bytes else 0
        return self._at + offset if offset else None

    def number(self, index: int, layout: str, default: int) -> int:
        """The value of a field with the given `struct` layout."""
        at = self._field(index)
        return default if at is None else _number(self._data, layout, at)

    def vector(self, index: int, item_bytes: int, buffer_bytes: int | None = None) -> tuple[int, int]:
        """(offset of the first item, number of items) of a vector; (0, 0) if the field is absent.

        Args:
            buffer_bytes: length of the whole buffer, if this table only has the beginning of it.
        """
        at = self._field(index)
        if at is None:
            return 0, 0
        at += _number(self._data, "<I", at)
        count = _number(self._data, "<I", at)
        at += 4
        end = len(self._data) if buffer_bytes is None else buffer_bytes
        if at + count * item_bytes > end:
            raise RecordingError(f"{count} items of {item_bytes} bytes at offset {at}: must lie within {end} bytes")
        return at, count

    def text(self, index: int) -> str:
        """A string."""
        at, count = self.vector(index, 1)
        try:
            return bytes(self._data[at : at + count]).decode("utf-8")
        except UnicodeDecodeError as error:
            raise RecordingError(f"text at offset {at + error.start}: must be UTF-8") from error


def table_columns(
    data: memoryview, vector: tuple[int, int], fields: dict[str, tuple[int, int, str]]
) -> dict[str, NDArray[np.int64]]:
    """Read number fields of many tables at once.

    Args:
        vector: (offset, count) of a vector of tables, as returned by `Table.vector`.
        fields: name -> (index, byte offset in the field, NumPy type). An absent field is 0.

    Returns:
        name -> array of shape (count,).

    Raises:
        RecordingError: an offset outside the buffer.
    """
    octets = np.frombuffer(data, np.uint8)

    def numbers(layout: str, at: NDArray[np.int64]) -> NDArray[np.int64]:
        dtype = np.dtype(layout)
        outside = np.flatnonzero((at < 0) | (at > len(data) - dtype.itemsize))
        if len(outside):
            raise RecordingError(f"offset {at[outside[0]]}: must lie within {len(data)} bytes")
        found = np.empty(len(at), np.int64)
        for begin in range(0, len(at), _ROWS):
            rows: NDArray[Any] = octets[at[begin : begin + _ROWS, np.newaxis] + np.arange(dtype.itemsize)]
            found[begin : begin + _ROWS] = rows.view(dtype)[:, 0]
        return found

    begin, count = vector
    links = begin + 4 * np.arange(count, dtype=np.int64)
    tables = links + numbers("<u4", links)
    vtables = tables - numbers("<i4", tables)
    vtable_bytes = numbers("<u2", vtables)

    def column(index: int, shift: int, layout: str) -> NDArray[np.int64]:
        values = np.zeros(count, np.int64)
        slot = 4 + 2 * index
        rows = np.flatnonzero(vtable_bytes >= slot + 2)
        offsets = numbers("<u2", vtables[rows] + slot)
        rows, offsets = rows[offsets > 0], offsets[offsets > 0]
        values[rows] = numbers(layout, tables[rows] + offsets + shift)
        return values

    return {name: column(*field) for name, field in fields.items()}


def _number(data: memoryview, layout: str, at: int) -> int:
    if at < 0 or at + struct.calcsize(layout) > len(data):
        raise RecordingError(f"offset {at}: must lie within {len(data)} bytes")
    return int(struct.unpack_from(layout, data, at)[0])


def vector_head(identifier: bytes) -> bytes:
    """The head of a buffer whose root table has one field, a vector, up to the vector's length, as laid out by FlatBuffers'
    builder: root offset, schema, padding, vtable, offset back to the vtable, offset of the vector."""
    return struct.pack("<I4s4HiI", 16, identifier, 0, 6, 8, 4, 6, 4)


def usual_vector(data: bytes, head: bytes, item_bytes: int) -> memoryview | None:
    """The items of a size-prefixed buffer that starts with a `vector_head`; None for any other layout, or if damaged.

    The same result as the checked path through the tables at a fifth of the cost: most packets of a camera are small.
    """
    if len(data) < _USUAL_VECTOR.size:
        return None
    stated, found, count = _USUAL_VECTOR.unpack_from(data)
    end = _USUAL_VECTOR.size + count * item_bytes
    if found != head or stated != len(data) - _PREFIX_BYTES or end > len(data):
        return None
    return memoryview(data)[_USUAL_VECTOR.size : end]
