# SPDX-License-Identifier: Apache-2.0
"""AEDAT 4.0 over TCP, as DV and dv-processing's NetworkWriter send it.

Layout, as sent by dv-processing 2.0: the file's header, prefixed by its length, without the version line (which is skipped
if present), then packets as in a file for as long as the connection lasts, without a packet table.
"""

from __future__ import annotations

import socket
from collections.abc import Callable, Iterator

from ...errors import RecordingError
from ...events import Events
from .aedat4 import MAGIC, PACKET_HEAD, events_of
from .aedat4_metadata import HEADER_BYTES_MAX, Header, parse_header
from .source import Sensor

__all__ = ["Aedat4Stream"]

_ANSWER_S = 5.0  # timeout for the connection and for the header
_LOOK_S = 0.1  # polling interval of `wanted` while nothing is received
_PACKET_BYTES_MAX = 1 << 27  # compressed or not: 8 million events of 16 bytes, seconds of the fastest camera
_PIECE_BYTES = 1 << 18


class Aedat4Stream:
    """The first stream of events that a server sends. Use as a context manager.

    Args:
        host, port: address of the server.

    Attributes:
        sensor: (width, height) in pixels as stated by the server; None if not stated.
        name: the server's name for the camera.

    Raises:
        RecordingError: the connection fails, or the data are not AEDAT 4.0; names place, value and rule, not the server's
            address.
    """

    def __init__(self, host: str, port: int) -> None:
        self._at = 0  # bytes of the stream consumed so far
        self._got = bytearray()
        try:
            self._socket = socket.create_connection((host, port), timeout=_ANSWER_S)
        except OSError as error:
            raise RecordingError(f"cannot be reached: {error.strerror or error}") from error
        try:
            header = self._read_header()
            self._stream = header.first_of_events
            self.sensor: Sensor | None = header.sensor(self._stream)
            self._unpacker = header.new_unpacker()
        except BaseException:
            self.close()
            raise
        self._known = frozenset(header.streams)
        self.name = header.streams[self._stream].get("source", "camera")
        self._socket.settimeout(_LOOK_S)

    def __enter__(self) -> Aedat4Stream:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()

    def packets(self, wanted: Callable[[], bool] = lambda: True) -> Iterator[Events]:
        """Events as they arrive, one packet at a time, until the server closes the connection.

        Args:
            wanted: polled about ten times a second; no more packets are returned once it is false.

        Raises:
            RecordingError: a packet is damaged, or the connection breaks within one.
        """
        while True:
            at = self._at
            head = self._take(PACKET_HEAD.size, wanted)
            if head is None:
                break
            stream, length = PACKET_HEAD.unpack(head)
            if stream not in self._known or not 0 <= length <= _PACKET_BYTES_MAX:
                rule = f"must be one of {sorted(self._known)} and at most {_PACKET_BYTES_MAX}"
                raise RecordingError(f"byte {at}: packet of stream {stream}, {length} bytes: {rule}")
            data = self._take(length, wanted)
            if data is None:
                break
            if stream == self._stream:
                try:
                    yield events_of(self._unpacker.whole(data, _PACKET_BYTES_MAX))
                except RecordingError as error:
                    raise RecordingError(f"packet at byte {at}: {error}") from error
        if self._end > at and wanted():
            raise RecordingError(f"ends within a packet, at byte {self._end}")

    def _read_header(self) -> Header:
        try:
            first = self._take_all(4)
            if first == MAGIC[:4]:
                self._take_all(len(MAGIC) - 4)
                first = self._take_all(4)
            length = int.from_bytes(first, "little")
            if length > HEADER_BYTES_MAX:
                raise RecordingError(f"header of {length} bytes: must be at most {HEADER_BYTES_MAX}; is it AEDAT4?")
            return parse_header(self._take_all(length), self._at)
        except TimeoutError as error:
            raise RecordingError(f"sends no header within {_ANSWER_S:g} s") from error

    def _take_all(self, count: int) -> bytes:
        """The next `count` bytes of the header; only here is a timeout an error."""
        data = self._take(count, None)
        if data is None:
            raise RecordingError(f"ends within its header, at byte {self._end}")
        return data

    def _take(self, count: int, wanted: Callable[[], bool] | None) -> bytes | None:
        """The next `count` bytes of the stream; None when it ends or `wanted` turns false."""
        while len(self._got) < count:
            try:
                piece = self._socket.recv(_PIECE_BYTES)
            except TimeoutError:
                if wanted is None:
                    raise
                piece = None
            except OSError as error:
                raise RecordingError(f"byte {self._end}: connection broke: {error.strerror or error}") from error
            if piece == b"" or (wanted is not None and not wanted()):
                return None
            self._got += piece or b""
        data = bytes(memoryview(self._got)[:count])
        del self._got[:count]
        self._at += count
        return data

    @property
    def _end(self) -> int:
        """Number of bytes received."""
        return self._at + len(self._got)
