# SPDX-License-Identifier: Apache-2.0
"""Packets of event_camera_msgs, decoded one after the other as they come, from a bag or from a topic."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from ...errors import RecordingError
from ...events import Events
from .evt3 import evt3_layout
from .libcaer_cmp import LOST, MOST_EVENTS, State, fill
from .ros_messages import STAMPED_ENCODING, Packet
from .source import BLOCK_EVENTS

__all__ = ["EVT3", "PacketDecoder", "check_encoding"]

EVT3 = "evt3"
_LIBCAER_CMP = "libcaer_cmp"


class PacketDecoder:
    """Decodes the packets of one topic, in order: EVT 3.0 goes on from packet to packet.

    Args:
        encoding: that of all its packets.

    Attributes:
        left_out: reason -> number of events left out so far.

    Raises:
        RecordingError: an unknown encoding.
    """

    def __init__(self, encoding: str) -> None:
        check_encoding(encoding)
        self.left_out: Counter[str] = Counter()
        self._encoding = encoding
        self._layout = evt3_layout(0)
        self._state = self._layout.start

    def decode(self, packet: Packet) -> Iterator[Events]:
        """The events of a packet, in parts of bounded size: a word may be many events.

        Raises:
            RecordingError: the packet ends within a word.
        """
        if self._encoding == EVT3:
            yield from self.evt3(packet.words("u2"))
        elif self._encoding == _LIBCAER_CMP:
            yield from self._libcaer_cmp(packet)
        else:
            yield _DECODERS[self._encoding](packet)

    def evt3(self, words: NDArray[np.uint16]) -> Iterator[Events]:
        """The events of the next words of EVT 3.0."""
        while len(words):
            room = min(len(words) * self._layout.most_events, BLOCK_EVENTS) + self._layout.most_events
            t_us, x = np.empty(room, np.int64), np.empty(room, np.uint16)
            y, p = np.empty(room, np.uint16), np.empty(room, np.uint8)
            used, count, self._state = self._layout.fill(words, self._state, t_us, x, y, p)
            words = words[used:]
            if count:
                yield Events(t_us[:count], x[:count], y[:count], p[:count])
        self.left_out = Counter({why: getattr(self._state, field) for why, field in self._layout.lost.items()})

    def _libcaer_cmp(self, packet: Packet) -> Iterator[Events]:
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


def check_encoding(encoding: str) -> None:
    """Raise RecordingError for an encoding that nobody here decodes."""
    known = (EVT3, _LIBCAER_CMP, *_DECODERS)
    if encoding not in (STAMPED_ENCODING, *known):
        raise RecordingError(f"encoding {encoding!r}: must be one of {', '.join(known)}")


_DECODERS: Mapping[str, Callable[[Packet], Events]] = {"mono": _decode_mono, "libcaer": _decode_libcaer}
