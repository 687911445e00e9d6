# SPDX-License-Identifier: Apache-2.0
"""`.bin` of N-MNIST and N-Caltech101: five bytes per event, most significant bits first.

x (8 bits), y (8), polarity (1), time in microseconds (23). An event with y = 240 is none: it adds 8.192 ms to the times of all
that follow. There is no header, so a file must have this suffix, and times that go on.
https://www.garrickorchard.com/datasets/n-mnist
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...errors import RecordingError
from ...events import Events
from .source import BLOCK_EVENTS, AnySensor, Format, Sensor

__all__ = ["FORMATS"]

_EVENT_BYTES = 5
_OVERFLOW_Y, _OVERFLOW_US = 240, 1 << 13
_SURE = 0.05  # share of the first events that may run back in time


class _BinFile(AnySensor):
    """See `source.Source`."""

    sensor: Sensor | None = None

    def __init__(self, path: Path) -> None:
        self._path = path
        self._size = path.stat().st_size
        self.details: Mapping[str, str] = {"times in": "microseconds"}
        self.left_out: Counter[str] = Counter()
        self.remarks: list[str] = []

    def blocks(self, from_us: int | None = None) -> Iterator[Events]:
        """See `source.Source`; `from_us` is ignored."""
        later_us = 0
        with self._path.open("rb") as file:
            while piece := file.read(BLOCK_EVENTS * _EVENT_BYTES):
                whole = len(piece) - len(piece) % _EVENT_BYTES
                t_us, x, y, p = _columns(piece[:whole])
                over = y == _OVERFLOW_Y
                t_us += later_us + _OVERFLOW_US * np.cumsum(over)
                later_us += _OVERFLOW_US * int(np.count_nonzero(over))
                kept = ~over
                yield Events(t_us[kept], x[kept], y[kept], p[kept])
        if self._size % _EVENT_BYTES:
            raise RecordingError(f"ends within the event at byte {self._size - self._size % _EVENT_BYTES}; is it cut off?")

    def close(self) -> None:
        """Do nothing: no file stays open between passes."""


def _columns(content: bytes) -> tuple[NDArray[np.int64], NDArray[np.uint16], NDArray[np.uint16], NDArray[np.uint8]]:
    """t, x, y, p of whole events."""
    rows = np.frombuffer(content, np.uint8).reshape(-1, _EVENT_BYTES)
    high, middle, low = (rows[:, i].astype(np.int64) for i in (2, 3, 4))
    t_us: NDArray[np.int64] = (high & 127) << 16 | middle << 8 | low
    return t_us, rows[:, 0].astype(np.uint16), rows[:, 1].astype(np.uint16), (high >> 7).astype(np.uint8)


def _matches(start: bytes, path: Path) -> bool:
    """Whether times go on in the first events of a file with this suffix."""
    if path.suffix.lower() != ".bin" or len(start) < 2 * _EVENT_BYTES:
        return False
    t_us, _, y, _ = _columns(start[: len(start) - len(start) % _EVENT_BYTES])
    t_us += _OVERFLOW_US * np.cumsum(y == _OVERFLOW_Y)
    return float((np.diff(t_us) < 0).mean()) <= _SURE and int(t_us[-1]) > int(t_us[0])


FORMATS = (Format("nmnist", "N-MNIST bin", _matches, _BinFile),)
