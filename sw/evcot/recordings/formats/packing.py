# SPDX-License-Identifier: Apache-2.0
"""LZ4 and Zstandard frames from untrusted files: their stated size is not trusted, and the output is bounded.

A small frame is decompressed at once, up to a limit set by the caller; a frame of any size is decompressed in pieces, so that
a few kilobytes that expand to gigabytes take time, but no memory.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import Protocol

import lz4.frame

from ..._zstd import zstd
from ...errors import RecordingError

__all__ = ["Lz4Unpacker", "PlainUnpacker", "Readable", "Section", "TooLarge", "Unpacker", "ZstdUnpacker"]

_PIECE_BYTES = 1 << 20  # maximum to decompress, or to read from a file, at once
_FILE_BYTES = 1 << 16
_ZSTD_WINDOW_LOG_MAX = 27


class TooLarge(RecordingError):
    """A frame that expands to more than the caller's limit."""


class Readable(Protocol):
    """Compressed bytes, from a file or from memory."""

    def read(self, size: int = ..., /) -> bytes:
        """The next bytes, at most `size`; none at the end."""
        ...


class Unpacker(Protocol):
    """Decompressor for one kind of frame; not thread-safe."""

    def whole(self, packed: bytes | memoryview, most: int) -> bytes:
        """The content of one frame.

        Raises:
            TooLarge: it expands to more than `most` bytes.
            RecordingError: not exactly one complete frame.
        """
        ...

    def pieces(self, packed: Readable) -> Iterator[bytes]:
        """The content of one frame of any size, in pieces of bounded size. Only one frame at a time."""
        ...


class Section:
    """A section of a file; the file's position may be changed by others between reads."""

    def __init__(self, file: io.BufferedReader, at: int, length: int) -> None:
        self._file, self._at, self._end = file, at, at + length

    def read(self, size: int = -1, /) -> bytes:
        """The next bytes, up to `size` of them."""
        left = self._end - self._at
        self._file.seek(self._at)
        data = self._file.read(left if size < 0 else min(size, left))
        self._at += len(data)
        return data

    def skip(self, size: int, /) -> None:
        """Skip `size` bytes."""
        self._at = min(self._at + size, self._end)


class PlainUnpacker:
    """Passes uncompressed data through."""

    def whole(self, packed: bytes | memoryview, most: int) -> bytes:
        """See `Unpacker`."""
        if len(packed) > most:
            raise _too_large(most)
        return bytes(packed)

    def pieces(self, packed: Readable) -> Iterator[bytes]:
        """See `Unpacker`."""
        while piece := packed.read(_PIECE_BYTES):
            yield piece


class Lz4Unpacker:
    """Decompresses LZ4 frames."""

    def __init__(self) -> None:
        self._context = lz4.frame.create_decompression_context()

    def whole(self, packed: bytes | memoryview, most: int) -> bytes:
        """See `Unpacker`."""
        try:
            lz4.frame.reset_decompression_context(self._context)
            first, used, is_whole = lz4.frame.decompress_chunk(self._context, packed, max_length=_step(packed, most))
        except RuntimeError as error:
            raise RecordingError(f"is no LZ4 frame: {error}") from error
        if is_whole and used == len(packed) and len(first) <= most:
            return bytes(first)
        return _joined(self.pieces(io.BytesIO(packed)), most)

    def pieces(self, packed: Readable) -> Iterator[bytes]:
        """See `Unpacker`."""
        lz4.frame.reset_decompression_context(self._context)
        seen, is_whole, rest = 0, False, memoryview(b"")
        try:
            while not is_whole:
                if not rest:
                    rest = memoryview(packed.read(_FILE_BYTES))
                    seen += len(rest)
                piece, used, is_whole = lz4.frame.decompress_chunk(self._context, rest, max_length=_PIECE_BYTES)
                if not (piece or used or is_whole):
                    raise RecordingError(f"LZ4 frame of {seen} bytes: must be whole")
                rest = rest[used:]
                if piece:
                    yield bytes(piece)
        except RuntimeError as error:
            raise RecordingError(f"is no LZ4 frame: {error}") from error
        following = len(rest) + len(packed.read())
        if following:
            raise RecordingError(f"{following} bytes follow the LZ4 frame: must be none")


class ZstdUnpacker:
    """Decompresses Zstandard frames; truncation is not detected."""

    def whole(self, packed: bytes | memoryview, most: int) -> bytes:
        """See `Unpacker`."""
        return _joined(self._read(io.BytesIO(packed), len(packed), _step(packed, most)), most)

    def pieces(self, packed: Readable) -> Iterator[bytes]:
        """See `Unpacker`."""
        return self._read(packed, _FILE_BYTES, _PIECE_BYTES)

    def _read(self, packed: Readable, size: int, step: int) -> Iterator[bytes]:
        one = zstd.ZstdDecompressor(options={zstd.DecompressionParameter.window_log_max: _ZSTD_WINDOW_LOG_MAX})
        try:
            while not one.eof:
                data = packed.read(size) if one.needs_input else b""
                piece = one.decompress(data, step)
                if piece:
                    yield piece
                elif one.needs_input and not data:
                    return
        except zstd.ZstdError as error:
            raise RecordingError(f"is no Zstandard frame: {error}") from error


def _step(packed: bytes | memoryview, most: int) -> int:
    """Bytes to decompress per step: usually all of them."""
    return min(8 * len(packed) + (1 << 16), most + 1)


def _joined(pieces: Iterator[bytes], most: int) -> bytes:
    kept: list[bytes] = []
    count = 0
    for piece in pieces:
        kept.append(piece)
        count += len(piece)
        if count > most:
            raise _too_large(most)
    return b"".join(kept)


def _too_large(most: int) -> TooLarge:
    return TooLarge(f"unpacks to more than {most} bytes: must be at most that")
