# SPDX-License-Identifier: Apache-2.0
"""The header of AEDAT 4.0, the same in files and over a network. The layout is described in `aedat4`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from xml.etree import ElementTree

from ...errors import RecordingError
from .flatbuffers import root_table
from .packing import Lz4Unpacker, PlainUnpacker, Unpacker, ZstdUnpacker
from .printable import shortened, whole_number
from .source import Sensor

__all__ = ["HEADER_BYTES_MAX", "Header", "parse_header", "type_of"]

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
