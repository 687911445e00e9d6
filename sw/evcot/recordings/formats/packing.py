# SPDX-License-Identifier: Apache-2.0
"""LZ4 and Zstandard frames that nobody vouches for: what they say of their size is not believed, what they give is bounded."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import chain

import lz4.frame
import zstandard

from ...errors import RecordingError

__all__ = ["UNPACKED_BYTES_MAX", "unpack_lz4", "unpack_zstd"]

# What a frame may give: 64 million events of 16 bytes, far more than any writer puts into one packet.
UNPACKED_BYTES_MAX = 1 << 30
_ZSTD_WINDOW_BYTES_MAX = 1 << 27


def unpack_lz4() -> Callable[[bytes | memoryview], bytes]:
    """A function that unpacks one LZ4 frame a call, and raises RecordingError for what is not one whole frame."""
    context = lz4.frame.create_decompression_context()

    def rest_of(packed: bytes | memoryview, used: int, step: int, whole: bool) -> Iterator[bytes]:
        while not whole:
            part, more, whole = lz4.frame.decompress_chunk(context, memoryview(packed)[used:], max_length=step)
            if not (part or more or whole):
                raise RecordingError(f"LZ4 frame of {len(packed)} bytes: must be whole")
            used += more
            yield part
        if used < len(packed):
            raise RecordingError(f"{len(packed) - used} bytes follow the LZ4 frame: must be none")

    def unpack(packed: bytes | memoryview) -> bytes:
        step = _step(packed)
        try:
            lz4.frame.reset_decompression_context(context)
            first, used, whole = lz4.frame.decompress_chunk(context, packed, max_length=step)
            if whole and used == len(packed):
                return bytes(first)
            return _joined(chain((first,), rest_of(packed, used, step, whole)))
        except RuntimeError as error:
            raise RecordingError(f"is no LZ4 frame: {error}") from error

    return unpack


def unpack_zstd() -> Callable[[bytes | memoryview], bytes]:
    """A function that unpacks one Zstandard frame a call, and raises RecordingError for what is none; a cut is not seen."""
    decompressor = zstandard.ZstdDecompressor(max_window_size=_ZSTD_WINDOW_BYTES_MAX)

    def parts(packed: bytes | memoryview) -> Iterator[bytes]:
        reader = decompressor.stream_reader(packed, read_across_frames=False)
        while part := reader.read(_step(packed)):
            yield part

    def unpack(packed: bytes | memoryview) -> bytes:
        try:
            return _joined(parts(packed))
        except zstandard.ZstdError as error:
            raise RecordingError(f"is no Zstandard frame: {error}") from error

    return unpack


def _step(packed: bytes | memoryview) -> int:
    """How much to ask for at once: in most cases all of it."""
    return min(8 * len(packed) + (1 << 16), UNPACKED_BYTES_MAX)


def _joined(parts: Iterable[bytes]) -> bytes:
    kept: list[bytes] = []
    count = 0
    for part in parts:
        kept.append(part)
        count += len(part)
        if count > UNPACKED_BYTES_MAX:
            raise RecordingError(f"unpacks to more than {UNPACKED_BYTES_MAX} bytes: must be at most that")
    return b"".join(kept)
