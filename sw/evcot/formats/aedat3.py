# SPDX-License-Identifier: Apache-2.0
"""AEDAT 3.1, read packet by packet.

Layout: the AEDAT 3.1 page of iniVation's documentation and libcaer's headers. Lines that start with "#", the last of them
"#!END-HEADER"; then packets, little-endian throughout: a header of 28 bytes with type, source, event size, offset of the time
in an event, how often the 31 bits of time have turned over, capacity, number of events, number of valid ones; then the events.
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

from ..errors import RecordingError
from ..events import Events
from .chips import chip_sensor
from .gather import gathered
from .source import BLOCK_EVENTS, Format, Sensor

__all__ = ["FORMATS", "MAGIC", "Aedat3File"]

MAGIC = b"#!AER-DAT3."

_VERSION_LINE = b"#!AER-DAT3.1"
_END_LINE = b"#!END-HEADER"
_LINE_BYTES_MAX = 1 << 16
_LINES_MAX = 1 << 12
_PACKET = struct.Struct("<hh6i")
_POLARITY = 1
_POLARITY_EVENT = np.dtype([("data", "<u4"), ("t", "<i4")])
_TIME_BITS = 31
_MARKED_INVALID = "marked as not valid"


class _Packet(NamedTuple):
    """A packet's header, and the offset of its events."""

    at: int
    kind: int
    source: int
    event_bytes: int
    time_at: int
    turns: int
    capacity: int
    events: int
    valid: int


class Aedat3File:
    """The brightness changes of an AEDAT 3.1 file, of the source that they first come from. See `source.Source`."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._size = path.stat().st_size
        self.left_out: Counter[str] = Counter()
        with path.open("rb") as file:
            lines = _read_header(file)
            self._begin = file.tell()
            self._sources = _sources(lines)
            self._source = next((packet.source for packet in self._packets(file)), min(self._sources))
        self.sensor = chip_sensor(self._sources[self._source])
        others = [f"source {source} ({name})" for source, name in sorted(self._sources.items()) if source != self._source]
        self.details: Mapping[str, str] = {
            "source": self._sources[self._source],
            "passed over": ", ".join(others) or "nothing",
        }

    def blocks(self, from_us: int | None = None) -> Iterator[Events]:
        """See `source.Source`."""
        self.left_out = Counter()
        with self._path.open("rb") as file:
            yield from gathered(self._parts(file, from_us))

    def _parts(self, file: BinaryIO, from_us: int | None) -> Iterator[Events]:
        for packet in self._packets(file):
            if packet.source != self._source or (from_us is not None and self._last_us(file, packet) < from_us):
                continue
            for first in range(0, packet.events, BLOCK_EVENTS):
                yield self._read_events(file, packet, first, min(BLOCK_EVENTS, packet.events - first))

    def _packets(self, file: BinaryIO) -> Iterator[_Packet]:
        """Every packet with polarity events."""
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
                f"bytes each, after {packet.turns} turns of time: must be none below 0, and no number beyond the next"
            )
        if packet.at + packet.event_bytes * packet.events > self._size:
            raise RecordingError(f"{place} goes beyond byte {self._size}, the file's end; is it cut off or damaged?")
        if packet.kind < 0 or packet.source not in self._sources:
            raise RecordingError(
                f"{place}: type {packet.kind}, source {packet.source}: must be 0 or more, and one of {sorted(self._sources)}"
            )
        if packet.kind == _POLARITY and (packet.event_bytes, packet.time_at) != (_POLARITY_EVENT.itemsize, 4):
            raise RecordingError(
                f"{place}: polarity events of {packet.event_bytes} bytes with their time at byte {packet.time_at}: must be of "
                f"{_POLARITY_EVENT.itemsize} with it at 4"
            )

    def _last_us(self, file: BinaryIO, packet: _Packet) -> int:
        file.seek(packet.at + (packet.events - 1) * _POLARITY_EVENT.itemsize + packet.time_at)
        return (packet.turns << _TIME_BITS) + int.from_bytes(file.read(4), "little")

    def _read_events(self, file: BinaryIO, packet: _Packet, first: int, count: int) -> Events:
        file.seek(packet.at + first * _POLARITY_EVENT.itemsize)
        elements = np.frombuffer(file.read(count * _POLARITY_EVENT.itemsize), _POLARITY_EVENT)
        data, time = elements["data"], elements["t"]
        negative = np.flatnonzero(time < 0)
        if len(negative):
            i = int(negative[0])
            raise RecordingError(
                f"event at byte {packet.at + (first + i) * _POLARITY_EVENT.itemsize}: t = {time[i]}: must not be negative"
            )
        events = Events(
            time + np.int64(packet.turns << _TIME_BITS),
            (data >> 17).astype(np.uint16),
            (data >> 2 & 0x7FFF).astype(np.uint16),
            (data >> 1 & 1).astype(np.uint8),
        )
        valid = data & 1 == 1
        if valid.all():
            return events
        self.left_out[_MARKED_INVALID] += int(np.count_nonzero(~valid))
        return events.where(valid)

    def smallest_sensor(self, width: int, height: int) -> Sensor:
        """See `source.Source`."""
        return width, height

    def close(self) -> None:
        """Nothing stays open between passes."""


def _sources(lines: list[str]) -> dict[int, str]:
    found = (re.match(r"#Source (\d{1,5}):(.*)", line) for line in lines)
    sources = {int(match[1]): match[2].strip() for match in found if match}
    if not sources:
        raise RecordingError("header: has no line #Source <ID>: <DESCRIPTION>")
    return sources


def _read_header(file: BinaryIO) -> list[str]:
    """The header's lines; the file stands behind the last."""
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
    raise RecordingError(f"header: has no line {_END_LINE.decode()} among its first {_LINES_MAX}")


FORMATS = (Format("aedat3", "AEDAT 3.1", lambda start, _: start.startswith(MAGIC), Aedat3File),)
