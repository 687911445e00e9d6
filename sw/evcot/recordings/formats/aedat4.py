# SPDX-License-Identifier: Apache-2.0
"""AEDAT 4.0, read packet by packet.

Layout: the AEDAT 4.0 page of iniVation's documentation, and the FlatBuffers schemas published with DV (IOHeader, EventPacket,
FileDataTable). The version line is followed by a length and the header, which has the compression, the table's offset (-1
until the writer closes the file) and, in XML, the streams. Then packets: stream, length, and a compressed FlatBuffers buffer,
prefixed by its length. Last, compressed in the same way, the table: for each packet its offset (after stream and length),
stream, length, number of elements, and times.

The packets are followed by their own lengths. The table serves for seeking only, and a place that it names is checked; where
table and packets disagree, the packets are believed, and a remark says so (see `aedat4_table`).

Decoded here because faery 0.7 replaces a decreasing time by the latest one seen, aborts the process on some damaged headers,
and cannot seek to a time.
"""

from __future__ import annotations

import io
import struct
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import njit
from ...errors import RecordingError
from ...events import Events
from .aedat4_metadata import (
    HEADER_BYTES_MAX,
    NONE_UNLIKE,
    Header,
    PacketTable,
    Spans,
    Unlike,
    parse_header,
    parse_table,
    type_of,
)
from .blocks import batches, in_order
from .flatbuffers import root_table, size_prefixed, usual_vector, vector_head
from .packing import Section, TooLarge, Unpacker
from .source import BLOCK_EVENTS, AnySensor, Format

__all__ = ["EVENT", "FORMATS", "MAGIC", "PACKET_HEAD", "Aedat4File", "events_of"]

MAGIC = b"#!AER-DAT4.0\r\n"
PACKET_HEAD = struct.Struct("<ii")  # stream, length of what follows
EVENT = np.dtype(
    {"names": ["t", "x", "y", "on"], "formats": ["<i8", "<u2", "<u2", "u1"], "offsets": [0, 8, 10, 12], "itemsize": 16}
)

_USUAL_HEAD = vector_head(b"EVTS")
_BATCH_BYTES = 4 * BLOCK_EVENTS  # compressed, decoded at once
# Limit for decompressing a packet, or a batch, at once: 256 thousand events. A larger packet is decoded in pieces.
_WHOLE_BYTES_MAX = 1 << 22
_HEAD_BYTES_MAX = 1 << 12  # of a large packet, before its events
_TABLE_BYTES_MAX = 1 << 28  # 4 million packets and more


class _Packet(NamedTuple):
    """A packet: the offset after its stream and length fields, and its length."""

    at: int
    length: int

    @property
    def place(self) -> str:
        return f"packet at byte {self.at - PACKET_HEAD.size}"


_Read = tuple[_Packet, bytes | None]  # a packet and its compressed bytes; None: too many to be held in memory


class _Decoded(NamedTuple):
    """Events, the error that ends them, the packets that were deferred, whether the first of these is too large, and the
    packets that differ from the table."""

    events: Events
    fault: RecordingError | None
    rest: list[_Read]
    large: bool
    unlike: Unlike


class Aedat4File(AnySensor):
    """The first stream of events of an AEDAT4 file. See `source.Source`."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._size = path.stat().st_size
        self.left_out: Counter[str] = Counter()
        with path.open("rb") as file:
            header = _read_header(file, self._size)
            self._begin, self._streams, self._table_at = header.end, header.streams, header.table_at
            self._new_unpacker = header.new_unpacker
            self._stream = header.first_of_events
            self._end = self._table_at if self._begin <= self._table_at <= self._size else self._size
            self._unlike = NONE_UNLIKE
            self._table: PacketTable | None = None
            self._untold = ""  # why the table is not used
            kind = self._read_table(file)
        self.sensor = header.sensor(self._stream)
        others = [f"stream {stream} ({type_of(said)})" for stream, said in self._streams.items() if stream != self._stream]
        self.details: Mapping[str, str] = {
            "source": self._streams[self._stream].get("source", "not named"),
            "compression": header.compression_name,
            "packet table": kind,
            "other streams": f"{', '.join(others)}: not read" if others else "none",
        }

    def _read_table(self, file: io.BufferedReader) -> str:
        """Read the table, if there is one that can be read; returns what kind of table the file has."""
        if self._table_at == -1:
            return "none: the writer never closed the file"
        try:
            if not self._begin <= self._table_at:
                raise RecordingError(f"must begin behind the header, at byte {self._begin} or later")
            if self._size < self._table_at:
                return "none: the file ends before it"
            if self._size - self._table_at > _TABLE_BYTES_MAX:
                raise RecordingError(f"is of {self._size - self._table_at} bytes: must be at most {_TABLE_BYTES_MAX}")
            file.seek(self._table_at)
            content = self._new_unpacker().whole(file.read(), _TABLE_BYTES_MAX)
            table = parse_table(content, self._end - self._begin, PACKET_HEAD.size)
        except RecordingError as error:
            self._untold = f"packet table at byte {self._table_at}: {error}; the packets are read without it"
            return "cannot be read"
        if not table.states(self._stream):
            return "without numbers of events and times"
        self._table = table
        return "whole"

    @property
    def remarks(self) -> Sequence[str]:
        """See `source.Source`."""
        if not self._unlike.count:
            return [self._untold] if self._untold else []
        packets = "a packet, which is" if self._unlike.count == 1 else f"{self._unlike.count} packets, which are"
        first = f"{_Packet(self._unlike.at, 0).place}: {self._unlike.how}"
        return [f"packet table at byte {self._table_at}: differs from {packets} believed; {first}"]

    def blocks(self, from_us: int | None = None) -> Iterator[Events]:
        """See `source.Source`."""
        self._unlike = NONE_UNLIKE
        with self._path.open("rb") as file:
            begin = self._begin if from_us is None else self._place_of(file, from_us)
            for decoded in in_order(self._decode, batches(self._read(file, begin), _BATCH_BYTES, _held_bytes)):
                yield from self._given(file, decoded)
        if self._table_at > self._size:
            raise RecordingError(f"ends at byte {self._size}: its packets go on to byte {self._table_at}; is it cut off?")

    def _given(self, file: io.BufferedReader, decoded: _Decoded) -> Iterator[Events]:
        """Decoded events in blocks, then those of the deferred packets, then the error."""
        while True:
            self._differs(decoded.unlike)
            for begin in range(0, len(decoded.events), BLOCK_EVENTS):
                yield decoded.events[begin : begin + BLOCK_EVENTS]
            if decoded.fault is not None:
                raise decoded.fault
            if not decoded.rest:
                return
            if decoded.large:
                packet = decoded.rest[0][0]
                try:
                    yield from self._large(file, packet)
                except RecordingError as error:
                    raise RecordingError(f"{packet.place}: {error}") from error
            decoded = self._decode(decoded.rest[decoded.large :])

    def _differs(self, unlike: Unlike) -> None:
        """Note packets that differ from the table."""
        if unlike.count:
            first = self._unlike if self._unlike.count else unlike
            self._unlike = replace(first, count=self._unlike.count + unlike.count)

    def _place_of(self, file: io.BufferedReader, from_us: int) -> int:
        """The offset of a packet before which all events are earlier than `from_us`: the one behind the packet that the table
        names, if that one does end before; else the first one."""
        before = self._table.last_before(self._stream, from_us) if self._table is not None else None
        if before is None:
            return self._begin
        packet = _Packet(before[0], before[1])
        if packet.at < self._begin + PACKET_HEAD.size or not 0 <= packet.length <= min(_WHOLE_BYTES_MAX, self._end - packet.at):
            return self._begin
        file.seek(packet.at - PACKET_HEAD.size)
        data = file.read(PACKET_HEAD.size + packet.length)
        if not data.startswith(PACKET_HEAD.pack(self._stream, packet.length)):
            return self._begin
        decoded = self._decode([(packet, data[PACKET_HEAD.size :])])
        is_before = decoded.fault is None and len(decoded.events) and decoded.events.t_us.max() < from_us
        return packet.at + packet.length if is_before else self._begin

    def _read(self, file: io.BufferedReader, at: int) -> Iterator[_Read]:
        """All packets of events from byte `at` on, found by following the lengths."""
        unpacker = self._new_unpacker()
        while at < self._end:
            file.seek(at)
            head = file.read(PACKET_HEAD.size)
            stream, length = PACKET_HEAD.unpack(head) if len(head) == PACKET_HEAD.size else (self._stream, self._size)
            packet = _Packet(at + PACKET_HEAD.size, length)
            if length < 0 or packet.at + length > self._end:
                raise RecordingError(f"{packet.place} goes beyond byte {self._end}, their end; is it cut off or damaged?")
            if stream not in self._streams:
                raise RecordingError(f"{packet.place}: stream {stream}: must be one of {sorted(self._streams)}")
            if stream == self._stream:
                yield packet, None if length > _WHOLE_BYTES_MAX else file.read(length)
            elif (
                self._may_hold_events(packet, stream)
                and _begin(unpacker, Section(file, packet.at, packet.length))[8:12] == b"EVTS"
            ):
                raise RecordingError(f"{packet.place}: holds events: stream {stream} must not")
            at = packet.at + length

    def _may_hold_events(self, packet: _Packet, stream: int) -> bool:
        """Whether a packet of another stream must be read, since nothing else shows that it holds no events of this one."""
        if type_of(self._streams[stream]) == "EVTS":
            return False
        return self._table is None or self._table.stream_at(packet.at) != stream

    def _decode(self, read: list[_Read]) -> _Decoded:
        """The events of some packets, up to the first that is damaged or too large for here."""
        unpacker = self._new_unpacker()
        parts: list[NDArray[np.int64]] = []
        fault: RecordingError | None = None
        large = False
        held = 0
        for packet, data in read:
            if data is None or held > _WHOLE_BYTES_MAX:
                large = data is None
                break
            try:
                content = unpacker.whole(data, _WHOLE_BYTES_MAX)
                held += len(content)
                parts.append(_elements(content))
            except TooLarge:
                large = True
                break
            except RecordingError as error:
                fault = RecordingError(f"{packet.place}: {error}")
                break
        ends = np.cumsum([len(part) // 2 for part in parts], dtype=np.int64)
        events = Events.allocated(int(ends[-1]) if parts else 0)
        for part, end in zip(parts, ends, strict=True):
            _fill(part, end - len(part) // 2, events.t_us, events.x, events.y, events.p)
        unlike = self._unlike_table([packet.at for packet, _ in read[: len(parts)]], events.t_us, ends)
        return _Decoded(events, fault, [] if fault else read[len(parts) :], large, unlike)

    def _unlike_table(self, at: list[int], t_us: NDArray[np.int64], ends: NDArray[np.int64]) -> Unlike:
        """The packets that differ from the table; their events end at indices `ends` of `t_us`."""
        if self._table is None or not at:
            return NONE_UNLIKE
        count = np.diff(ends, prepend=0)
        first_us, last_us = np.zeros((2, len(at)), np.int64)
        filled = count > 0
        first_us[filled], last_us[filled] = t_us[(ends - count)[filled]], t_us[ends[filled] - 1]
        return self._table.unlike(Spans(np.array(at), count, first_us, last_us))

    def _large(self, file: io.BufferedReader, packet: _Packet) -> Iterator[Events]:
        """The events of a packet of any size, in blocks: memory does not grow with it."""
        content = _Content(self._new_unpacker().pieces(Section(file, packet.at, packet.length)))
        head = content.look(_HEAD_BYTES_MAX)
        stated = int.from_bytes(head[:4], "little")
        at, count = root_table(memoryview(head)[4:], b"EVTS").vector(0, EVENT.itemsize, stated)
        if at + 4 > len(head):
            raise RecordingError(f"events begin at byte {at + 4}: must begin within {_HEAD_BYTES_MAX} in a packet so large")
        content.take(at + 4)
        span = np.zeros(2, np.int64)
        for first in range(0, count, BLOCK_EVENTS):
            words = np.frombuffer(content.take(min(BLOCK_EVENTS, count - first) * EVENT.itemsize), "<i8")
            events = Events.allocated(len(words) // 2)
            _fill(words, 0, events.t_us, events.x, events.y, events.p)
            yield events
            if len(events) < min(BLOCK_EVENTS, count - first):
                break
            span[first > 0 :] = events.t_us[[0, -1]][first > 0 :]
        end = content.end()
        if end != 4 + stated:
            raise RecordingError(f"{end - 4} bytes, {stated} by its own length: must be the same")
        if self._table is not None:
            self._differs(self._table.unlike(Spans(np.array([packet.at]), np.array([count]), span[:1], span[1:])))

    def close(self) -> None:
        """Do nothing: no file stays open between passes."""


class _Content:
    """The content of an iterator of pieces, consumed from the front."""

    def __init__(self, pieces: Iterator[bytes]) -> None:
        self._pieces = pieces
        self._held = b""
        self._taken = 0

    def look(self, count: int) -> bytes:
        """The next `count` bytes, or all that are left, without consuming them."""
        parts, held = [self._held], len(self._held)
        while held < count and (piece := next(self._pieces, b"")):
            parts.append(piece)
            held += len(piece)
        self._held = b"".join(parts)
        return self._held[:count]

    def take(self, count: int) -> bytes:
        """The next `count` bytes, or all that are left, consumed."""
        data = self.look(count)
        self._held = self._held[count:]
        self._taken += len(data)
        return data

    def end(self) -> int:
        """Skip the rest; returns the total number of bytes."""
        return self._taken + len(self._held) + sum(map(len, self._pieces))


def _held_bytes(read: _Read) -> int:
    return _BATCH_BYTES if read[1] is None else len(read[1])


def _begin(unpacker: Unpacker, packed: Section) -> bytes:
    """The first decompressed bytes of a packet."""
    return next(unpacker.pieces(packed), b"")


def _elements(data: bytes) -> NDArray[np.int64]:
    """The vector of events in a decompressed packet, two words each."""
    vector = usual_vector(data, _USUAL_HEAD, EVENT.itemsize)
    if vector is None:
        buffer = size_prefixed(data)
        at, count = root_table(buffer, b"EVTS").vector(0, EVENT.itemsize)
        vector = buffer[at : at + count * EVENT.itemsize]
    return np.frombuffer(vector, "<i8")


def events_of(data: bytes) -> Events:
    """The events of one decompressed packet.

    Raises:
        RecordingError: it is damaged.
    """
    words = _elements(data)
    events = Events.allocated(len(words) // 2)
    _fill(words, 0, events.t_us, events.x, events.y, events.p)
    return events


@njit(cache=True, nogil=True)
def _fill(words, at, t_us, x, y, p):  # type: ignore[no-untyped-def]
    """Decode events from two words each: the time; and x, y, polarity from the low bits up, as in `EVENT`."""
    for i in range(len(words) // 2):
        t_us[at + i] = words[2 * i]
        word = words[2 * i + 1]
        x[at + i] = word
        y[at + i] = word >> 16
        p[at + i] = word >> 32


def _read_header(file: io.BufferedReader, size: int) -> Header:
    file.seek(len(MAGIC))
    length = int.from_bytes(file.read(4), "little")
    end = len(MAGIC) + 4 + length
    if size < len(MAGIC) + 4 or end > size:
        raise RecordingError(f"ends within its header, at byte {size}")
    if length > HEADER_BYTES_MAX:
        raise RecordingError(f"header of {length} bytes: must be at most {HEADER_BYTES_MAX}")
    return parse_header(file.read(length), end)


FORMATS = (Format("aedat4", "AEDAT 4.0", lambda start, _: start.startswith(MAGIC), Aedat4File),)
