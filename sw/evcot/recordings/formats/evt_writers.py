# SPDX-License-Identifier: Apache-2.0
"""EVT 2.0 and EVT 3.0 writers: every event is read back with the same time, x, y and p, in the same order.

An offset of times that the words cannot hold, such as microseconds since 1970, goes into the header's `t0`, which readers add
to the times of the words.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, BinaryIO, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import njit
from ...errors import RecordingError
from ...events import Events
from . import evt2, evt3
from .prophesee_header import T0_LIMIT_US
from .source import Sensor

__all__ = ["Evt2Sink", "Evt3Sink"]

_ADDRESSES = 2048

_EVT2_RANGE_US = evt2.MARK_RANGE << evt2.LOW_BITS
_EVT3_RANGE_US = evt3.MARK_RANGE << evt3.LOW_BITS

# A pause is written as marks that rise by less than half their range, so that a reader sees every wrap-around; one per 8.4 s.
# No pause may be longer than this many microseconds, 203 days: 4 MiB of marks.
_LONGEST_SILENCE_US = 1 << 44

_WORDS = 1 << 18  # written at a time
_ROOM = 8  # maximum words per event, with all state words that it needs
_VECTOR_WORDS = 4  # base, 12, 12 and 8 pixels: as sent by cameras, and the only order that some decoders support


@njit(cache=True, nogil=True)
def _encode_evt2(t_us, x, y, p, at, high, low, row, words):  # type: ignore[no-untyped-def]
    """Encode from event `at` on, with times as in the words; returns (events done, words written, high, low, row)."""
    n = 0
    while at < len(t_us) and n + _ROOM <= len(words):
        mark = t_us[at] >> evt2.LOW_BITS
        if mark != high:
            words[n] = evt2.TIME_HIGH << 28 | mark
            high = mark
            n += 1
        words[n] = np.int64(p[at]) << 28 | (t_us[at] & 63) << 22 | np.int64(x[at]) << 11 | np.int64(y[at])
        n += 1
        at += 1
    return at, n, high, low, row


@njit(cache=True, nogil=True)
def _encode_evt3(t_us, x, y, p, at, high, low, row, words):  # type: ignore[no-untyped-def]
    """As `_encode_evt2`; events of one time, row and polarity with increasing x within 32 aligned pixels become a vector."""
    n = 0
    while at < len(t_us) and n + _ROOM <= len(words):
        mark, below = t_us[at] >> evt3.LOW_BITS, t_us[at] & (evt3.MARK_RANGE - 1)
        if mark != high:
            waits = high >= 0 and mark - high >= evt3.MARK_RANGE // 2
            high = high + evt3.MARK_RANGE // 2 - 1 if waits else mark
            words[n] = evt3.TIME_HIGH << 12 | high & (evt3.MARK_RANGE - 1)
            n += 1
            low = -1
            if waits:
                continue
        if below != low:
            words[n] = evt3.TIME_LOW << 12 | below
            n += 1
            low = below
        if y[at] != row:
            row = np.int64(y[at])
            words[n] = evt3.Y << 12 | row
            n += 1
        base, polarity = np.int64(x[at]) & ~31, np.int64(p[at]) << 11
        end, mask = at, np.int64(0)
        while end < len(t_us) and t_us[end] == t_us[at] and y[end] == row and p[end] == p[at]:
            bit = np.int64(1) << (np.int64(x[end]) - base) if base <= x[end] < base + 32 else np.int64(0)
            if bit <= mask:  # not to the right of the previous one, or outside
                break
            mask |= bit
            end += 1
        if end - at > _VECTOR_WORDS:
            words[n] = evt3.BASE_X << 12 | polarity | base
            words[n + 1] = evt3.VECTOR_12 << 12 | mask & 4095
            words[n + 2] = evt3.VECTOR_12 << 12 | mask >> 12 & 4095
            words[n + 3] = evt3.VECTOR_8 << 12 | mask >> 24
            n += _VECTOR_WORDS
            at = end
        while at < end:
            words[n] = evt3.X << 12 | polarity | np.int64(x[at])
            n += 1
            at += 1
    return at, n, high, low, row


class _WordSink(ABC):
    """A file of words; the header is written with the first event, whose time it may have to hold."""

    _number: ClassVar[int]
    _word: ClassVar[type[np.unsignedinteger[Any]]]
    _encode: ClassVar[Callable[..., tuple[int, int, int, int, int]]]

    def __init__(self, file: BinaryIO, sensor: Sensor) -> None:
        self._file, self._sensor = file, sensor
        self._count = 0
        self._t0_us = self._last_us = 0
        self._high = self._low = self._row = -1

    @abstractmethod
    def _t0_for(self, first_us: int) -> int:
        """The offset to add to the words' times, for events from `first_us` on."""

    @abstractmethod
    def _check_times(self, t_us: NDArray[np.int64]) -> None:
        """Raise RecordingError for times that the words cannot hold."""

    def write(self, events: Events) -> None:
        """See `source.Sink`."""
        if not len(events):
            return
        seen = events.read_only()
        t_us, x, y, p = seen.t_us, seen.x, seen.y, seen.p
        self._check("t", t_us, t_us < 0, "must not be negative")
        for axis, values in (("x", x), ("y", y)):
            self._check(axis, values, values >= _ADDRESSES, f"must be below {_ADDRESSES} in EVT {self._number}.0")
        if not self._count:
            first_us = self._last_us = int(t_us[0])
            self._check("t", t_us, t_us[:1] >= T0_LIMIT_US, "must be below 2^62 at the start")
            self._t0_us = self._t0_for(first_us)
            self._write_header()
        self._check_times(t_us)
        words = np.empty(_WORDS, np.dtype(self._word).newbyteorder("<"))
        own_us, at = t_us - self._t0_us, 0
        while at < len(events):
            at, made, self._high, self._low, self._row = type(self)._encode(
                own_us, x, y, p, at, self._high, self._low, self._row, words
            )
            self._file.write(words[:made].data)
        self._count += len(events)
        self._last_us = int(t_us[-1])

    def close(self) -> None:
        """See `source.Sink`."""
        if not self._count:
            self._write_header()

    def _check(self, field: str, values: NDArray[Any], wrong: NDArray[np.bool_], rule: str) -> None:
        if wrong.any():
            i = int(wrong.argmax())
            raise RecordingError(f"event {self._count + i}: {field} = {values[i]}: {rule}")

    def _write_header(self) -> None:
        width, height = self._sensor
        lines = [
            f"evt {self._number}.0",
            f"format EVT{self._number};height={height};width={width}",
            f"geometry {width}x{height}",
            *([f"t0 {self._t0_us}"] if self._t0_us else []),
            "end",
        ]
        self._file.write("".join(f"% {line}\n" for line in lines).encode())


class Evt2Sink(_WordSink):
    """EVT 2.0 writer; 34-bit times last for 4.8 hours."""

    _number = 2
    _word = np.uint32
    _encode = _encode_evt2

    def _t0_for(self, first_us: int) -> int:
        return 0 if first_us < _EVT2_RANGE_US // 2 else first_us

    def _check_times(self, t_us: NDArray[np.int64]) -> None:
        limit_us = self._t0_us + _EVT2_RANGE_US
        rule = f"must be below {limit_us}: EVT 2.0 lasts for 2^34 us from {self._t0_us} us on"
        self._check("t", t_us, t_us >= limit_us, rule)


class Evt3Sink(_WordSink):
    """EVT 3.0 writer; 24-bit times may wrap around any number of times."""

    _number = 3
    _word = np.uint16
    _encode = _encode_evt3

    def _t0_for(self, first_us: int) -> int:
        return first_us - first_us % _EVT3_RANGE_US

    def _check_times(self, t_us: NDArray[np.int64]) -> None:
        silence_us = np.diff(t_us, prepend=self._last_us)
        rule = "must follow the event before within 2^44 us (203 days) in EVT 3.0"
        self._check("t", t_us, silence_us > _LONGEST_SILENCE_US, rule)
