# SPDX-License-Identifier: Apache-2.0
"""Prophesee's ECF codec, with which HDF5 files of Metavision and OpenEB are compressed: HDF5 filter 36559 (0x8ECF).

A chunk has a 32-bit word: number of events in bits 31..2, and in the low bits how y, x and p are packed; then, little-endian:

- Times: the first one in 64 bits; then bytes, in runs. High nibble 0 to 14: that much later, for as many events as the low
  nibble says, or, if that is 15, the 16 bits after it. High nibble 15: the low nibbles of all such bytes in turn, lowest first,
  are the time to add.
- Bit 1 set: four events in three 32-bit words, 24 bits each from the top: y in bits 22..12, x in 11..1, p in 0.
- Else runs of rows: 16 bits, y in 15..5 for as many events as 4..0 says, or, if that is 31, the 16 bits after it. And
  - bit 0 set: four events in three 16-bit words, 12 bits each from the top: x in 11..1, p in 0;
  - else columns: 16 bits, x in 15..5, and one more event at x + 1 to x + 5 for each set bit of 4..0, from the top; then runs of
    polarities: 8 bits, p in 7 for as many events as 6..0 says, or, if that is 127, the 16 bits after it.

https://github.com/prophesee-ai/hdf5_ecf. There is no such plug-in of the HDF5 library on PyPI.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import njit, step
from ...errors import RecordingError
from .numeric import RECORD

__all__ = ["FILTER", "unpack"]

FILTER = 0x8ECF

_HEAD_BYTES = 12
_ALL_PACKED, _COLUMNS_PACKED = 2, 1
_BITS_OF_TIME = 64


def unpack(packed: bytes, most: int) -> NDArray[np.void]:
    """The events of a chunk, as `numeric.RECORD`s.

    Args:
        most: the largest number of events to accept.

    Raises:
        RecordingError: it is damaged, or has more events.
    """
    if len(packed) < _HEAD_BYTES:
        raise RecordingError(f"chunk of {len(packed)} bytes: must be at least {_HEAD_BYTES} in ECF")
    count, kind = divmod(int.from_bytes(packed[:4], "little"), 4)
    if count > most:
        raise RecordingError(f"chunk of {count} events: must be at most {most}")
    data = np.frombuffer(packed, np.uint8)
    words = np.zeros((count, 2), np.int64)
    at = _times(data, words)
    if at >= 0 and kind & _ALL_PACKED:
        at = _packed_fours(data, at, words, 24)
    elif at >= 0:
        at = _rows(data, at, words)
        if at >= 0 and kind & _COLUMNS_PACKED:
            at = _packed_fours(data, at, words, 12)
        elif at >= 0:
            at = _columns(data, at, words)
            at = _polarities(data, at, words) if at >= 0 else at
    if at < 0:
        raise RecordingError(f"chunk of {len(packed)} bytes and {count} events: is no ECF, or damaged")
    return words.view(RECORD)[:, 0]


@njit(cache=True, nogil=True)
def _times(data, words):  # type: ignore[no-untyped-def]
    """Fill the times; returns the offset after them, -1 if they do not end with the last event within the data."""
    t = np.int64(0)
    for i in range(8):
        t |= np.int64(data[4 + i]) << (8 * i)
    at, n, shift = _HEAD_BYTES, 0, 0
    step = np.int64(0)
    while n < len(words):
        if at >= len(data):
            return -1
        later, run = np.int64(data[at] >> 4), np.int64(data[at] & 15)
        at += 1
        if later == 15:
            if shift >= _BITS_OF_TIME:
                return -1
            step |= run << shift
            shift += 4
            continue
        t += step + later
        step, shift = np.int64(0), 0
        run, at = _run(data, at, run, 15)
        if run < 0 or n + run > len(words):
            return -1
        words[n : n + run, 1] = t
        n += run
    return at


@njit(cache=True, nogil=True)
def _rows(data, at, words):  # type: ignore[no-untyped-def]
    """The same for y."""
    n = 0
    while n < len(words):
        word, at = _word(data, at)
        run, at = _run(data, at, word & 31, 31)
        if word < 0 or run < 0 or n + run > len(words):
            return -1
        words[n : n + run, 0] = word >> 5 << 16
        n += run
    return at


@njit(cache=True, nogil=True)
def _columns(data, at, words):  # type: ignore[no-untyped-def]
    """The same for x; the last word may have bits beyond the last event."""
    n = 0
    while n < len(words):
        word, at = _word(data, at)
        if word < 0:
            return -1
        for i in range(6):
            if (i == 0 or word >> (5 - i) & 1) and n < len(words):
                words[n, 0] |= (word >> 5) + i
                n += 1
    return at


@njit(cache=True, nogil=True)
def _polarities(data, at, words):  # type: ignore[no-untyped-def]
    """The same for p."""
    n = 0
    while n < len(words):
        if at >= len(data):
            return -1
        p, run = np.int64(data[at] >> 7), np.int64(data[at] & 127)
        at += 1
        run, at = _run(data, at, run, 127)
        if run < 0 or n + run > len(words):
            return -1
        for i in range(n, n + run):
            words[i, 0] |= p << 32
        n += run
    return at


@njit(cache=True, nogil=True)
def _packed_fours(data, at, words, bits):  # type: ignore[no-untyped-def]
    """The same for x and p, or with 24 bits for y, x and p: four events in three words, each of a third more bits."""
    octets = bits // 6  # of a word
    rest = 8 * octets - bits
    for n in range(0, len(words), 4):
        if at + 3 * octets > len(data):
            return -1
        first, second, third = np.int64(0), np.int64(0), np.int64(0)
        for i in range(octets):
            first |= np.int64(data[at + i]) << 8 * i
            second |= np.int64(data[at + octets + i]) << 8 * i
            third |= np.int64(data[at + 2 * octets + i]) << 8 * i
        at += 3 * octets
        # What an event leaves of a word are the low bits of the next event, whose high bits are those of the next word.
        four = (
            first >> rest,
            (first & (1 << rest) - 1) | second >> 2 * rest << rest,
            (second & (1 << 2 * rest) - 1) | third >> 3 * rest << 2 * rest,
            third & (1 << bits) - 1,
        )
        for i in range(min(4, len(words) - n)):
            words[n + i, 0] |= four[i] >> 1 & 2047 | (four[i] & 1) << 32 | (four[i] >> 12 & 2047) << 16
    return at


@step
def _run(data, at, run, full):  # type: ignore[no-untyped-def]
    """The length of a run: as given, or in the 16 bits at an offset if that is `full`; and the offset after it."""
    return _word(data, at) if run == full else (run, at)


@step
def _word(data, at):  # type: ignore[no-untyped-def]
    """The 16 bits at an offset, -1 beyond the data; and the offset after them."""
    if at + 2 > len(data):
        return np.int64(-1), at
    return np.int64(data[at]) | np.int64(data[at + 1]) << 8, at + 2
