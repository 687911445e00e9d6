# SPDX-License-Identifier: Apache-2.0
"""One event per line: CSV as tools and spreadsheets write it, and the `t x y p` text of event-camera data sets.

Cells are separated by comma, semicolon, tab or blanks. They hold t, x, y, p in that order, or in the order that a first line
names (`x;y;polarity;t_us`); other columns are passed over, and so are blank lines and those that begin with # or %. Every line
has as many cells as the first event. p is 1 where the pixel became brighter, 0 or -1 where darker.

The unit of time is what the header says (`t_us`, `t_s`, `t[s]`), else seconds if the first event's t has a decimal point or an
exponent, else whole microseconds. Times are rounded to the nearest microsecond, halves away from zero.

The sensor is what the header says (`t,x@346,y@260,p`), or a line of two numbers before the first event (`346 260`).

Text is always read from its start: a time in it is found by reading.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from io import BufferedReader
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from ..errors import RecordingError
from ..events import Events
from ._text_kernel import LINE_BYTES, PADDING_BYTES, SHORTEST_LINE_BYTES, format_lines, parse_lines
from ._text_layout import LONGEST_LINE_BYTES, SEPARATORS, Layout, is_text, read_layout
from .fields import UNITS
from .source import BLOCK_EVENTS, Format, Sensor, WritableFormat

__all__ = ["FORMATS", "WRITABLE"]

_CHUNK_BYTES = BLOCK_EVENTS * SHORTEST_LINE_BYTES
_NEWLINE = ord("\n")


class _TextSource:
    """See `source.Source`. The file is opened for each pass, so that passes do not disturb each other."""

    def __init__(self, path: Path) -> None:
        self._path = path
        with path.open("rb") as file:
            self._layout = read_layout(file)
            self._size = file.seek(0, 2)
        self.sensor = self._layout.sensor
        self.details = {"separator": SEPARATORS[self._layout.separator], "times in": UNITS[self._layout.power]}
        self.left_out: Counter[str] = Counter()

    def blocks(self, from_us: int | None = None) -> Iterator[Events]:
        """See `source.Source`; from_us changes nothing."""
        line = self._layout.lines + 1
        with self._path.open("rb") as file:
            file.seek(self._layout.offset)
            for text, length in self._whole_lines(file):
                events, lines, fault = _parse(text, length, self._layout)
                yield events
                line += lines
                if fault >= 0:
                    raw = text[:length].tobytes().split(b"\n", lines + 1)[lines] + b"\n"
                    raise RecordingError(f"line {line}: {self._layout.fault(raw, fault)}")

    def _whole_lines(self, file: BufferedReader) -> Iterator[tuple[NDArray[np.uint8], int]]:
        """The rest of a file as pieces that end in a newline, in a buffer that is used again, and their lengths."""
        room = min(_CHUNK_BYTES, self._size + 1)
        buffer = bytearray((room // 8 + 1) * 8 + PADDING_BYTES)
        text, view = np.frombuffer(buffer, np.uint8), memoryview(buffer)
        begun = 0  # bytes of a line that are there already
        while got := file.readinto(view[begun:room]):
            filled = begun + got
            tail = max(0, filled - LONGEST_LINE_BYTES)
            length = tail + buffer[tail:filled].rfind(b"\n") + 1
            if length > tail:
                yield text, length
                buffer[: filled - length] = buffer[length:filled]
                begun = filled - length
            elif tail or filled == room:
                raise RecordingError(f"byte {file.tell()}: no line ends in the {filled - tail} bytes before: must be text")
            else:
                begun = filled
        if file.tell() < self._size:
            raise RecordingError(f"ends at byte {file.tell()}: held {self._size} bytes when it was opened")
        if begun:
            if self._layout.needs_newline:
                raise RecordingError("the last line must end in a newline; is it cut off?")
            buffer[begun] = _NEWLINE
            yield text, begun + 1

    def smallest_sensor(self, width: int, height: int) -> Sensor:
        """See `source.Source`."""
        return width, height

    def close(self) -> None:
        """Nothing stays open."""


def _parse(text: NDArray[np.uint8], length: int, layout: Layout) -> tuple[Events, int, int]:
    """The events in the first bytes of a buffer, how many lines they take, and the cell at fault in the next; -1 if none is."""
    room = length // SHORTEST_LINE_BYTES + 1
    events = Events.allocated(room)
    count, lines, fault = parse_lines(
        text, length, ord(layout.separator), layout.columns, layout.power, layout.exact,
        events.t_us, events.x, events.y, events.p,
    )  # fmt: skip
    return events[:count], lines, fault


class _CsvSink:
    """See `source.Sink`."""

    def __init__(self, file: BinaryIO, sensor: Sensor) -> None:
        self._file = file
        file.write("t_us,x@{},y@{},p\n".format(*sensor).encode())

    def write(self, events: Events) -> None:
        text = np.empty(len(events) * LINE_BYTES, np.uint8)
        length = format_lines(events.t_us, events.x, events.y, events.p, text)
        self._file.write(text[:length].data)

    def close(self) -> None:
        """Nothing stands at the end."""


FORMATS = (Format("text", "CSV or text", lambda start, _: is_text(start), _TextSource),)
WRITABLE = (WritableFormat("csv", "CSV", ".csv", _CsvSink),)
