# SPDX-License-Identifier: Apache-2.0
"""AEDAT4 and ES, decoded by faery once the structure of the file has been checked.

faery takes the end of a damaged file for the end of the recording, or panics: so every packet is measured first, and a
panic (a BaseException whose text the native side also writes on stderr) becomes a RecordingError like any other. It also
replaces a time that runs backwards by the latest one seen: so the packets of an AEDAT4 file are held against its own table.
"""

from __future__ import annotations

import os
import struct
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..errors import RecordingError
from .columns import Decoded, events_from_packets
from .source import Format
from .whole import opens_whole

__all__ = ["AEDAT4_MAGIC", "ES_MAGIC", "FORMATS", "read_aedat4", "read_es"]

AEDAT4_MAGIC = b"#!AER-DAT4.0\r\n"
ES_MAGIC = b"Event Stream"

# ES: magic, version (3 bytes), kind of event, then width and height for events that have an address.
_ES_HEADER = struct.Struct(f"<{len(ES_MAGIC)}s3sBHH")
_ES_VERSION = 2
_ES_DVS, _ES_ATIS = 1, 2
_ES_EVENT_BYTES = 5


@contextmanager
def _silent_stderr() -> Iterator[None]:
    """Point file descriptor 2 at nothing: the native panic message goes there, past `sys.stderr`."""
    sys.stderr.flush()
    kept = os.dup(2)
    try:
        with open(os.devnull, "wb") as nothing:
            os.dup2(nothing.fileno(), 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)


@contextmanager
def _native_errors() -> Iterator[None]:
    """Whatever faery raises, panics too, as a RecordingError; and nothing of it on stderr."""
    try:
        with _silent_stderr():
            yield
    except RecordingError:
        raise
    except BaseException as error:
        if not isinstance(error, Exception) and type(error).__name__ != "PanicException":
            raise
        reason = " ".join(str(error).split()) or type(error).__name__
        raise RecordingError(f"cannot be decoded: {reason}") from error


def _flatbuffers_field(table: bytes, field: int) -> int:
    """Offset of a field in a FlatBuffers buffer's root table, 0 where the field is left out."""
    (root,) = struct.unpack_from("<I", table)
    (back,) = struct.unpack_from("<i", table, root)
    if back > root:
        raise struct.error
    (size,) = struct.unpack_from("<H", table, root - back)
    at = 4 + 2 * field
    (offset,) = struct.unpack_from("<H", table, root - back + at) if at + 2 <= size else (0,)
    return root + int(offset) if offset else 0


def _check_aedat4_header(header: bytes) -> int:
    """Where the packets end, -1 where the writer never closed the file.

    The header is checked because faery trusts it: one that points outside itself, or describes the streams in what is not
    UTF-8, ends the whole process.
    """
    try:
        description = _flatbuffers_field(header, 2)
        (start,) = struct.unpack_from("<I", header, description)
        (length,) = struct.unpack_from("<I", header, description + start)
        (text,) = struct.unpack_from(f"{length}s", header, description + start + 4)
        text.decode("utf-8")
        position = _flatbuffers_field(header, 1)
        return int(struct.unpack_from("<q", header, position)[0]) if position else -1
    except (struct.error, UnicodeDecodeError, OverflowError) as error:
        raise RecordingError("header is damaged") from error


def _check_aedat4_packets(path: Path) -> None:
    """Follow the packets' lengths from the header to the file's table, or to its end where there is no table."""
    size = path.stat().st_size
    with path.open("rb") as file:
        file.seek(len(AEDAT4_MAGIC))
        prefix = file.read(4)
        header_bytes = struct.unpack("<I", prefix)[0] if len(prefix) == 4 else size
        at = len(AEDAT4_MAGIC) + 4 + header_bytes
        if at > size:
            raise RecordingError(f"ends within its header, at byte {size}")
        table = _check_aedat4_header(file.read(header_bytes))
        end = size if table == -1 else table
        if not at <= end <= size:
            raise RecordingError(f"packets from byte {at} to {end}: must end within the file's {size} bytes; is it cut off?")
        while at < end:
            file.seek(at)
            packet = file.read(8)
            length = struct.unpack("<iI", packet)[1] if len(packet) == 8 else size
            if at + 8 + length > end:
                raise RecordingError(f"packet at byte {at} goes beyond byte {end}, their end; is it cut off or damaged?")
            at += 8 + length


def _check_against_table(packets: list[NDArray[np.void]], table: list[Any]) -> None:
    """Each packet's first and last time must be those of its entry in the file's table, if it has one."""
    for i, (packet, entry) in enumerate(zip(packets, table, strict=False)):
        found, stated = (int(packet["t"][0]), int(packet["t"][-1])), (entry.start_t, entry.end_t)
        if found != stated:
            raise RecordingError(
                f"packet {i}: read as t = {found[0]} to {found[1]} us, {stated[0]} to {stated[1]} us in the file's table: "
                "must be the same; does time run back, or is it damaged?"
            )


def read_aedat4(path: Path) -> Decoded:
    """Read the first stream of events of an AEDAT4 file."""
    # faery is imported where it is needed: most runs read no such file.
    from faery import aedat

    _check_aedat4_packets(path)
    with _native_errors(), aedat.Decoder(path) as decoder:
        stream = next((track for track in decoder.tracks() if track.data_type == "events"), None)
        if stream is None:
            raise RecordingError("has no stream of events")
        packets = [packet for track, packet in decoder if track.id == stream.id and len(packet)]
        table = [entry for entry in decoder.file_data_definitions() if entry.track_id == stream.id and entry.elements_count]
    _check_against_table(packets, table)
    return Decoded(events_from_packets(packets), stream.dimensions)


@njit(cache=True, nogil=True)
def _es_end(data, overflow_mask, at):  # type: ignore[no-untyped-def]
    """Offset after the last event that starts in `data`: beyond its end when that event is cut off."""
    while at < len(data):
        at += 1 if data[at] & overflow_mask == overflow_mask else _ES_EVENT_BYTES
    return at


def _check_es_events(path: Path) -> None:
    """Follow the events' lengths from the header to the end of the file."""
    data = np.fromfile(path, np.uint8)
    if len(data) < _ES_HEADER.size:
        raise RecordingError(f"ends within its header, at byte {len(data)}: must be at least {_ES_HEADER.size} bytes")
    _, version, kind, _, _ = _ES_HEADER.unpack(data[: _ES_HEADER.size].tobytes())
    if version[0] != _ES_VERSION:
        raise RecordingError(f"ES version {version[0]}: must be {_ES_VERSION}")
    if kind not in (_ES_DVS, _ES_ATIS):
        raise RecordingError(f"ES events of kind {kind}: must be {_ES_DVS} (DVS) or {_ES_ATIS} (ATIS)")
    # DVS: bytes 254 and 255 carry no event; ATIS: those from 252 on.
    if _es_end(data, 0xFE if kind == _ES_DVS else 0xFC, _ES_HEADER.size) != len(data):
        raise RecordingError(f"ends within an event, at byte {len(data)}; is it cut off?")


def read_es(path: Path) -> Decoded:
    """Read an ES file of DVS or ATIS events; its times start from 0."""
    import faery

    _check_es_events(path)
    with _native_errors():
        stream = faery.events_stream_from_file(path, file_type="es")
        return Decoded(events_from_packets(stream), stream.dimensions())


FORMATS = (
    Format("aedat4", "AEDAT 4.0", lambda start, _: start.startswith(AEDAT4_MAGIC), opens_whole(read_aedat4)),
    Format("es", "Event Stream", lambda start, _: start.startswith(ES_MAGIC), opens_whole(read_es)),
)
