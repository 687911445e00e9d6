# SPDX-License-Identifier: Apache-2.0
"""Compressed chunks of HDF5 datasets, decompressed to no more than the size of a chunk.

The HDF5 library allocates memory for whatever a deflate stream expands to, up to a thousand times its length, before it checks
the expected size. So gzip, with or without shuffle, is decompressed here; for rarer filter pipelines with gzip the expanded
size of the stream is checked here before the library reads it. Prophesee's codec, which the library does not have, is undone
here too.
"""

from __future__ import annotations

import math
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import RecordingError
from . import ecf
from .numeric import RECORD
from .printable import reason

__all__ = ["Chunks", "joined"]

_DEFLATE, _SHUFFLE = 1, 2
# Deflate expands to at most 1,032 times its length. The library is faster, and a chunk this small cannot exhaust memory.
_SURE_BYTES = (1 << 27) // 1032
_SLACK_BYTES = 1 << 16  # for checksums and headers of other filters


class Chunks:
    """A dataset's rows along one axis of one or two; along the second, of one line only. See `Hdf5File` for which datasets are
    read this way."""

    def __init__(self, dataset: Any, axis: int = 0, line: int = 0) -> None:
        from h5py import h5t

        self._dataset, self._axis, self._line = dataset, axis, line
        creation = dataset.id.get_create_plist()
        self._filters = [creation.get_filter(i) for i in range(creation.get_nfilters())] if dataset.chunks else []
        codes = [int(each[0]) for each in self._filters]
        self._deflates = _DEFLATE in codes
        self.is_ecf = codes == [ecf.FILTER] and dataset.dtype == RECORD and dataset.ndim == 1
        self._across = axis == 1 or dataset.ndim == 1 or dataset.chunks is None or dataset.chunks[1] == dataset.shape[1]
        self._here = (
            codes in ([_DEFLATE], [_SHUFFLE, _DEFLATE])
            and self._across
            and dataset.dtype.kind != "b"
            and dataset.id.get_type().equal(h5t.py_create(dataset.dtype, logical=True))
        )

    def __len__(self) -> int:
        return int(self._dataset.shape[self._axis])

    def read(self, begin: int, end: int) -> NDArray[Any]:
        """The rows from begin (inclusive) to end (exclusive).

        Raises:
            RecordingError: a chunk is damaged, or not of the dataset's chunk size.
        """
        if not self._deflates and not self.is_ecf:
            return self._by_library(begin, end)
        length = self._dataset.chunks[self._axis]
        places = range(begin // length * length, end, length)
        if self.is_ecf:
            return joined([self._ecf_chunk(at)[max(begin - at, 0) : end - at] for at in places])
        if self._across and all(self._size(self._offset(at)) <= _SURE_BYTES for at in places):
            return self._by_library(begin, end)
        if not self._here:
            for place in places:
                self._measure(place)
            return self._by_library(begin, end)
        return joined([self._chunk(at)[max(begin - at, 0) : end - at] for at in places])

    def _by_library(self, begin: int, end: int) -> NDArray[Any]:
        rows: NDArray[Any] = self._dataset[self._line, begin:end] if self._axis else self._dataset[begin:end]
        return rows

    @property
    def _bytes(self) -> int:
        """Size of a whole chunk, decompressed."""
        return int(math.prod(self._dataset.chunks) * self._dataset.dtype.itemsize)

    def _size(self, offset: tuple[int, ...]) -> int:
        """Size of a chunk in the file, in bytes."""
        return int(self._dataset.id.get_chunk_info_by_coord(offset).size)

    def _packed(self, offset: tuple[int, ...]) -> tuple[int, bytes]:
        """Mask of the filters that were skipped for a chunk, and its bytes as stored in the file."""
        size = self._size(offset)
        if size > self._bytes + self._bytes // 16 + _SLACK_BYTES:
            raise RecordingError(f"chunk of {self._bytes} bytes, {size} when compressed: must not be larger")
        mask, packed = self._dataset.id.read_direct_chunk(offset)
        return mask, packed

    def _offset(self, at: int) -> tuple[int, ...]:
        if self._axis:
            return self._line - int(self._line % self._dataset.chunks[0]), at
        return (at, *[0] * (int(self._dataset.ndim) - 1))

    def _chunk(self, at: int) -> NDArray[Any]:
        """The rows of the chunk that begins at a row, including those beyond the dataset's end."""
        mask, packed = self._packed(self._offset(at))
        content: bytes | NDArray[np.uint8] = packed
        for i, (code, _, values, _) in reversed(list(enumerate(self._filters))):
            if mask >> i & 1:
                continue
            content = _inflated(content, self._bytes) if code == _DEFLATE else _unshuffled(content, values[0] if values else 1)
        if len(content) != self._bytes:
            raise RecordingError(f"chunk unpacks to {len(content)} bytes: must be {self._bytes}")
        rows = np.frombuffer(content, self._dataset.dtype)
        if self._axis:
            line: NDArray[Any] = rows.reshape(self._dataset.chunks)[self._line % self._dataset.chunks[0]]
            return line
        return rows.reshape(-1, *self._dataset.chunks[1:])

    def _ecf_chunk(self, at: int) -> NDArray[Any]:
        """The rows of a chunk in ECF, all or those within the dataset; the codec is optional, as any filter."""
        rows, (length,) = len(self), self._dataset.chunks
        mask, packed = self._packed(self._offset(at))
        content = np.frombuffer(packed, RECORD, len(packed) // RECORD.itemsize) if mask & 1 else ecf.unpack(packed, length)
        wanted = min(length, rows - at)
        if len(content) < wanted:
            raise RecordingError(f"chunk unpacks to {len(content)} events: must be {wanted}")
        return content

    def _measure(self, at: int) -> None:
        """Refuse a row of chunks if one of them expands to more than a chunk."""
        places = [self._offset(at)]
        if self._dataset.ndim == 2 and not self._axis:
            places = [(at, step) for step in range(0, self._dataset.shape[1], self._dataset.chunks[1])]
        for place in places:
            mask, packed = self._packed(place)
            for i, (code, *_) in reversed(list(enumerate(self._filters))):
                if code == _DEFLATE and not mask >> i & 1:
                    _inflated(packed, self._bytes + _SLACK_BYTES)


def joined(parts: list[NDArray[Any]]) -> NDArray[Any]:
    """The rows of parts, one after another; of records too in their own layout, which `np.concatenate` packs."""
    if len(parts) == 1:
        return parts[0]
    rows = np.empty((sum(map(len, parts)), *parts[0].shape[1:]), parts[0].dtype)
    at = 0
    for part in parts:
        rows[at : at + len(part)] = part
        at += len(part)
    return rows


def _inflated(packed: Any, most: int) -> bytes:
    stream = zlib.decompressobj()
    try:
        content = stream.decompress(packed, most + 1)
    except zlib.error as error:
        raise RecordingError(f"chunk is damaged: {reason(error)}") from error
    if len(content) > most:
        raise RecordingError(f"chunk unpacks to more than {most} bytes: must be at most that")
    if not stream.eof:
        raise RecordingError("chunk is damaged: its deflate stream has no end")
    return content


def _unshuffled(content: bytes | NDArray[np.uint8], item_bytes: int) -> NDArray[np.uint8]:
    """Undo the shuffle filter, which stores the first bytes of all items, then the second bytes, and so on."""
    octets = np.frombuffer(content, np.uint8)
    count = len(octets) // item_bytes if item_bytes > 1 else 0
    if not count:
        return octets
    items = np.empty(len(octets), np.uint8)
    whole = items[: count * item_bytes].reshape(count, item_bytes)
    whole[...] = octets[: count * item_bytes].reshape(item_bytes, count).T
    items[count * item_bytes :] = octets[count * item_bytes :]
    return items
