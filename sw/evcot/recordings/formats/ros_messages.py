# SPDX-License-Identifier: Apache-2.0
"""ROS messages with events, parsed from their bytes without creating an object per event.

Two kinds: arrays of stamped events (dvs_msgs/EventArray, prophesee_event_msgs/EventArray) and packets in a camera's own
encoding (event_camera_msgs/EventPacket, event_array_msgs/EventArray). ROS 1 packs fields without gaps; ROS 2 (CDR) aligns each
number to a multiple of its size, counted from after the four bytes that name the encoding.
https://github.com/uzh-rpg/rpg_dvs_ros, https://github.com/ros-event-camera/event_camera_msgs
"""

from __future__ import annotations

from dataclasses import dataclass
from struct import Struct
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import njit
from ...errors import RecordingError
from ...events import Events
from .source import Sensor

__all__ = ["PACKETS", "STAMPED", "STAMPED_ENCODING", "Packet", "Stamped", "events_of", "read_packet", "read_stamped"]

STAMPED = ("dvs_msgs/EventArray", "prophesee_event_msgs/EventArray")
PACKETS = ("event_camera_msgs/EventPacket", "event_array_msgs/EventArray")

STAMPED_ENCODING = "stamped"

_NS = 1_000_000_000
_LITTLE_ENDIAN_CDR = 1
_POINT = Struct("<HH")
_NAMES = ["x", "y", "seconds", "nanoseconds", "p"]
_ROS1_EVENT = np.dtype({"names": _NAMES, "formats": ["<u2", "<u2", "<u4", "<u4", "u1"]})
# In CDR, an event ends at an odd byte. The next event's x is at the next even byte, two before the multiple of 16 at which its
# y is. Only the first event has no such gap before its x, so its x and y are stored two bytes later.
_CDR_EVENT = np.dtype({"names": _NAMES, "formats": ["<u2", "<u2", "<i4", "<u4", "u1"], "offsets": [0, 2, 6, 10, 14]})
_CDR_STEP, _CDR_EARLY = 16, 2


class _Fields:
    """Sequential reader of a message's fields."""

    def __init__(self, data: memoryview, is_cdr: bool) -> None:
        self.data, self.is_cdr = data, is_cdr
        self.at = 4 if is_cdr else 0
        if is_cdr and (len(data) < 4 or data[1] != _LITTLE_ENDIAN_CDR):
            raise RecordingError(f"is encoded as {bytes(data[:4]).hex()}: must be little-endian CDR, 0001")

    def number(self, size: int) -> int:
        """An unsigned integer of `size` bytes."""
        if self.is_cdr:
            self.at += -(self.at - 4) % size
        return int.from_bytes(self.take(size), "little")

    def text(self) -> str:
        """A string."""
        return bytes(self.take(self.number(4))).rstrip(b"\0").decode("latin-1")

    def take(self, count: int) -> memoryview:
        """The next bytes."""
        if self.at + count > len(self.data):
            raise RecordingError(f"of {len(self.data)} bytes has a field that needs {self.at + count}; is it cut off?")
        self.at += count
        return self.data[self.at - count : self.at]

    def sensor(self) -> Sensor:
        """(width, height), after skipping the header with which every such message starts."""
        if not self.is_cdr:
            self.number(4)  # a sequence number
        self.number(4), self.number(4), self.text()  # time stamp and frame id
        height, width = self.number(4), self.number(4)
        return width, height

    def end(self) -> None:
        """Raise unless the message ends here, apart from CDR padding."""
        left = len(self.data) - self.at
        if left > (3 if self.is_cdr else 0):
            raise RecordingError(f"of {len(self.data)} bytes ends {left} bytes early: is it another version of this message?")


@dataclass(frozen=True)
class Stamped:
    """A message of stamped events.

    Attributes:
        sensor: (width, height) in pixels.
        rows: (n,) view into its bytes, with the fields x, y, seconds, nanoseconds, p.
        first: x and y of the first event, if its layout differs from that of the others.
    """

    sensor: Sensor
    rows: NDArray[np.void]
    first: tuple[int, int] | None

    encoding: ClassVar[str] = STAMPED_ENCODING

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def last_us(self) -> int:
        """Time of the last event, in microseconds; the message must not be empty."""
        last = self.rows[-1]
        return int(last["seconds"]) * 1_000_000 + int(last["nanoseconds"]) // 1000


def read_stamped(data: bytes | memoryview, is_cdr: bool) -> Stamped:
    """Parse a message of a type in `STAMPED`.

    Raises:
        RecordingError: its length does not match its fields.
    """
    fields = _Fields(memoryview(data), is_cdr)
    sensor = fields.sensor()
    count = fields.number(4)
    start = fields.at
    dtype, step, early = (_CDR_EVENT, _CDR_STEP, _CDR_EARLY) if is_cdr else (_ROS1_EVENT, _ROS1_EVENT.itemsize, 0)
    fields.take(step * (count - 1) + dtype.itemsize - early if count else 0)
    fields.end()
    if not count:
        return Stamped(sensor, np.empty(0, dtype), None)
    rows: NDArray[np.void] = np.ndarray((count,), dtype, data, start - early, (step,))
    return Stamped(sensor, rows, _POINT.unpack_from(data, start) if is_cdr else None)


@njit(cache=True, nogil=True)
def _fill(rows, at, t_us, x, y, p):  # type: ignore[no-untyped-def]
    """Decode one message into the columns from `at` on; returns the index of the first invalid time, or the event count."""
    for i in range(len(rows)):
        row = rows[i]
        if row.nanoseconds >= _NS:
            return i
        t_us[at + i] = np.int64(row.seconds) * 1_000_000 + np.int64(row.nanoseconds // np.uint32(1000))
        x[at + i] = row.x
        y[at + i] = row.y
        p[at + i] = row.p
    return len(rows)


def events_of(messages: list[Stamped]) -> tuple[Events, str | None]:
    """The events of consecutive messages, up to the first with an invalid time; and the error message for that one.

    Nanoseconds are rounded down to microseconds.
    """
    events = Events.allocated(sum(map(len, messages)))
    at = 0
    for each in messages:
        filled = _fill(each.rows, at, events.t_us, events.x, events.y, events.p)
        if filled and each.first is not None:
            events.x[at], events.y[at] = each.first
        at += filled
        if filled < len(each):
            value = each.rows[filled]["nanoseconds"]
            return events[:at], f"event {filled} of its message: nanoseconds = {value}: must be below 10^9"
    return events, None


@dataclass(frozen=True)
class Packet:
    """A message in a camera's own encoding.

    Attributes:
        sensor: (width, height) in pixels.
        encoding: name of the encoding.
        order: byte order in a word, "<" or ">".
        time_base_ns: time from which some encodings count.
        payload: the encoded events.
    """

    sensor: Sensor
    encoding: str
    order: str
    time_base_ns: int
    payload: memoryview

    def __len__(self) -> int:
        return len(self.payload)

    def words(self, dtype: str) -> NDArray[Any]:
        """The payload as words of an unsigned dtype, in native byte order.

        Raises:
            RecordingError: the payload ends within a word.
        """
        kind = np.dtype(self.order + dtype)
        if len(self.payload) % kind.itemsize:
            raise RecordingError(f"has {len(self.payload)} bytes of events: must be a multiple of {kind.itemsize}")
        words: NDArray[Any] = np.frombuffer(self.payload, kind)
        return words if kind.isnative else words.astype(kind.newbyteorder("="))


def read_packet(data: bytes | memoryview, is_cdr: bool) -> Packet:
    """Parse a message of a type in `PACKETS`.

    Raises:
        RecordingError: its length does not match its fields.
    """
    fields = _Fields(memoryview(data), is_cdr)
    sensor = fields.sensor()
    fields.number(8)  # a sequence number
    time_base_ns, encoding, is_big_endian = fields.number(8), fields.text(), fields.number(1)
    payload = fields.take(fields.number(4))
    fields.end()
    return Packet(sensor, encoding, ">" if is_big_endian else "<", time_base_ns, payload)
