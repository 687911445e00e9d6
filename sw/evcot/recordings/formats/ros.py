# SPDX-License-Identifier: Apache-2.0
"""ROS bags: reads the first topic that has events."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ...errors import RecordingError
from ...events import Events
from .ahead import in_order
from .evt3 import evt3_layout
from .gather import batches, gathered
from .libcaer_cmp import LOST, MOST_EVENTS, State, fill
from .printable import printable
from .ros_messages import PACKETS, STAMPED, STAMPED_ENCODING, Packet, Stamped, events_of, read_packet, read_stamped
from .rosbag1 import MAGIC, Bag1
from .rosbag2 import MCAP_MAGIC, METADATA, SQLITE_MAGIC, Bag2
from .source import BLOCK_EVENTS, Format, Sensor

__all__ = ["FORMATS", "RosBag"]


class Bag(Protocol):
    """Common interface of ROS 1 and ROS 2 bags."""

    is_cdr: bool
    topics: dict[str, str]
    remarks: list[str]

    def messages(self, topic: str) -> Iterator[memoryview]: ...

    def close(self) -> None: ...


class RosBag:
    """A bag as a `source.Source`."""

    def __init__(self, bag: Bag) -> None:
        self._bag = bag
        self.left_out: Counter[str] = Counter()
        try:
            self._topic, first = self._choose()
        except BaseException:
            bag.close()
            raise
        self.sensor: Sensor | None = first.sensor if all(first.sensor) else None
        self._encoding = first.encoding
        others = [topic for topic in self._event_topics() if topic != self._topic]
        self.details: Mapping[str, str] = (
            {"topic": printable(self._topic)}
            | ({"encoding": self._encoding} if self._encoding != STAMPED_ENCODING else {})
            | ({"also holds": printable(", ".join(others))} if others else {})
        )

    def blocks(self, from_us: int | None = None) -> Iterator[Events]:
        """See `source.Source`. Messages of stamped events that end before `from_us` are skipped; other encodings are not: their
        times are known only once everything before has been decoded."""
        self.left_out = Counter()
        if self._encoding == STAMPED_ENCODING:
            yield from self._stamped_blocks(from_us)
        elif self._encoding == _EVT3:
            yield from self._evt3_blocks()
        else:
            packets = self._messages(self._topic, read_packet)
            if self._encoding == _LIBCAER_CMP:
                yield from gathered(part for packet in packets for part in self._decode_libcaer_cmp(packet))
            else:
                yield from gathered(map(_DECODERS[self._encoding], packets))

    @property
    def remarks(self) -> Sequence[str]:
        """See `source.Source`."""
        return self._bag.remarks

    def smallest_sensor(self, width: int, height: int) -> Sensor:
        """See `source.Source`."""
        return width, height

    def close(self) -> None:
        """Close the bag."""
        self._bag.close()

    def _event_topics(self) -> list[str]:
        return [topic for topic, kind in self._bag.topics.items() if kind in STAMPED + PACKETS]

    def _choose(self) -> tuple[str, Stamped | Packet]:
        """The first topic with events, and its first message with any."""
        topics = self._event_topics()
        if not topics:
            held = ", ".join(sorted(set(self._bag.topics.values()))[:8]) or "nothing"
            raise RecordingError(f"has no topic of events ({', '.join(STAMPED + PACKETS)}): holds {held}")
        for topic in topics:
            read = read_stamped if self._bag.topics[topic] in STAMPED else read_packet
            for message in self._messages(topic, read):
                if len(message):
                    return topic, message
        raise RecordingError(f"holds no events in {printable(', '.join(topics))}")

    def _messages(self, topic: str, read: Callable[[memoryview, bool], Any]) -> Iterator[Any]:
        """A topic's messages, parsed; all messages with events must have the same sensor and encoding."""
        first = None
        for number, data in enumerate(self._bag.messages(topic)):
            try:
                message = read(data, self._bag.is_cdr)
                kind = message.sensor, message.encoding
                if first is None and len(message):
                    first = kind
                    _check_encoding(message.encoding)
                if len(message) and kind != first:
                    raise RecordingError(f"sensor and encoding are {kind}: must be {first}, as before")
            except RecordingError as error:
                raise RecordingError(f"topic {printable(topic)}, message {number}: {error}") from error
            yield message

    def _stamped_blocks(self, from_us: int | None) -> Iterator[Events]:
        messages = self._messages(self._topic, read_stamped)
        late = (each for each in messages if len(each) and (from_us is None or each.last_us >= from_us))
        for events, fault in in_order(events_of, batches(late, BLOCK_EVENTS, len)):
            yield events
            if fault is not None:
                raise RecordingError(fault)

    def _evt3_blocks(self) -> Iterator[Events]:
        """Decode the packets as the continuous stream from which they were cut."""
        layout = evt3_layout(0)
        state = layout.start
        packets = (packet.words("u2") for packet in self._messages(self._topic, read_packet))
        for batch in batches(packets, BLOCK_EVENTS, len):
            words = np.concatenate([np.empty(0, "u2"), *batch])
            while len(words):
                room = min(len(words) * layout.most_events, BLOCK_EVENTS) + layout.most_events
                t_us, x = np.empty(room, np.int64), np.empty(room, np.uint16)
                y, p = np.empty(room, np.uint16), np.empty(room, np.uint8)
                used, count, state = layout.fill(words, state, t_us, x, y, p)
                words = words[used:]
                if count:
                    yield Events(t_us[:count], x[:count], y[:count], p[:count])
            self.left_out = Counter({why: getattr(state, field) for why, field in layout.lost.items()})

    def _decode_libcaer_cmp(self, packet: Packet) -> Iterator[Events]:
        """The events of a packet, in parts of bounded size: a word may be eight events."""
        words = packet.words("u2")
        state = State(packet.time_base_ns // 1000)
        while len(words):
            events = Events.allocated(min(len(words) * MOST_EVENTS, BLOCK_EVENTS) + MOST_EVENTS)
            used, count, state = fill(words, state, events.t_us, events.x, events.y, events.p)
            words = words[used:]
            yield events[:count]
        self.left_out.update({why: lost for why, field in LOST.items() if (lost := getattr(state, field))})


def _decode_mono(packet: Packet) -> Events:
    """64-bit words: polarity 63, y 62..48, x 47..32, nanoseconds since the time base 31..0."""
    words = packet.words("u8")
    return Events(
        t_us=_after(packet.time_base_ns, (words & np.uint64(0xFFFFFFFF)).astype(np.int64)),
        x=(words >> np.uint64(32)).astype(np.uint16),
        y=(words >> np.uint64(48)).astype(np.uint16) & np.uint16(0x7FFF),
        p=(words >> np.uint64(63)).astype(np.uint8),
    )


def _decode_libcaer(packet: Packet) -> Events:
    """Pairs of 32-bit words: x 31..17, y 16..2, polarity 1; and 31 bits of microseconds since the time base."""
    words = packet.words("u4")
    if len(words) % 2:
        raise RecordingError(f"a packet of {len(words)} words: must be even")
    data, since_us = words[::2], words[1::2].astype(np.int64)
    turns = np.cumsum(np.diff(since_us, prepend=since_us[:1]) < 0)  # where the 31 bits wrap around
    return Events(
        t_us=_after(packet.time_base_ns, (since_us + (turns << 31)) * 1000),
        x=(data >> np.uint32(17)).astype(np.uint16),
        y=(data >> np.uint32(2) & np.uint32(0x7FFF)).astype(np.uint16),
        p=(data >> np.uint32(1) & np.uint32(1)).astype(np.uint8),
    )


def _after(base_ns: int, since_ns: NDArray[np.int64]) -> NDArray[np.int64]:
    """The sum of both in microseconds, rounded down, without overflow."""
    base_us, rest_ns = divmod(base_ns, 1000)
    return base_us + (since_ns + rest_ns) // 1000


def _check_encoding(encoding: str) -> None:
    known = (_EVT3, _LIBCAER_CMP, *_DECODERS)
    if encoding not in (STAMPED_ENCODING, *known):
        raise RecordingError(f"encoding {encoding!r}: must be one of {', '.join(known)}")


_EVT3 = "evt3"
_LIBCAER_CMP = "libcaer_cmp"
_DECODERS: Mapping[str, Callable[[Packet], Events]] = {"mono": _decode_mono, "libcaer": _decode_libcaer}


def _is_bag2(start: bytes, path: Path) -> bool:
    return start.startswith((MCAP_MAGIC, SQLITE_MAGIC)) or (not start and (path / METADATA).is_file())


FORMATS = (
    Format("rosbag1", "ROS bag", lambda start, _: start.startswith(MAGIC), lambda path: RosBag(Bag1(path))),
    Format("rosbag2", "ROS 2 bag", _is_bag2, lambda path: RosBag(Bag2(path))),
)
