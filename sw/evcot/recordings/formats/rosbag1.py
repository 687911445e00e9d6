# SPDX-License-Identifier: Apache-2.0
"""ROS 1 bags, version 2.0, read sequentially: everything before a damaged place is recovered, with or without an index.

A bag is a sequence of records: a header of `name=value` fields, then data, each prefixed by its length. Messages are stored in
chunks, which may be compressed; an index after the chunks has the number of messages.
http://wiki.ros.org/Bags/Format/2.0
"""

from __future__ import annotations

import bz2
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from ...errors import RecordingError
from .printable import printable, reason

__all__ = ["MAGIC", "Bag1"]

MAGIC = b"#ROSBAG V2.0\n"
_MESSAGE, _BAG, _INDEX, _CHUNK, _CHUNK_INFO, _CONNECTION = 2, 3, 4, 5, 6, 7
# Far above the size of any real header: names and a few numbers, or the text of a message definition.
_MOST_HEADER_BYTES = 1 << 20
# A chunk is decompressed at once: 300 times the default chunk size of rosbag.
_MOST_CHUNK_BYTES = 1 << 28
_LZ4_RATIO_MAX = 256

_Header = dict[bytes, bytes]


class _Connection(NamedTuple):
    topic: str
    kind: str


class _Record(NamedTuple):
    """A record. `place`: its offset in the file or in its chunk, for messages; its data begin at byte `data_at` of the file.

    `is_cut`: the file ends within it, and `data_bytes` are those that are there.
    """

    place: str
    header: _Header
    data_at: int
    data_bytes: int
    is_cut: bool = False

    @property
    def op(self) -> int:
        return self.number(b"op", 1)

    def number(self, name: bytes, size: int) -> int:
        value = self.header.get(name, b"")
        if len(value) != size:
            raise RecordingError(f"{self.place}: field {name.decode()} has {len(value)} bytes: must have {size}")
        return int.from_bytes(value, "little")


class Bag1:
    """An open bag.

    Attributes:
        topics: name -> message type, of all topics.
        remarks: where the index is wrong without any message being lost; complete when `messages` has ended.
    """

    is_cdr = False

    def __init__(self, path: Path) -> None:
        self.remarks: list[str] = []
        self._file = path.open("rb")
        try:
            self._size = self._file.seek(0, 2)
            self._connections: dict[int, _Connection] = {}
            self._index_at = self._find_index()
            self._find_connections()
        except BaseException:
            self._file.close()
            raise
        self.topics = dict(self._connections.values())

    def messages(self, topic: str) -> Iterator[memoryview]:
        """The messages of a topic, in file order.

        Raises:
            RecordingError: at a damaged place; or at the end, if the index has a different number of messages.
        """
        seen = 0
        counted: Counter[int] = Counter()
        for record in self._records(len(MAGIC)):
            if record.op == _CHUNK:
                for message in self._chunk_messages(record, topic):
                    seen += 1
                    yield message
            elif record.op == _CHUNK_INFO:
                counted.update(self._counts(record))
        if self._index_at > self._size:
            raise RecordingError(f"ends at byte {self._size}, before its index at byte {self._index_at}; is it cut off?")
        expected = sum(count for number, count in counted.items() if self._topic_of(number) == topic)
        counts = f"topic {printable(topic)}: {seen} messages in the chunks, {expected} in the index"
        if self._index_at and seen < expected:
            raise RecordingError(f"{counts}: must not be fewer")
        self.remarks = [f"{counts}: all are read"] if counted and seen > expected else []

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _topic_of(self, number: int) -> str:
        if number not in self._connections:
            raise RecordingError(f"connection {number}: has no description; is it damaged?")
        return self._connections[number].topic

    def _find_index(self) -> int:
        """Offset of the index; 0 in a bag that was never closed.

        Raises:
            RecordingError: the bag header is missing, or the bag is encrypted.
        """
        first = next(self._records(len(MAGIC)), None)
        if first is None or first.op != _BAG:
            raise RecordingError(f"byte {len(MAGIC)}: must be the bag's header; is it cut off?")
        if first.header.get(b"encryptor"):
            raise RecordingError(f"is encrypted by {_text(first.header[b'encryptor'])!r}: must not be")
        return first.number(b"index_pos", 8)

    def _find_connections(self) -> None:
        """Collect all connections from the index; without one, those of the chunks as far as they can be read."""
        for start in (self._index_at or self._size, len(MAGIC)):
            try:
                for record in self._records(start):
                    self._note_connections(record)
            except RecordingError:
                if start == len(MAGIC) and not self._connections:
                    raise
            if self._connections:
                break

    def _records(self, at: int) -> Iterator[_Record]:
        """The records from byte `at` on, without reading their data; of a chunk that the file ends within, what is there."""
        while at < self._size:
            place = f"byte {at}"
            header_bytes = int.from_bytes(self._read(at, 4, place), "little")
            header = _parse(self._read(at + 4, header_bytes, place) if header_bytes <= _MOST_HEADER_BYTES else b"", place)
            data_at = at + 8 + header_bytes
            data_bytes = int.from_bytes(self._read(data_at - 4, 4, place), "little")
            at = data_at + data_bytes
            if at > self._size:
                if header.get(b"op") == bytes([_CHUNK]):
                    yield _Record(place, header, data_at, self._size - data_at, is_cut=True)
                raise RecordingError(f"{place}: a record that ends at byte {at} of {self._size}; is it cut off?")
            yield _Record(place, header, data_at, data_bytes)

    def _read(self, at: int, count: int, place: str) -> bytes:
        self._file.seek(at)
        content = self._file.read(count) if at + count <= self._size else b""
        if len(content) != count:
            raise RecordingError(f"{place}: a record that the file ends within, at byte {self._size}; is it cut off?")
        return content

    def _note_connections(self, record: _Record) -> None:
        """Store the connection that a record describes, or those in a chunk."""
        if record.op == _CONNECTION:
            self._connect(record, self._read(record.data_at, record.data_bytes, record.place))
        elif record.op == _CHUNK:
            for inner, data in self._inner_records(record):
                if inner.op == _CONNECTION:
                    self._connect(inner, bytes(data))

    def _connect(self, record: _Record, data: bytes) -> None:
        kind = _parse(data, record.place).get(b"type", b"")
        topic = record.header.get(b"topic", b"")
        found = _Connection(_text(topic), _text(kind))
        if self._connections.setdefault(record.number(b"conn", 4), found) != found:
            raise RecordingError(f"{record.place}: connection {record.number(b'conn', 4)}: has two different descriptions")

    def _chunk_messages(self, chunk: _Record, topic: str) -> Iterator[memoryview]:
        for record, data in self._inner_records(chunk):
            if record.op == _MESSAGE:
                if self._topic_of(record.number(b"conn", 4)) == topic:
                    yield data
            elif record.op == _CONNECTION:
                self._connect(record, bytes(data))
            else:
                raise RecordingError(
                    f"{record.place}: a record of kind {record.op} in a chunk: must be a message or a connection"
                )

    def _inner_records(self, chunk: _Record) -> Iterator[tuple[_Record, memoryview]]:
        """The records in a chunk, and their data."""
        content = memoryview(self._unpacked(chunk))
        at = 0
        while at < len(content):
            place = f"{chunk.place}, byte {at} of its chunk"
            header_bytes = int.from_bytes(content[at : at + 4], "little")
            data_at = at + 8 + header_bytes
            data_bytes = int.from_bytes(content[data_at - 4 : data_at], "little")
            if data_at + data_bytes > len(content):
                if chunk.is_cut:
                    return
                raise RecordingError(f"{place}: a record that ends at byte {data_at + data_bytes} of {len(content)}")
            header = _parse(bytes(content[at + 4 : data_at - 4]), place)
            yield _Record(place, header, data_at, data_bytes), content[data_at : data_at + data_bytes]
            at = data_at + data_bytes

    def _unpacked(self, chunk: _Record) -> bytes:
        kind, size = chunk.header.get(b"compression", b""), chunk.number(b"size", 4)
        if max(size, chunk.data_bytes) > _MOST_CHUNK_BYTES:
            most = max(size, chunk.data_bytes)
            raise RecordingError(f"{chunk.place}: a chunk of {most} bytes: must be at most {_MOST_CHUNK_BYTES}")
        packed = self._read(chunk.data_at, chunk.data_bytes, chunk.place)
        try:
            content = _unpack(kind, packed, size)
        except (OSError, RuntimeError, EOFError) as error:
            raise RecordingError(f"{chunk.place}: a damaged {_text(kind)} chunk: {reason(error)}") from error
        if content is None:
            raise RecordingError(f"{chunk.place}: compression {_text(kind)!r}: must be none, bz2 or lz4")
        if len(content) != size and not (chunk.is_cut and len(content) < size):
            raise RecordingError(f"{chunk.place}: a chunk of {len(content)} bytes: must be the {size} that its header gives")
        return content

    def _counts(self, record: _Record) -> dict[int, int]:
        """Number of messages in a chunk by connection, from the index."""
        data = self._read(record.data_at, record.data_bytes, record.place)
        numbers = [int.from_bytes(data[at : at + 4], "little") for at in range(0, len(data), 4)]
        return dict(zip(numbers[::2], numbers[1::2], strict=False))


def _unpack(kind: bytes, packed: bytes, size: int) -> bytes | None:
    """The content of a chunk, at most `size` + 1 bytes of it; None for an unknown compression."""
    if kind == b"none":
        return packed
    if kind == b"bz2":
        return bz2.BZ2Decompressor().decompress(packed, size + 1)
    if kind == b"lz4":
        import lz4.frame

        most = min(size + 1, _LZ4_RATIO_MAX * len(packed))  # the library allocates this much
        content: bytes = lz4.frame.LZ4FrameDecompressor().decompress(packed, most)
        return content
    return None


def _text(value: bytes) -> str:
    return printable(value.decode("latin-1"))


def _parse(header: bytes, place: str) -> _Header:
    """The fields of a header.

    Raises:
        RecordingError: it has no fields, or one that extends beyond its end.
    """
    fields: _Header = {}
    at = 0
    while at < len(header):
        end = at + 4 + int.from_bytes(header[at : at + 4], "little")
        name, equals, value = header[at + 4 : end].partition(b"=")
        if end > len(header) or not equals:
            break
        fields[name] = value
        at = end
    if not fields or at != len(header):
        raise RecordingError(f"{place}: a record whose header of {len(header)} bytes is damaged")
    return fields
