# SPDX-License-Identifier: Apache-2.0
"""ROS bags: reads the first topic that has events."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from ...errors import RecordingError
from ...events import Events
from .blocks import batches, gathered, in_order
from .printable import printable
from .ros_messages import PACKETS, STAMPED, STAMPED_ENCODING, Packet, Stamped, events_of, read_packet, read_stamped
from .ros_packets import EVT3, PacketDecoder, check_encoding
from .rosbag1 import MAGIC, Bag1
from .rosbag2 import MCAP_MAGIC, METADATA, SQLITE_MAGIC, Bag2
from .source import BLOCK_EVENTS, AnySensor, Format, Sensor

__all__ = ["FORMATS", "RosBag"]


class Bag(Protocol):
    """Common interface of ROS 1 and ROS 2 bags."""

    is_cdr: bool
    topics: dict[str, str]
    remarks: list[str]

    def messages(self, topic: str) -> Iterator[memoryview]: ...

    def close(self) -> None: ...


class RosBag(AnySensor):
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
        elif self._encoding == EVT3:
            yield from self._evt3_blocks()
        else:
            decoder = PacketDecoder(self._encoding)
            self.left_out = decoder.left_out
            packets = self._messages(self._topic, read_packet)
            yield from gathered(part for packet in packets for part in decoder.decode(packet))

    @property
    def remarks(self) -> Sequence[str]:
        """See `source.Source`."""
        return self._bag.remarks

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
                    check_encoding(message.encoding)
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
        decoder = PacketDecoder(EVT3)
        packets = (packet.words("u2") for packet in self._messages(self._topic, read_packet))
        for batch in batches(packets, BLOCK_EVENTS, len):
            yield from decoder.evt3(np.concatenate([np.empty(0, "u2"), *batch]))
            self.left_out = decoder.left_out


def _is_bag2(start: bytes, path: Path) -> bool:
    return start.startswith((MCAP_MAGIC, SQLITE_MAGIC)) or (not start and (path / METADATA).is_file())


FORMATS = (
    Format("rosbag1", "ROS bag", lambda start, _: start.startswith(MAGIC), lambda path: RosBag(Bag1(path))),
    Format("rosbag2", "ROS 2 bag", _is_bag2, lambda path: RosBag(Bag2(path))),
)
