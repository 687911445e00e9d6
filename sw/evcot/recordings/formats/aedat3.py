# SPDX-License-Identifier: Apache-2.0
"""AEDAT 3.1, read packet by packet.

Layout: the AEDAT 3.1 page of iniVation's documentation and libcaer's headers. Lines that start with "#", the last of them
"#!END-HEADER"; then packets, little-endian throughout: a header of 28 bytes with type, source, event size, offset of the time
in an event, overflow count of the 31-bit time, capacity, number of events, number of valid events; then the events.
A polarity event is 32 bits, valid in bit 0, brighter in bit 1, y in bits 2 to 16, x in bits 17 to 31, and its time. The origin
is at the top left.
"""

from __future__ import annotations

import re
import struct
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import njit
from ...errors import RecordingError
from ...events import Events
from .blocks import batches
from .sensors import chip_sensor
from .source import BLOCK_EVENTS, AnySensor, Format

__all__ = ["FORMATS", "MAGIC", "Aedat3File"]

MAGIC = b"#!AER-DAT3."

_VERSION_LINE = b"#!AER-DAT3.1"
_END_LINE = b"#!END-HEADER"
_LINE_BYTES_MAX = 1 << 16
_LINES_MAX = 1 << 12
_HEADER_BYTES_MAX = 1 << 20
_PACKET = struct.Struct("<hh6i")
_POLARITY = 1
_EVENT_BYTES = 8
_TIME_BITS = 31
_MARKED_INVALID = "marked as not valid"


class _Packet(NamedTuple):
    """A packet header and the offset of its events."""

    at: int
    kind: int
    source: int
    event_bytes: int
    time_at: int
    turns: int
    capacity: int
    events: int
    valid: int


class _Piece(NamedTuple):
    """Some of a packet's events: their offset, the base of their times, and their words, two each."""

    at: int
    base_us: int
    words: NDArray[np.uint32]


class Aedat3File(AnySensor):
    """The brightness changes of an AEDAT 3.1 file, from the first source that has any. See `source.Source`."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._size = path.stat().st_size
        self.left_out: Counter[str] = Counter()
        self.remarks: list[str] = []
        with path.open("rb") as file:
            lines = _read_header(file)
            self._begin = file.tell()
            self._sources = _sources(lines)
            self._source = next((packet.source for packet in self._packets(file)), min(self._sources))
        self.sensor = chip_sensor(self._sources[self._source])
        others = [f"source {source} ({name})" for source, name in sorted(self._sources.items()) if source != self._source]
        self.details: Mapping[str, str] = {
            "source": self._sources[self._source],
            "other sources": f"{', '.join(others)}: not read" if others else "none",
        }

    def blocks(self, from_us: int | None = None) -> Iterator[Events]:
        """See `source.Source`."""
        self.left_out = Counter()
        with self._path.open("rb") as file:
            for read in batches(self._read(file, from_us), BLOCK_EVENTS, lambda piece: len(piece.words) // 2):
                events, fault = self._decode(read)
                yield events
                if fault is not None:
                    raise fault

    def _read(self, file: BinaryIO, from_us: int | None) -> Iterator[_Piece]:
        for packet in self._packets(file):
            if packet.source != self._source or (from_us is not None and self._last_us(file, packet) < from_us):
                continue
            for first in range(0, packet.events, BLOCK_EVENTS):
                at = packet.at + first * _EVENT_BYTES
                file.seek(at)
                data = file.read(min(BLOCK_EVENTS, packet.events - first) * _EVENT_BYTES)
                yield _Piece(at, packet.turns << _TIME_BITS, np.frombuffer(data, "<u4"))

    def _decode(self, read: list[_Piece]) -> tuple[Events, RecordingError | None]:
        """The events of some pieces up to the first with a negative time, and its error; invalid events are counted."""
        events = Events.allocated(sum(len(piece.words) // 2 for piece in read))
        count = 0
        for piece in read:
            done, filled = _fill(piece.words, piece.base_us, count, events.t_us, events.x, events.y, events.p)
            if filled < count + done:
                self.left_out[_MARKED_INVALID] += count + done - filled
            count = filled
            if 2 * done < len(piece.words):
                t = np.int32(piece.words.view("<i4")[2 * done + 1])
                what = f"event at byte {piece.at + done * _EVENT_BYTES}: t = {t}: must not be negative"
                return events[:count], RecordingError(what)
        return events[:count], None

    def _packets(self, file: BinaryIO) -> Iterator[_Packet]:
        """All packets with polarity events."""
        at = self._begin
        while at < self._size:
            file.seek(at)
            head = file.read(_PACKET.size)
            if len(head) < _PACKET.size:
                raise RecordingError(f"ends within the header of a packet, at byte {self._size}; is it cut off?")
            packet = _Packet(at + _PACKET.size, *_PACKET.unpack(head))
            self._check(packet)
            if packet.kind == _POLARITY and packet.events:
                yield packet
            at = packet.at + packet.event_bytes * packet.events

    def _check(self, packet: _Packet) -> None:
        place = f"packet at byte {packet.at - _PACKET.size}"
        if packet.event_bytes <= 0 or not 0 <= packet.valid <= packet.events <= packet.capacity or packet.turns < 0:
            raise RecordingError(
                f"{place}: {packet.valid} valid events of {packet.events} of at most {packet.capacity}, {packet.event_bytes} "
                f"bytes each, after {packet.turns} turns of time: must not be negative, and valid <= events <= capacity"
            )
        if packet.at + packet.event_bytes * packet.events > self._size:
            raise RecordingError(f"{place} goes beyond byte {self._size}, the file's end; is it cut off or damaged?")
        if packet.kind < 0 or packet.source not in self._sources:
            raise RecordingError(
                f"{place}: type {packet.kind}, source {packet.source}: must be 0 or more, and one of {sorted(self._sources)}"
            )
        if packet.kind == _POLARITY and (packet.event_bytes, packet.time_at) != (_EVENT_BYTES, 4):
            raise RecordingError(
                f"{place}: polarity events of {packet.event_bytes} bytes with their time at byte {packet.time_at}: must be of "
                f"{_EVENT_BYTES} with it at 4"
            )

    def _last_us(self, file: BinaryIO, packet: _Packet) -> int:
        file.seek(packet.at + (packet.events - 1) * _EVENT_BYTES + packet.time_at)
        return (packet.turns << _TIME_BITS) + int.from_bytes(file.read(4), "little")

    def close(self) -> None:
        """Do nothing: no file stays open between passes."""


@njit(cache=True, nogil=True)
def _fill(words, base_us, at, t_us, x, y, p):  # type: ignore[no-untyped-def]
    """Decode valid events into the columns from `at` on, up to one with a negative time; returns (events read, new end)."""
    for i in range(len(words) // 2):
        data = words[2 * i]
        time = words[2 * i + 1]
        if time >> _TIME_BITS:
            return i, at
        if data & 1:
            t_us[at] = base_us + np.int64(time)
            x[at] = data >> 17
            y[at] = data >> 2 & 0x7FFF
            p[at] = data >> 1 & 1
            at += 1
    return len(words) // 2, at


def _sources(lines: list[str]) -> dict[int, str]:
    found = (re.match(r"#Source (\d{1,5}):(.*)", line) for line in lines)
    sources = {int(match[1]): match[2].strip() for match in found if match}
    if not sources:
        raise RecordingError("header: has no line #Source <ID>: <DESCRIPTION>")
    return sources


def _read_header(file: BinaryIO) -> list[str]:
    """The header's lines; leaves the file positioned after the last."""
    lines: list[str] = []
    for _ in range(_LINES_MAX):
        at = file.tell()
        line = file.readline(_LINE_BYTES_MAX)
        text = line.rstrip(b"\r\n")
        if not line.startswith(b"#") or not line.endswith(b"\n"):
            raise RecordingError(f"header line at byte {at}: must start with # and end in a newline; is it cut off?")
        if at == 0 and text != _VERSION_LINE:
            raise RecordingError(f"AEDAT version {text[9:].decode('latin-1')!r}: must be 3.1")
        if text.startswith(b"#Format:") and text[8:].strip() != b"RAW":
            raise RecordingError(f"header: format {text[8:].strip().decode('latin-1')!r}: must be RAW")
        if text == _END_LINE:
            return lines
        lines.append(text.decode("latin-1"))
        if file.tell() > _HEADER_BYTES_MAX:
            break
    raise RecordingError(
        f"header: has no line {_END_LINE.decode()} among its first {_LINES_MAX}, or its first {_HEADER_BYTES_MAX} bytes"
    )


FORMATS = (Format("aedat3", "AEDAT 3.1", lambda start, _: start.startswith(MAGIC), Aedat3File),)
