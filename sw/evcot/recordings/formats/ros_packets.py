# SPDX-License-Identifier: Apache-2.0
"""Packets of event_camera_msgs, decoded one after the other as they come, from a bag or from a topic."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import njit
from ...errors import RecordingError
from ...events import Events
from .evt3 import evt3_layout
from .ros_messages import STAMPED_ENCODING, Packet
from .words import Decoder, advance, put_vector

__all__ = ["EVT3", "LOST", "MOST_EVENTS", "PacketDecoder", "State", "check_encoding", "fill"]


# The encoding `libcaer_cmp` of event_camera_msgs: how libcaer_driver packs the events of iniVation's cameras.
#
# 16-bit words, as in EVT 3.0 but with x and y exchanged: bits 15..12 are the type of a word. Each message starts anew, and
# counts microseconds from its own time base. A column of up to eight pixels with one polarity is a base and a mask; then the
# base is eight further down. The driver keeps 16 of the 24 bits of the time only, so the upper part wraps around after 15.
# https://github.com/ros-event-camera/event_camera_codecs (libcaer_cmp_types.h, libcaer_cmp_decoder.h)

TIME_HIGH = 0  # 11..0: bits 23..12 of the time
TIME_LOW = 1  # 11..0: bits 11..0 of the time
X = 2  # 10..0: column of the events that follow
Y = 3  # 11: polarity, 10..0: one event
BASE_Y = 4  # 11: polarity, 10..0: where the next vector starts
VECTOR_8 = 5  # 7..0: one event per set bit, from the base down
MOST_EVENTS = 8  # per word

_LOW_BITS = 12
_DRIVER_MARKS, _MARKS = 1 << 4, 1 << 12  # range of the upper part of the time: as the driver writes it, as it is defined
_FAR = 1 << 15  # upper limit of the base, outside every sensor that these words can address


class State(NamedTuple):
    """State of the decoder in a message; `column` and `base` are -1 until a word sets them. high: unwrapped."""

    base_us: int
    high: int = 0
    low: int = 0
    column: int = -1
    base: int = -1
    polarity: int = 0
    unplaced: int = 0
    strange: int = 0


LOST = {"they precede any address": "unplaced", "words of a type that libcaer_cmp does not define": "strange"}


@njit(cache=True, nogil=True)
def fill(words, state, t_us, x, y, p):  # type: ignore[no-untyped-def]
    """Decode words until they end or the columns are nearly full: (words used, events decoded, state)."""
    base_us, high, low, column, base, polarity, unplaced, strange = state
    time_us = base_us + (high << _LOW_BITS | low)
    n = np.int64(0)
    used = 0
    while used < len(words) and n + MOST_EVENTS <= len(t_us):
        word = np.int64(words[used])
        used += 1
        kind = word >> 12
        if kind == Y:
            t_us[n] = time_us
            x[n] = column
            y[n] = word & 2047
            p[n] = word >> 11 & 1
            n += column >= 0
            unplaced += column < 0
        elif kind == X:
            column = word & 2047
        elif kind == TIME_LOW:
            low = word & 4095
            time_us = base_us + (high << _LOW_BITS | low)
        elif kind == BASE_Y:
            base, polarity = word & 2047, word >> 11 & 1
        elif kind == VECTOR_8:
            start = n
            n = put_vector(n, word & 255, time_us, base, column, polarity, t_us, y, x, p)
            if (column < 0) | (base < 0):
                unplaced += n - start
                n = start
            base = min(base + 8, _FAR) if base >= 0 else base
        elif kind == TIME_HIGH:
            mark = word & 4095
            high = advance(high, mark, _DRIVER_MARKS if mark < _DRIVER_MARKS else _MARKS)
            time_us = base_us + (high << _LOW_BITS | low)
        else:
            strange += 1
    return used, n, State(base_us, high, low, column, base, polarity, unplaced, strange)


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
        layout = evt3_layout(0)
        self._evt3 = Decoder(layout.fill, layout.most_events, layout.start, layout.lost)

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
        yield from self._evt3.feed(words)
        self.left_out = self._evt3.left_out

    def _libcaer_cmp(self, packet: Packet) -> Iterator[Events]:
        decoder = Decoder(fill, MOST_EVENTS, State(packet.time_base_ns // 1000), LOST)
        yield from decoder.feed(packet.words("u2"))
        self.left_out += decoder.left_out


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
