# SPDX-License-Identifier: Apache-2.0
"""Files with a header and words of one width: read in pieces, decoded with the state carried over from piece to piece."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...errors import RecordingError
from ...events import Events
from .source import BLOCK_EVENTS, Sensor

__all__ = ["Layout", "State", "WordArray", "WordFile", "Words"]

WordArray: TypeAlias = NDArray[np.unsignedinteger[Any]]
# State of a decoder between two words: a NamedTuple of integers.
State: TypeAlias = Any


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
    fill: Callable[..., tuple[int, int, State]]
    seek: Callable[[Words, int], tuple[int, State]]
    lost: Mapping[str, str]


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
        self._state = layout.start
        self.remarks: list[str] = []

    @property
    def left_out(self) -> Mapping[str, int]:
        """See `source.Source`."""
        counts = {why: getattr(self._state, field) for why, field in self._layout.lost.items()}
        return {why: count for why, count in counts.items() if count}

    def blocks(self, from_us: int | None = None) -> Iterator[Events]:
        """See `source.Source`."""
        begin, self._state = (0, self._layout.start) if from_us is None else self._layout.seek(self._words, from_us)
        for _, piece in self._words.pieces(begin, len(self._words), self._piece_words):
            yield from self._decode(piece)
        self._words.check_end()

    def _decode(self, words: WordArray) -> Iterator[Events]:
        most = self._layout.most_events
        while len(words):
            room = min(len(words) * most, BLOCK_EVENTS) + most
            t_us, x = np.empty(room, np.int64), np.empty(room, np.uint16)
            y, p = np.empty(room, np.uint16), np.empty(room, np.uint8)
            used, count, self._state = self._layout.fill(words, self._state, t_us, x, y, p)
            words = words[used:]
            if count:
                yield Events(t_us[:count], x[:count], y[:count], p[:count])

    def close(self) -> None:
        """Close the file."""
        self._words.close()
