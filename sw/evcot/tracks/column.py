# SPDX-License-Identifier: Apache-2.0
"""Values of one type that are appended and read in parts: in memory, or in a scratch file that is cut back to a checkpoint."""

from __future__ import annotations

import os
import struct
import threading
from bisect import bisect_right
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from .._zstd import zstd
from ..errors import OutputError, TrackLogError, reason_of

__all__ = ["Column", "GrowingColumn", "HeldColumn", "PackedColumn", "in_runs"]

_BLOCK_BYTES = 1 << 20  # of values before they are packed
_HEADER = struct.Struct("<II")  # values of a block, bytes that follow
_RUN = 1 << 14  # values
_LEVEL = 1  # of Zstandard: higher ones take half as long again and save a twentieth


class Column(Protocol):
    """Values that are read in parts, each an array."""

    def __len__(self) -> int: ...

    def __getitem__(self, part: slice, /) -> NDArray[Any]: ...


class GrowingColumn(Column, Protocol):
    """A column to which values are added at the end."""

    def append(self, values: NDArray[Any], /) -> None:
        """Add values at the end."""


def in_runs(values: Column, size: int = _RUN) -> Iterator[tuple[int, NDArray[Any]]]:
    """The number of its first value, and the run, for each run of `size` values."""
    for begin in range(0, len(values), size):
        yield begin, values[begin : begin + size]


class HeldColumn:
    """Values of one type in memory.

    Args:
        dtype: of a value.
    """

    def __init__(self, dtype: np.dtype[Any]) -> None:
        self._parts = [np.empty(0, dtype)]

    def append(self, values: NDArray[Any]) -> None:
        """Add values at the end."""
        self._parts.append(values)

    def __len__(self) -> int:
        return sum(map(len, self._parts))

    def __getitem__(self, part: slice) -> NDArray[Any]:
        if len(self._parts) > 1:
            self._parts = [np.concatenate(self._parts)]
        return self._parts[0][part]


class PackedColumn:
    """Values of one type in a file.

    A block holds the first bytes of its values, then the second ones, and so on, compressed: records of a track log take an
    eighth of their size, owners a tenth. Several threads may read at the same time.

    Args:
        path: made if it does not exist.
        dtype: of a value.
        length: values that it is cut back to; it must have been flushed when it had so many.

    Raises:
        OutputError: the file cannot be written.
        TrackLogError: it does not hold `length` values.
    """

    def __init__(self, path: Path, dtype: np.dtype[Any], length: int = 0) -> None:
        self._path = path
        self._dtype = dtype
        self._most = max(_BLOCK_BYTES // dtype.itemsize, 1)
        self._length = 0
        self._begins: list[int] = []  # of each block: the number of its first value, and where it is in the file
        self._places: list[int] = []
        self._end = 0
        self._waiting: list[NDArray[Any]] = []  # values that are in no block yet
        self._packed = 0
        self._one = threading.RLock()
        self._newest = threading.local()  # the block that a thread read last
        with self._named():
            self._file = path.open("r+b" if path.exists() else "x+b")
            try:
                self._find_blocks(length)
                self._file.truncate(self._end)
            except BaseException:
                self._file.close()
                raise

    def append(self, values: NDArray[Any]) -> None:
        """Add values at the end."""
        self._waiting.append(np.array(values, self._dtype))
        self._length += len(values)
        if self._length - self._packed >= self._most:
            self._pack(whole=True)

    def flush(self) -> None:
        """Put everything on the disk."""
        self._pack()
        with self._named():
            self._file.flush()
            os.fsync(self._file.fileno())

    def close(self) -> None:
        """Close the file."""
        with self._named():  # what is buffered may find the disk full
            self._file.close()

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, part: slice) -> NDArray[Any]:
        begin, end, step = part.indices(self._length)
        assert step == 1
        with self._one:
            if end > self._packed:
                self._pack()
        found: list[NDArray[Any]] = []
        while begin < end:
            number = bisect_right(self._begins, begin) - 1
            values, first = self._block(number), self._begins[number]
            found.append(values[begin - first : end - first])
            begin = first + len(values)
        if len(found) == 1:
            return found[0]
        return np.concatenate([np.empty(0, self._dtype), *found])

    def _find_blocks(self, length: int) -> None:
        while self._packed < length:
            self._file.seek(self._end)
            header = self._file.read(_HEADER.size)
            count, size = _HEADER.unpack(header) if len(header) == _HEADER.size else (0, 0)
            if not count or self._packed + count > length or self._end + _HEADER.size + size > self._path.stat().st_size:
                raise TrackLogError(f"{self._path}: holds {self._packed} values: must hold {length}, as at its checkpoint")
            self._note(count, size)
        self._length = length

    def _note(self, count: int, size: int) -> None:
        self._begins.append(self._packed)
        self._places.append(self._end)
        self._packed += count
        self._end += _HEADER.size + size

    def _pack(self, *, whole: bool = False) -> None:
        """Write what waits; with `whole`, only blocks that are full."""
        values = np.concatenate(self._waiting) if self._waiting else np.empty(0, self._dtype)
        done = len(values) - len(values) % self._most if whole else len(values)
        for begin in range(0, done, self._most):
            block = values[begin : min(begin + self._most, done)]
            planes = np.ascontiguousarray(block.view(np.uint8).reshape(len(block), -1).T)
            packed = zstd.compress(planes.tobytes(), _LEVEL)
            with self._one, self._named():
                self._file.seek(self._end)
                self._file.write(_HEADER.pack(len(block), len(packed)) + packed)
            self._note(len(block), len(packed))
        self._waiting = [values[done:].copy()] if done < len(values) else []

    def _block(self, number: int) -> NDArray[Any]:
        newest: tuple[int, NDArray[Any]] | None = getattr(self._newest, "block", None)
        if newest is not None and newest[0] == number:
            return newest[1]
        with self._one, self._named():
            self._file.seek(self._places[number])
            count, size = _HEADER.unpack(self._file.read(_HEADER.size))
            content = self._file.read(size)
        planes = np.frombuffer(zstd.decompress(content), np.uint8).reshape(self._dtype.itemsize, count)
        values = np.ascontiguousarray(planes.T).view(self._dtype).reshape(count)
        values.flags.writeable = False
        self._newest.block = number, values
        return values

    @contextmanager
    def _named(self) -> Iterator[None]:
        """OutputError, which names the file, where the system refuses."""
        try:
            yield
        except OSError as error:
            raise OutputError(f"{self._path}: cannot be written: {reason_of(error, self._path)}") from error
