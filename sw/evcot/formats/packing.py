# SPDX-License-Identifier: Apache-2.0
"""LZ4 and Zstandard frames that nobody vouches for: what they say of their size is not believed, what they give is bounded."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import lz4.frame
import zstandard

from ..errors import RecordingError

__all__ = ["UNPACKED_BYTES_MAX", "unpack_lz4", "unpack_zstd"]

# What a frame may give: 64 million events of 16 bytes, far more than any writer puts into one packet.
UNPACKED_BYTES_MAX = 1 << 30
_ZSTD_WINDOW_BYTES_MAX = 1 << 27


def unpack_lz4() -> Callable[[bytes], bytes]:
    """A function that unpacks one LZ4 frame a call, and raises RecordingError for what is not one whole frame."""
    frame = lz4.frame.LZ4FrameDecompressor()

    def parts(packed: bytes) -> Iterator[bytes]:
        step = _step(packed)
        frame.reset()
        yield frame.decompress(packed, max_length=step)
        while not frame.eof and (part := frame.decompress(b"", max_length=step)):
            yield part

    def unpack(packed: bytes) -> bytes:
        try:
            unpacked = _joined(parts(packed))
        except (RuntimeError, ValueError) as error:
            raise RecordingError(f"is no LZ4 frame: {error}") from error
        if not frame.eof:
            raise RecordingError(f"LZ4 frame of {len(packed)} bytes: must be whole")
        if frame.unused_data:
            raise RecordingError(f"{len(frame.unused_data)} bytes follow the LZ4 frame: must be none")
        return unpacked

    return unpack


def unpack_zstd() -> Callable[[bytes], bytes]:
    """A function that unpacks one Zstandard frame a call, and raises RecordingError for what is none; a cut is not seen."""
    decompressor = zstandard.ZstdDecompressor(max_window_size=_ZSTD_WINDOW_BYTES_MAX)

    def parts(packed: bytes) -> Iterator[bytes]:
        reader = decompressor.stream_reader(packed, read_across_frames=False)
        while part := reader.read(_step(packed)):
            yield part

    def unpack(packed: bytes) -> bytes:
        try:
            return _joined(parts(packed))
        except zstandard.ZstdError as error:
            raise RecordingError(f"is no Zstandard frame: {error}") from error

    return unpack


def _step(packed: bytes) -> int:
    """How much to ask for at once: in most cases all of it."""
    return min(8 * len(packed) + (1 << 16), UNPACKED_BYTES_MAX)


def _joined(parts: Iterator[bytes]) -> bytes:
    kept: list[bytes] = []
    count = 0
    for part in parts:
        kept.append(part)
        count += len(part)
        if count > UNPACKED_BYTES_MAX:
            raise RecordingError(f"unpacks to more than {UNPACKED_BYTES_MAX} bytes: must be at most that")
    return b"".join(kept)
