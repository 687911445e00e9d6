# SPDX-License-Identifier: Apache-2.0
"""AEDAT 4.0 writer: one stream of events in LZ4 packets, and the table of packets. The layout is described in `aedat4`.

The FlatBuffers are laid out by hand, since each kind has only one shape. Alignment counts from the length prefix, as in
FlatBuffers' own builder.
"""

from __future__ import annotations

import struct
from typing import BinaryIO

import lz4.frame
import numpy as np

from ...errors import RecordingError
from ...events import Events
from .aedat4 import EVENT, MAGIC, PACKET_HEAD
from .flatbuffers import vector_head
from .source import Sensor, WritableFormat

__all__ = ["WRITABLE", "Aedat4Sink"]

# About 10 ms of a busy camera: small enough for seeking to a time, large enough to compress well.
PACKET_EVENTS = 1 << 14

_STREAM = 0
_LZ4 = 1
_ADDRESS_MAX = (1 << 15) - 1
# Root offset, schema, padding, vtable of three fields; then the table: offset back to its vtable, compression, offset of the
# text, offset of the packet table; then the text's length.
_HEADER = struct.Struct("<I4s6x5HiiIqI")
_TABLE_PLACE_AT = 36
# A FileDataDefinition, and the vtable that all of them share.
_ENTRY = np.dtype(
    [("back", "<i4"), ("pad", "<i4"), ("at", "<i8"), ("stream", "<i4"), ("length", "<i4")]
    + [(name, "<i8") for name in ("count", "first_us", "last_us")]
)
_ENTRY_FIELDS = struct.pack("<7H2x", 14, _ENTRY.itemsize, 8, 16, 24, 32, 40)

_STREAMS = """<dv version="2.0">
    <node name="outInfo" path="/mainloop/Recorder/outInfo/">
        <node name="{stream}" path="/mainloop/Recorder/outInfo/{stream}/">
            <attr key="compression" type="string">LZ4</attr>
            <attr key="originalModuleName" type="string">evcot</attr>
            <attr key="originalOutputName" type="string">events</attr>
            <attr key="typeDescription" type="string">Array of events (polarity ON/OFF).</attr>
            <attr key="typeIdentifier" type="string">EVTS</attr>
            <node name="info" path="/mainloop/Recorder/outInfo/{stream}/info/">
                <attr key="sizeX" type="int">{width}</attr>
                <attr key="sizeY" type="int">{height}</attr>
                <attr key="source" type="string">evcot</attr>
                <attr key="tsOffset" type="long">0</attr>
            </node>
        </node>
    </node>
</dv>
"""


class Aedat4Sink:
    """An AEDAT4 file being written. See `source.Sink`.

    Args:
        file: must be seekable: the table's offset is written into the header last.
    """

    def __init__(self, file: BinaryIO, sensor: Sensor) -> None:
        self._file = file
        self._waiting = Events.empty()
        self._count = 0
        self._entries: list[tuple[int, ...]] = []
        text = _STREAMS.format(stream=_STREAM, width=sensor[0], height=sensor[1]).encode()
        header = _HEADER.pack(24, b"IOHE", 10, 20, 4, 12, 8, 10, _LZ4, 12, -1, len(text)) + text + b"\0"
        header += bytes(-(len(header) + 4) % 8)
        file.write(MAGIC + struct.pack("<I", len(header)))
        self._table_place_at = file.tell() + _TABLE_PLACE_AT
        file.write(header)

    def write(self, events: Events) -> None:
        """See `source.Sink`."""
        for axis, values in (("x", events.x), ("y", events.y)):
            outside = np.flatnonzero(values > _ADDRESS_MAX)
            if len(outside):
                i = int(outside[0])
                raise RecordingError(f"event {self._count + i}: {axis} = {values[i]}: must be at most {_ADDRESS_MAX} in AEDAT4")
        self._count += len(events)
        waiting = Events.joined([self._waiting, events])
        whole = len(waiting) // PACKET_EVENTS * PACKET_EVENTS
        for begin in range(0, whole, PACKET_EVENTS):
            self._write_packet(waiting[begin : begin + PACKET_EVENTS])
        self._waiting = waiting[whole:]

    def flush(self) -> None:
        """Write the pending events as a packet, even if it is not full."""
        if len(self._waiting):
            self._write_packet(self._waiting)
        self._waiting = Events.empty()

    def close(self) -> None:
        """See `source.Sink`."""
        self.flush()
        table_at = self._file.tell()
        self._file.write(_packed(self._table()))
        self._file.seek(self._table_place_at)
        self._file.write(struct.pack("<q", table_at))
        self._file.seek(0, 2)

    def _write_packet(self, events: Events) -> None:
        elements = np.zeros(len(events), EVENT)
        elements["t"], elements["x"], elements["y"], elements["on"] = events.t_us, events.x, events.y, events.p
        packed = _packed(vector_head(b"EVTS") + struct.pack("<I", len(events)) + elements.tobytes())
        self._file.write(PACKET_HEAD.pack(_STREAM, len(packed)))
        self._entries.append((self._file.tell(), _STREAM, len(packed), len(events), int(events.t_us[0]), int(events.t_us[-1])))
        self._file.write(packed)

    def _table(self) -> bytes:
        """A FileDataTable: offsets of the entries, the vtable that they share, the entries."""
        count = len(self._entries)
        head = vector_head(b"FTAB") + struct.pack("<I", count)
        links_at = len(head)
        padding = -(4 + links_at + 4 * count) % 8
        fields_at = links_at + 4 * count + padding
        entries_at = fields_at + len(_ENTRY_FIELDS)
        entries = np.array([(0, 0, *entry) for entry in self._entries], _ENTRY)
        places = entries_at + _ENTRY.itemsize * np.arange(count)
        entries["back"] = places - fields_at
        links = (places - (links_at + 4 * np.arange(count))).astype("<u4")
        return head + links.tobytes() + bytes(padding) + _ENTRY_FIELDS + entries.tobytes()


def _packed(data: bytes) -> bytes:
    packed: bytes = lz4.frame.compress(struct.pack("<I", len(data)) + data, content_checksum=True, store_size=False)
    return packed


WRITABLE = (WritableFormat("aedat4", "AEDAT 4.0", ".aedat4", Aedat4Sink),)
