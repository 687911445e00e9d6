# SPDX-License-Identifier: Apache-2.0
"""The header of AEDAT 4.0, and the table of packets at the end of a file. The layout is described in `aedat4`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from ...errors import RecordingError
from .flatbuffers import root_table, size_prefixed, table_columns
from .packing import Lz4Unpacker, PlainUnpacker, Unpacker, ZstdUnpacker
from .printable import shortened, whole_number
from .source import Sensor

__all__ = [
    "HEADER_BYTES_MAX",
    "NONE_UNLIKE",
    "Header",
    "PacketTable",
    "Spans",
    "Unlike",
    "parse_header",
    "parse_table",
    "type_of",
]


HEADER_BYTES_MAX = 1 << 20  # streams described in XML: a few kilobytes

_COMPRESSIONS = ("none", "LZ4", "LZ4", "Zstandard", "Zstandard")


@dataclass(frozen=True)
class Header:
    """The header before the packets; `streams`: id -> attributes, among them the type as "typeIdentifier"."""

    end: int
    compression: int
    table_at: int
    streams: dict[int, dict[str, str]]

    @property
    def compression_name(self) -> str:
        """Display name of the compression; RecordingError for an unknown number."""
        if not 0 <= self.compression < len(_COMPRESSIONS):
            raise RecordingError(f"header: compression {self.compression}: must be from 0 to {len(_COMPRESSIONS) - 1}")
        return _COMPRESSIONS[self.compression]

    @property
    def new_unpacker(self) -> Callable[[], Unpacker]:
        """A factory of unpackers for the header's compression."""
        kinds: dict[str, Callable[[], Unpacker]] = {"none": PlainUnpacker, "LZ4": Lz4Unpacker, "Zstandard": ZstdUnpacker}
        return kinds[self.compression_name]

    @property
    def first_of_events(self) -> int:
        """The id of the first stream of events; RecordingError if there is none."""
        found = [stream for stream, said in self.streams.items() if type_of(said) == "EVTS"]
        if not found:
            raise RecordingError(
                f"has no stream of events: its streams are {[type_of(said) for said in self.streams.values()]}"
            )
        return min(found)

    def sensor(self, stream: int) -> Sensor | None:
        """(width, height) of a stream in pixels; None if not stated."""
        sides = self.streams[stream].get("sizeX"), self.streams[stream].get("sizeY")
        if sides == (None, None):
            return None
        width, height = (whole_number(side or "") for side in sides)
        if width is None or height is None:
            shown = tuple(side and shortened(side) for side in sides)
            raise RecordingError(f"header: sizeX, sizeY = {shown}: must be whole numbers")
        return width, height


def type_of(stream: dict[str, str]) -> str:
    """The four-letter type of a stream."""
    return stream.get("typeIdentifier", "")


def parse_header(data: bytes, end: int) -> Header:
    """Parse the header in a buffer that is followed, at byte `end` of the file, by packets.

    Raises:
        RecordingError: it is damaged.
    """
    try:
        table = root_table(memoryview(data), b"IOHE")
        return Header(end, table.number(0, "<i", 0), table.number(1, "<q", -1), _parse_streams(table.text(2)))
    except RecordingError as error:
        raise RecordingError(f"header: {error}") from error


def _parse_streams(text: str) -> dict[int, dict[str, str]]:
    """Stream id -> attributes, its own and those of its "info" node, from DV's tree of nodes and attributes."""
    if "<!" in text:
        raise RecordingError("description of streams: must be XML without declarations")
    try:
        root = ElementTree.fromstring(text)
        return {
            int(node.get("name", "")): {attr.get("key", ""): attr.text or "" for attr in node.iter("attr")}
            for node in root.findall("node[@name='outInfo']/node")
        }
    except (ElementTree.ParseError, ValueError) as error:
        what = shortened(str(error))
        raise RecordingError(f"description of streams: {what}: must be XML with numbered nodes under outInfo") from error


# The table of packets at the end of an AEDAT 4.0 file: used for seeking only; where it contradicts the packets, they count.
#
# For each packet it has the offset (after stream and length), stream, length, number of elements, and times. DV of 2020 left
# number and times zero. A zero says nothing; any other number that differs from the packet's is a disagreement, which the
# reader reports without believing the table.

_ENTRY_BYTES = 16  # minimum size of a packet's entry: its link in the list, a table, its offset in the file
# Field of a FileDataDefinition -> (index, bytes into it, type).
_FIELDS = {
    "at": (0, 0, "<i8"),
    "stream": (1, 0, "<i4"),
    "length": (1, 4, "<i4"),
    "count": (2, 0, "<i8"),
    "first_us": (3, 0, "<i8"),
    "last_us": (4, 0, "<i8"),
}


@dataclass(frozen=True)
class Spans:
    """What packets hold, (n,) each: their offsets, numbers of events, and times of the first and last (0 if empty)."""

    at: NDArray[np.int64]
    count: NDArray[np.int64]
    first_us: NDArray[np.int64]
    last_us: NDArray[np.int64]


@dataclass(frozen=True)
class Unlike:
    """Packets that differ from the table: their number, the offset of the first, and how that one differs."""

    count: int
    at: int
    how: str


NONE_UNLIKE = Unlike(0, 0, "")


@dataclass(frozen=True)
class PacketTable:
    """The table's columns, (n,) each, in order of `at`."""

    at: NDArray[np.int64]
    stream: NDArray[np.int64]
    length: NDArray[np.int64]
    count: NDArray[np.int64]
    first_us: NDArray[np.int64]
    last_us: NDArray[np.int64]

    def states(self, stream: int) -> bool:
        """Whether it has a number of events or a time for any of a stream's packets, if it has such packets."""
        of = self.stream == stream
        return not of.any() or bool((self.count[of] | self.first_us[of] | self.last_us[of]).any())

    def stream_at(self, at: int) -> int | None:
        """The stream of the packet at an offset; None if the table does not have it."""
        row = int(np.searchsorted(self.at, at))
        return int(self.stream[row]) if row < len(self.at) and self.at[row] == at else None

    def last_before(self, stream: int, from_us: int) -> tuple[int, int] | None:
        """(offset, length) of the last packet of a stream before the first that ends at `from_us` or later, among those whose
        times are stated; None without any."""
        rows = np.flatnonzero((self.stream == stream) & ((self.first_us != 0) | (self.last_us != 0)))
        reached = np.flatnonzero(self.last_us[rows] >= from_us)
        rows = rows[: reached[0]] if len(reached) else rows
        return (int(self.at[rows[-1]]), int(self.length[rows[-1]])) if len(rows) else None

    def unlike(self, spans: Spans) -> Unlike:
        """The packets that differ from what the table states of them."""
        rows = np.searchsorted(self.at, spans.at)
        missing = np.append(self.at, -1)[rows] != spans.at
        rows[missing] = 0
        count, first_us, last_us = (np.append(column, 0)[rows] for column in (self.count, self.first_us, self.last_us))
        says_times = (spans.count > 0) & ((first_us != 0) | (last_us != 0))
        wrong = missing | ((count != 0) & (count != spans.count))
        wrong |= says_times & ((first_us != spans.first_us) | (last_us != spans.last_us))
        if not wrong.any():
            return NONE_UNLIKE
        i = int(np.argmax(wrong))
        stated = "nothing" if missing[i] else _span(int(count[i]), int(first_us[i]), int(last_us[i]))
        found = _span(int(spans.count[i]), int(spans.first_us[i]), int(spans.last_us[i]))
        return Unlike(int(np.count_nonzero(wrong)), int(spans.at[i]), f"{found}, {stated} by the table")


def _span(count: int, first_us: int, last_us: int) -> str:
    return f"{count} events" + (f" from t = {first_us} to {last_us} us" if count else "")


def parse_table(content: bytes, packets_bytes: int, packet_bytes_min: int) -> PacketTable:
    """Parse the table, decompressed.

    Args:
        packets_bytes: size of all packets in the file.
        packet_bytes_min: size of the smallest packet, which bounds their number.

    Raises:
        RecordingError: it is damaged.
    """
    data = size_prefixed(content)
    at, count = root_table(data, b"FTAB").vector(0, 4)
    most = min(packets_bytes // packet_bytes_min, len(data) // _ENTRY_BYTES)
    if count > most:
        raise RecordingError(f"{count} entries: must be at most {most}, for so many bytes")
    columns = table_columns(data, (at, count), _FIELDS)
    order = np.argsort(columns["at"], kind="stable")
    return PacketTable(**{name: column[order] for name, column in columns.items()})
