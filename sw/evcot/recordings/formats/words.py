# SPDX-License-Identifier: Apache-2.0
"""Files with a header and words of one width, decoded piece by piece; truncated time marks, and locating a time in a file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import njit, step
from ...errors import RecordingError
from ...events import Events
from .source import BLOCK_EVENTS, Sensor

__all__ = [
    "Decoder", "FirstMark", "Layout", "State", "WordArray", "WordFile", "Words", "advance", "place_of_mark", "put_vector",
]  # fmt: skip


# A kernel (words, least) -> (index, mark) of the first time mark >= `least`; the index is len(words) if there is none.
FirstMark = Callable[[NDArray[Any], int], tuple[int, int]]

_PLACES = 256
_ROUNDS = 2  # the range that is then left of a file of 4 GiB is read in a millisecond
_PIECE_WORDS = 512


@njit(cache=True, nogil=True, inline="always")
def advance(high, mark, mark_range):  # type: ignore[no-untyped-def]
    """Unwrap a mark that follows the unwrapped mark `high` (< 0: none yet): a drop by more than half is a wrap-around."""
    if high < 0:
        return mark
    turns = high // mark_range
    if high - turns * mark_range - mark > mark_range // 2:
        turns += 1
    return turns * mark_range + mark


def place_of_mark(words: Words, first_mark: FirstMark, least: int) -> int:
    """Index of the first mark >= `least`, found without reading all words; 0 if marks decrease or none is that high.

    Decreasing marks have wrapped around: then only a sequential read can count the wrap-arounds. Marks are sampled at 256
    places, so a decrease that is made up for before the next sample goes unnoticed.
    """
    begin, end = 0, len(words)
    for _ in range(_ROUNDS):
        if end - begin <= _PLACES * _PIECE_WORDS:
            break
        edges = np.linspace(begin, end, _PLACES + 1).astype(np.int64).tolist()
        found = [each for low, high in pairwise(edges) if (each := _first(words, low, high, first_mark, 0)) is not None]
        places, marks = [place for place, _ in found], [mark for _, mark in found]
        if any(later < earlier for earlier, later in pairwise(marks)):
            return 0
        reached = int(np.searchsorted(marks, least))
        begin = places[reached - 1] if reached else begin
        end = places[reached] + 1 if reached < len(places) else end
    last = _first(words, begin, end, first_mark, least)
    return 0 if last is None else last[0]


def _first(words: Words, begin: int, end: int, first_mark: FirstMark, least: int) -> tuple[int, int] | None:
    for at, piece in words.pieces(begin, end, _PIECE_WORDS):
        index, mark = first_mark(piece, least)
        if index < len(piece):
            return at + index, mark
    return None


# A de Bruijn sequence: the five top bits of its product with 2^i are different for every i from 0 to 31.
_DE_BRUIJN = 0x077CB531
_LOWEST = np.zeros(32, np.int64)
_LOWEST[[(_DE_BRUIJN << i & 0xFFFFFFFF) >> 27 for i in range(32)]] = np.arange(32)


@step
def put_vector(n, mask, time_us, left, row, polarity, t_us, x, y, p):  # type: ignore[no-untyped-def]
    """Write an event for each set bit of `mask`, an int64 below 2^32, from index `n` on; returns the index after the last."""
    while mask:
        lowest = mask & -mask
        t_us[n] = time_us
        x[n] = left + _LOWEST[(lowest * _DE_BRUIJN & 0xFFFFFFFF) >> 27]
        y[n] = row
        p[n] = polarity
        n += 1
        mask ^= lowest
    return n


WordArray: TypeAlias = NDArray[np.unsignedinteger[Any]]
# State of a decoder between two words: a NamedTuple of integers.
State: TypeAlias = Any
Fill = Callable[..., tuple[int, int, State]]  # see `Layout`


class Words:
    """The little-endian words after a header; slicing reads them. `len` is the number of complete words."""

    def __init__(self, path: Path, offset: int, dtype: np.dtype[Any]) -> None:
        self._file = path.open("rb", buffering=0)
        self._offset, self._dtype = offset, dtype.newbyteorder("<")
        self._count, self._odd_bytes = divmod(max(self._file.seek(0, 2) - offset, 0), dtype.itemsize)

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, window: slice) -> WordArray:
        begin, end, _ = window.indices(self._count)
        words = np.empty(max(end - begin, 0), self._dtype)
        size = self._dtype.itemsize
        self._file.seek(self._offset + begin * size)
        got = self._file.readinto(words.view(np.uint8).data) if len(words) else 0
        if got != words.nbytes:
            raise RecordingError(f"ends at byte {self._offset + begin * size + got}, earlier than when it was opened")
        return words

    def pieces(self, begin: int, end: int, length: int) -> Iterator[tuple[int, WordArray]]:
        """The words from `begin` to `end` (exclusive), up to `length` at a time: (index, piece)."""
        for at in range(begin, end, length):
            yield at, self[at : min(at + length, end)]

    def check_end(self) -> None:
        """Raise RecordingError if the file ends within a word."""
        if self._odd_bytes:
            size = self._dtype.itemsize
            at = self._offset + self._count * size + self._odd_bytes
            raise RecordingError(f"ends within a word of {size} bytes, at byte {at}; is it cut off?")

    def close(self) -> None:
        """Close the file."""
        self._file.close()


@dataclass(frozen=True)
class Layout:
    """How words are decoded to events.

    Attributes:
        dtype: type of a word.
        most_events: maximum events per word.
        start: the state before the first word.
        fill: a kernel (words, state, t_us, x, y, p) -> (words used, events decoded, state): decodes until the words end, or
            the output arrays might overflow.
        seek: (words, from_us) -> the index to start from, and the state there; all events before it are earlier than `from_us`.
        lost: reason for which events are left out -> the field of the state that counts them.
    """

    dtype: np.dtype[Any]
    most_events: int
    start: State
    fill: Fill
    seek: Callable[[Words, int], tuple[int, State]]
    lost: Mapping[str, str]


class Decoder:
    """Decodes words to events, going on from call to call.

    Args:
        fill, most_events, lost: as of `Layout`.
        state: before the first word.
    """

    def __init__(self, fill: Fill, most_events: int, state: State, lost: Mapping[str, str]) -> None:
        self._fill, self._most_events, self.state, self._lost = fill, most_events, state, lost

    @property
    def left_out(self) -> Counter[str]:
        """Reason -> number of events left out so far."""
        return Counter({why: count for why, field in self._lost.items() if (count := getattr(self.state, field))})

    def feed(self, words: WordArray) -> Iterator[Events]:
        """The events of the next words, in blocks of bounded size."""
        while len(words):
            events = Events.allocated(min(len(words) * self._most_events, BLOCK_EVENTS) + self._most_events)
            used, count, self.state = self._fill(words, self.state, events.t_us, events.x, events.y, events.p)
            words = words[used:]
            if count:
                yield events[:count]


class WordFile:
    """A file of words. See `source.Source`.

    Args:
        smallest_sensor: see `source.Source`.
        piece_words: number of words to read at a time; does not affect the result.
    """

    def __init__(
        self,
        words: Words,
        layout: Layout,
        sensor: Sensor | None,
        details: Mapping[str, str],
        smallest_sensor: Callable[[int, int], Sensor],
        piece_words: int = BLOCK_EVENTS,
    ) -> None:
        self.sensor, self.details, self.smallest_sensor = sensor, details, smallest_sensor
        self._words, self._layout, self._piece_words = words, layout, piece_words
        self._decoder = Decoder(layout.fill, layout.most_events, layout.start, layout.lost)
        self.remarks: list[str] = []

    @property
    def left_out(self) -> Mapping[str, int]:
        """See `source.Source`."""
        return self._decoder.left_out

    def blocks(self, from_us: int | None = None) -> Iterator[Events]:
        """See `source.Source`."""
        begin, self._decoder.state = (0, self._layout.start) if from_us is None else self._layout.seek(self._words, from_us)
        for _, piece in self._words.pieces(begin, len(self._words), self._piece_words):
            yield from self._decoder.feed(piece)
        self._words.check_end()

    def close(self) -> None:
        """Close the file."""
        self._words.close()
