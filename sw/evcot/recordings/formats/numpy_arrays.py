# SPDX-License-Identifier: Apache-2.0
"""Arrays in .npy and .npz files, read a piece at a time: nothing is mapped into memory, nothing unpickled."""

from __future__ import annotations

import io
import lzma
import math
import struct
import tokenize
import warnings
import zipfile
import zlib
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from ...errors import RecordingError
from .printable import reason, shortened

__all__ = ["StoredArray", "damage_named", "npy_array", "npz_arrays"]

# Version -> struct format of the header length, and the function that reads the header.
_HEADERS = {
    (1, 0): (struct.Struct("<H"), np.lib.format.read_array_header_1_0),
    (2, 0): (struct.Struct("<I"), np.lib.format.read_array_header_2_0),
}
_HEADER_BYTES_MAX = 1 << 16  # limit of version 1.0; NumPy itself reads at most 10,000 characters
_ARRAY_BYTES_MAX = 1 << 60  # beyond this, offsets in the array do not fit into 64 bits
_DIRECTORY_BYTES_MAX = 1 << 20  # of a zip: thousands of arrays
_ARRAYS_MAX = 256
_SKIPPED_BYTES = 1 << 20  # at once
_LONGEST_ROW_BYTES = 256
_FAR_BYTES = 1 << 20
_LOCAL_HEADER = struct.Struct("<26xHH")  # of a zip member: ends with the lengths of its name and extra field
_DAMAGE = (
    *(zipfile.BadZipFile, zlib.error, lzma.LZMAError, struct.error, tokenize.TokenError, EOFError, LookupError, MemoryError),
    *(ArithmeticError, RuntimeError, SyntaxError, TypeError, ValueError),
)  # fmt: skip


@contextmanager
def damage_named(what: str) -> Iterator[None]:
    """Convert exceptions of zipfile and NumPy about a damaged file to a RecordingError."""
    try:
        yield
    except RecordingError:
        raise
    except _DAMAGE as error:
        raise RecordingError(f"{what}: {reason(error)}") from error


@dataclass(frozen=True)
class StoredArray:
    """An array in a file.

    Attributes:
        name: for messages.
        dtype, shape, fortran_order: from its header.
        header_bytes: offset of the values in the stream returned by `open`.
        open: returns a stream of header and values, positioned at a given byte.
        seekable: whether `open` gets to a position without reading what is before it.
        following_bytes: number of bytes after the values in the stream that belong to the same array.
    """

    name: str
    dtype: np.dtype[Any]
    shape: tuple[int, ...]
    fortran_order: bool
    header_bytes: int
    open: Callable[[int], IO[bytes]]
    seekable: bool
    following_bytes: int = 0

    def columns(self) -> list[StoredArray]:
        """The columns of a 2-D array in Fortran order, stored one after another; the file must hold all of them."""
        n, count = self.shape
        column_bytes = n * self.dtype.itemsize
        return [
            replace(self, shape=(n,), fortran_order=False, header_bytes=self.header_bytes + i * column_bytes,
                    following_bytes=(count - 1 - i) * column_bytes)
            for i in range(count)
        ]  # fmt: skip

    def rows_as_records(self) -> StoredArray:
        """A 2-D array in C order as records with one field per column."""
        n, count = self.shape
        return replace(self, shape=(n,), dtype=np.dtype([(f"column {i}", self.dtype) for i in range(count)]))

    def rows(self, first: int) -> IO[bytes]:
        """A stream of the values, starting at a row."""
        return self.open(self.header_bytes + first * self.dtype.itemsize)

    def read(self, stream: IO[bytes], count: int) -> NDArray[Any]:
        """The next `count` rows of a stream, or all that are left."""
        with damage_named(f"{self.name} is damaged"):
            content = stream.read(count * self.dtype.itemsize)
            return np.frombuffer(content, self.dtype, len(content) // self.dtype.itemsize)

    def check_end(self, stream: IO[bytes]) -> None:
        """After all rows have been read: raise if data follow, or if the checksum is wrong."""
        with damage_named(f"{self.name} is damaged"):
            if not self.following_bytes and stream.read(1):
                raise RecordingError(f"{self.name}: goes on after {self.shape[0]} rows: its header must count all of them")


def _array(name: str, open_at: Callable[[int], IO[bytes]], seekable: bool) -> StoredArray:
    with damage_named(f"{name} has a damaged header"), warnings.catch_warnings(), open_at(0) as stream:
        warnings.simplefilter("ignore")
        version = np.lib.format.read_magic(stream)
        if version not in _HEADERS:
            raise RecordingError(f"{name}: npy version {version[0]}.{version[1]}: must be 1.0 or 2.0")
        length, read_header = _HEADERS[version]
        size = stream.read(length.size)
        header_bytes = length.unpack(size)[0]
        if header_bytes > _HEADER_BYTES_MAX:
            raise RecordingError(f"{name}: header of {header_bytes} bytes: must be at most {_HEADER_BYTES_MAX}")
        shape, fortran_order, dtype = read_header(io.BytesIO(size + stream.read(header_bytes)))
        array = StoredArray(name, dtype, shape, fortran_order, stream.tell(), open_at, seekable)
    if any(side < 0 for side in shape) or math.prod(shape) * dtype.itemsize > _ARRAY_BYTES_MAX:
        raise RecordingError(f"{name}: is {shortened(str(shape))} of {dtype.itemsize} bytes each: must be below 2^60 bytes")
    if not 0 < dtype.itemsize <= _LONGEST_ROW_BYTES or dtype.hasobject:
        raise RecordingError(
            f"{name}: is {shortened(str(shape))} of {dtype.itemsize} bytes each: must be up to {_LONGEST_ROW_BYTES}, no objects"
        )
    return array


def npy_array(path: Path) -> StoredArray:
    """The array of an .npy file."""

    def open_at(byte: int) -> IO[bytes]:
        file = path.open("rb")
        file.seek(byte)
        return file

    return _array("array", open_at, True)


class _Directory(io.FileIO):
    """A zip file with a bounded read: zipfile reads the list of members in one piece, of the length that the file states."""

    def read(self, size: int | None = -1, /) -> bytes:
        """The next bytes.

        Raises:
            RecordingError: more than the limit for a list of members.
        """
        if size is not None and size > _DIRECTORY_BYTES_MAX:
            raise RecordingError(f"is a zip whose list of members has {size} bytes: must be at most {_DIRECTORY_BYTES_MAX}")
        return super().read(size) or b""


def npz_arrays(path: Path, *, beside: Collection[str] = ()) -> dict[str, StoredArray]:
    """The arrays of an .npz file by name; a compressed array is checked for damage only when read from its start.

    Args:
        beside: where an array of such a name is there, others that cannot be read, as of objects, are left out.
    """
    with damage_named("is a damaged npz"), _Directory(path) as file, zipfile.ZipFile(file) as archive:
        members = [info for info in archive.infolist() if info.filename.endswith(".npy")]
    if len(members) > _ARRAYS_MAX:
        raise RecordingError(f"holds {len(members)} arrays: must be at most {_ARRAYS_MAX}")
    arrays: dict[str, StoredArray] = {}
    names = {info.filename.removesuffix(".npy") for info in members}
    for info in members:
        name = info.filename.removesuffix(".npy")
        if name in arrays:
            raise RecordingError(f"is a damaged npz: has two arrays {name!r}")
        stored = info.compress_type == zipfile.ZIP_STORED
        try:
            arrays[name] = _array(repr(name), _member_opener(path, info), stored)
        except RecordingError:
            if name in beside or names.isdisjoint(beside):
                raise
    return arrays


def _member_opener(path: Path, info: zipfile.ZipInfo) -> Callable[[int], IO[bytes]]:
    """Make a function that opens a member: through zipfile, which verifies the checksum at the end; directly, for a position
    far into uncompressed data."""

    def open_at(byte: int) -> IO[bytes]:
        if info.compress_type == zipfile.ZIP_STORED and byte >= _FAR_BYTES:
            file = path.open("rb")
            file.seek(info.header_offset)
            name_bytes, extra_bytes = _LOCAL_HEADER.unpack(file.read(_LOCAL_HEADER.size))
            file.seek(name_bytes + extra_bytes + byte, 1)
            return file
        with damage_named("is a damaged npz"), zipfile.ZipFile(path) as archive:
            member = archive.open(info)
            while byte and (skipped := member.read(min(byte, _SKIPPED_BYTES))):
                byte -= len(skipped)
            return member

    return open_at
