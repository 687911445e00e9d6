# SPDX-License-Identifier: Apache-2.0
"""AEDAT 4.0, read packet by packet.

Layout: the AEDAT 4.0 page of iniVation's documentation, and the FlatBuffers schemas published with DV (IOHeader, EventPacket,
FileDataTable). The version line is followed by a length and the header, which has the compression, the table's offset (-1
until the writer closes the file) and, in XML, the streams. Then packets: stream, length, and a compressed FlatBuffers buffer,
prefixed by its length. Last, compressed in the same way, the table: for each packet its offset (after stream and length),
stream, length, number of elements, and times.

Decoded here because faery 0.7 replaces a decreasing time by the latest one seen, aborts the process on some damaged headers,
and cannot seek to a time.
"""

from __future__ import annotations

import io
import struct
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ...errors import RecordingError
from ...events import Events
from .aedat4_header import HEADER_BYTES_MAX, Header, parse_header, type_of
from .ahead import in_order
from .flatbuffers import root_table, size_prefixed, table_columns, usual_vector, vector_head
from .gather import batches
from .packing import Section, TooLarge, Unpacker
from .source import BLOCK_EVENTS, Format, Sensor

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
_ENTRY_BYTES = 16  # minimum size of a packet's entry: its link in the list, a table, its offset in the file
# Field of a FileDataDefinition -> (index, bytes into it, type).
_TABLE_FIELDS = {
    "at": (0, 0, "<i8"),
    "stream": (1, 0, "<i4"),
    "length": (1, 4, "<i4"),
    "count": (2, 0, "<i8"),
    "first_us": (3, 0, "<i8"),
    "last_us": (4, 0, "<i8"),
}


class _Packet(NamedTuple):
    """A packet's row in the table (-1 without a table), the offset after its stream and length fields, and its length."""

    row: int
    at: int
    length: int


_Read = tuple[_Packet, memoryview | None]  # a packet and its compressed bytes; None: too many to be held in memory


class _Decoded(NamedTuple):
    """Events, the error that ends them, the packets that were deferred, and whether the first of these is too large."""

    events: Events
    fault: RecordingError | None
    rest: list[_Read]
    large: bool


class Aedat4File:
    """The first stream of events of an AEDAT4 file. See `source.Source`."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._size = path.stat().st_size
        self.left_out: Counter[str] = Counter()
        with path.open("rb") as file:
            header = _read_header(file, self._size)
            self._begin, self._streams = header.end, header.streams
            closed = header.table_at != -1
            self._end = header.table_at if closed else self._size
            if not self._begin <= self._end <= self._size:
                raise RecordingError(
                    f"packets from byte {self._begin} to {self._end}: must lie within {self._size} bytes; is the file cut off?"
                )
            self._new_unpacker = header.new_unpacker
            self._table = self._read_table(file) if closed else None
        self._stream = header.first_of_events
        self.sensor = header.sensor(self._stream)
        others = [f"stream {stream} ({type_of(said)})" for stream, said in self._streams.items() if stream != self._stream]
        self.details: Mapping[str, str] = {
            "source": self._streams[self._stream].get("source", "not named"),
            "compression": header.compression_name,
            "packet table": "whole" if closed else "none: the writer never closed the file",
            "passed over": ", ".join(others) or "nothing",
        }

    def _read_table(self, file: io.BufferedReader) -> dict[str, NDArray[np.int64]]:
        """The table's columns, in order of the packets' offsets; the packets must be contiguous."""
        if self._size - self._end > _TABLE_BYTES_MAX:
            raise RecordingError(f"packet table of {self._size - self._end} bytes: must be at most {_TABLE_BYTES_MAX}")
        file.seek(self._end)
        try:
            data = size_prefixed(self._new_unpacker().whole(file.read(), _TABLE_BYTES_MAX))
            at, count = root_table(data, b"FTAB").vector(0, 4)
            most = min((self._end - self._begin) // PACKET_HEAD.size, len(data) // _ENTRY_BYTES)
            if count > most:
                raise RecordingError(f"{count} entries: must be at most {most}, for so many bytes")
            table = table_columns(data, (at, count), _TABLE_FIELDS)
        except RecordingError as error:
            raise RecordingError(f"packet table at byte {self._end}: {error}; is the file cut off?") from error
        order = np.argsort(table["at"], kind="stable")
        table = {name: column[order] for name, column in table.items()}
        begins = table["at"] - PACKET_HEAD.size
        ends = np.append(self._begin, table["at"] + table["length"])
        wrong = np.flatnonzero((ends != np.append(begins, self._end)) | (np.append(0, table["length"]) < 0))
        if len(wrong):
            raise RecordingError(f"packet table at byte {self._end}: entry {wrong[0]} does not begin where the one before ends")
        return table

    def blocks(self, from_us: int | None = None) -> Iterator[Events]:
        """See `source.Source`."""
        with self._path.open("rb") as file:
            read = ((packet, self._read(file, packet)) for packet in self._packets(file, from_us))
            for decoded in in_order(self._decode, batches(read, _BATCH_BYTES, _held_bytes)):
                yield from self._given(file, decoded)

    def _given(self, file: io.BufferedReader, decoded: _Decoded) -> Iterator[Events]:
        """Decoded events in blocks, then those of the deferred packets, then the error."""
        while True:
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
                    raise RecordingError(f"packet at byte {packet.at - PACKET_HEAD.size}: {error}") from error
            decoded = self._decode(decoded.rest[decoded.large :])

    def _packets(self, file: io.BufferedReader, from_us: int | None) -> Iterator[_Packet]:
        """All packets of events; with a table, from the first that ends at `from_us` or later."""
        if self._table is None:
            yield from self._packets_in_turn(file)
            return
        rows = np.flatnonzero(self._table["stream"] == self._stream)
        if from_us is not None:
            reached = np.flatnonzero(self._table["last_us"][rows] >= from_us)
            rows = rows[reached[0] :] if len(reached) else rows[:0]
        columns = (rows, self._table["at"][rows], self._table["length"][rows])
        yield from map(_Packet, *(column.tolist() for column in columns))

    def _packets_in_turn(self, file: io.BufferedReader) -> Iterator[_Packet]:
        """All packets of events, found by following the lengths."""
        unpacker = self._new_unpacker()
        at = self._begin
        while at < self._end:
            file.seek(at)
            head = file.read(PACKET_HEAD.size)
            stream, length = PACKET_HEAD.unpack(head) if len(head) == PACKET_HEAD.size else (self._stream, self._size)
            at += PACKET_HEAD.size
            if length < 0 or at + length > self._end:
                raise RecordingError(
                    f"packet at byte {at - PACKET_HEAD.size} goes beyond byte {self._end}, their end; is it cut off or damaged?"
                )
            if stream not in self._streams:
                raise RecordingError(
                    f"packet at byte {at - PACKET_HEAD.size}: stream {stream}: must be one of {sorted(self._streams)}"
                )
            if stream == self._stream:
                yield _Packet(-1, at, length)
            elif type_of(self._streams[stream]) != "EVTS" and _begin(unpacker, Section(file, at, length))[8:12] == b"EVTS":
                raise RecordingError(f"packet at byte {at - PACKET_HEAD.size}: holds events: stream {stream} must not")
            at += length

    def _read(self, file: io.BufferedReader, packet: _Packet) -> memoryview | None:
        """A packet's compressed bytes; None if there are too many."""
        place = f"packet at byte {packet.at - PACKET_HEAD.size}"
        large = packet.length > _WHOLE_BYTES_MAX
        file.seek(packet.at - PACKET_HEAD.size)
        data = file.read(PACKET_HEAD.size + (0 if large else packet.length))
        if not data.startswith(PACKET_HEAD.pack(self._stream, packet.length)):
            head = PACKET_HEAD.unpack_from(data) if len(data) >= PACKET_HEAD.size else None
            raise RecordingError(
                f"{place}: stream and length {head}, {(self._stream, packet.length)} by the table: must be the same"
            )
        return None if large else memoryview(data)[PACKET_HEAD.size :]

    def _decode(self, read: list[_Read]) -> _Decoded:
        """The events of some packets, up to the first that is damaged, contradicts the table, or is too large for here."""
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
                fault = RecordingError(f"packet at byte {packet.at - PACKET_HEAD.size}: {error}")
                break
        packets = [packet for packet, _ in read[: len(parts)]]
        ends = np.cumsum([len(part) // 2 for part in parts], dtype=np.int64)
        events = Events.allocated(int(ends[-1]) if parts else 0)
        for part, end in zip(parts, ends, strict=True):
            _fill(part, end - len(part) // 2, events.t_us, events.x, events.y, events.p)
        wrong = self._first_unlike_table(packets, events.t_us, ends)
        if wrong is None:
            return _Decoded(events, fault, [] if fault else read[len(parts) :], large)
        good = int(ends[wrong - 1]) if wrong else 0
        found = events.t_us[good : ends[wrong]]
        place = f"packet at byte {packets[wrong].at - PACKET_HEAD.size}"
        return _Decoded(
            events[:good], RecordingError(f"{place}: {self._mismatch(packets[wrong], len(found), found)}"), [], False
        )

    def _large(self, file: io.BufferedReader, packet: _Packet) -> Iterator[Events]:
        """The events of a packet of any size, in blocks: memory does not grow with it."""
        content = _Content(self._new_unpacker().pieces(Section(file, packet.at, packet.length)))
        head = content.look(_HEAD_BYTES_MAX)
        stated = int.from_bytes(head[:4], "little")
        at, count = root_table(memoryview(head)[4:], b"EVTS").vector(0, EVENT.itemsize, stated)
        if at + 4 > len(head):
            raise RecordingError(f"events begin at byte {at + 4}: must begin within {_HEAD_BYTES_MAX} in a packet so large")
        content.take(at + 4)
        row = None if self._table is None else {name: int(column[packet.row]) for name, column in self._table.items()}
        last_us = 0
        for first in range(0, count, BLOCK_EVENTS):
            words = np.frombuffer(content.take(min(BLOCK_EVENTS, count - first) * EVENT.itemsize), "<i8")
            events = Events.allocated(len(words) // 2)
            _fill(words, 0, events.t_us, events.x, events.y, events.p)
            if row and (count != row["count"] or (first == 0 and len(events) and events.t_us[0] != row["first_us"])):
                raise RecordingError(self._mismatch(packet, count, events.t_us))
            yield events
            if len(events) < min(BLOCK_EVENTS, count - first):
                break
            last_us = int(events.t_us[-1])
        end = content.end()
        if end != 4 + stated:
            raise RecordingError(f"{end - 4} bytes, {stated} by its own length: must be the same")
        if row and (count != row["count"] or (count and last_us != row["last_us"])):
            raise RecordingError(self._mismatch(packet, count, np.array([row["first_us"], last_us])[: 2 * bool(count)]))

    def _first_unlike_table(self, packets: list[_Packet], t_us: NDArray[np.int64], ends: NDArray[np.int64]) -> int | None:
        if self._table is None:
            return None
        rows = [packet.row for packet in packets]
        counts = np.diff(ends, prepend=0)
        filled = counts > 0
        wrong = counts != self._table["count"][rows]
        for index, column in ((ends - counts, "first_us"), (ends - 1, "last_us")):
            wrong[filled] |= t_us[index[filled]] != self._table[column][rows][filled]
        return int(np.argmax(wrong)) if wrong.any() else None

    def _mismatch(self, packet: _Packet, held: int, t_us: NDArray[np.int64]) -> str:
        assert self._table is not None
        found = f"{held} events" + (f" from t = {t_us[0]} to {t_us[-1]} us" if len(t_us) else "")
        count, first, last = (int(self._table[name][packet.row]) for name in ("count", "first_us", "last_us"))
        return (
            f"{found}, {count} from t = {first} to {last} us by the table: "
            "must be the same; does time run back, or is it damaged?"
        )

    def smallest_sensor(self, width: int, height: int) -> Sensor:
        """See `source.Source`."""
        return width, height

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
