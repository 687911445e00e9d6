# SPDX-License-Identifier: Apache-2.0
"""One event per line: CSV as tools and spreadsheets write it, and the `t x y p` text of event-camera data sets.

Cells are separated by comma, semicolon, tab or spaces. They hold t, x, y, p in that order, or in the order of a header line
(`x;y;polarity;t_us`); without one, in the order that the first lines show (`column_order`). Other columns are skipped, and so
are blank lines and those that begin with # or %. Every line must have as many cells as the first event. p is 1 or true where
the pixel became brighter, 0, -1 or false where darker; 255, 65535 and 4294967295 are -1 without its sign.

The unit of time is stated in the header (`t_us`, `t_s`, `t[s]`), else it is seconds if the first event's t has a decimal point
or an exponent, else whole microseconds. Times are rounded to the nearest microsecond, halves away from zero.

The sensor is stated in the header (`t,x@346,y@260,p`), by a line of two numbers before the first event (`346 260`), or in a
comment as Metavision writes it (`%geometry:1280,720`).

Text is always read from its start: seeking to a time is not supported.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from io import BufferedReader
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import RecordingError
from ...events import Events
from ._text_kernel import LINE_BYTES, PADDING_BYTES, SHORTEST_LINE_BYTES, format_lines, parse_lines
from ._text_layout import LONGEST_LINE_BYTES, SEPARATORS, is_text, read_layout
from .blocks import in_order
from .numeric import UNITS, without_unsigned_minus_one
from .source import BLOCK_EVENTS, Format, Sensor, WritableFormat

__all__ = ["FORMATS", "WRITABLE"]

_CHUNK_BYTES = BLOCK_EVENTS * SHORTEST_LINE_BYTES
_NEWLINE = ord("\n")


class _Parsed(NamedTuple):
    """The events of some lines, the number of these lines, and the error in the next line, None if there is none."""

    events: Events
    lines: int
    fault: str | None


class _TextSource:
    """See `source.Source`. The file is opened anew for each pass, so that passes are independent."""

    def __init__(self, path: Path) -> None:
        self._path = path
        with path.open("rb") as file:
            self._layout = read_layout(file)
            self._size = file.seek(0, 2)
        self.sensor = self._layout.sensor
        self.details = {"separator": SEPARATORS[self._layout.separator], "times in": UNITS[self._layout.power]}
        if self._layout.decimal_comma:
            self.details["decimal mark"] = "comma"
        if self._layout.unnamed_order:
            self.details["columns"] = (
                f"{self._layout.unnamed_order}, assumed by their values; a first line such as x,y,t,p names them"
            )
        self.left_out: Counter[str] = Counter()
        self.remarks: list[str] = []

    def blocks(self, from_us: int | None = None) -> Iterator[Events]:
        """See `source.Source`; `from_us` is ignored."""
        line = self._layout.lines + 1
        with self._path.open("rb") as file:
            file.seek(self._layout.offset)
            for parsed in in_order(self._parse, self._whole_lines(file)):
                yield parsed.events
                line += parsed.lines
                if parsed.fault is not None:
                    raise RecordingError(f"line {line}: {parsed.fault}")

    def _whole_lines(self, file: BufferedReader) -> Iterator[tuple[NDArray[np.uint8], int]]:
        """The rest of a file as pieces that end in a newline, with padding after them, and their lengths."""
        room = min(_CHUNK_BYTES, self._size + 1)
        begun = b""  # start of a line that did not end in the previous piece
        while True:
            text = np.empty((room // 8 + 1) * 8 + PADDING_BYTES, np.uint8)
            view = text.data
            view[: len(begun)] = begun
            got = file.readinto(view[len(begun) : room])
            filled = len(begun) + got
            tail = max(0, filled - LONGEST_LINE_BYTES)
            length = tail + bytes(view[tail:filled]).rfind(b"\n") + 1
            if not got:
                break
            if length > tail:
                yield text, length
                begun = bytes(view[length:filled])
            elif tail or filled == room:
                raise RecordingError(f"byte {file.tell()}: no line ends in the {filled - tail} bytes before: must be text")
            else:
                begun = bytes(view[:filled])
        if file.tell() < self._size:
            raise RecordingError(f"ends at byte {file.tell()}: held {self._size} bytes when it was opened")
        if begun:
            if self._layout.needs_newline:
                raise RecordingError("the last line must end in a newline; is it cut off?")
            view[len(begun)] = _NEWLINE
            yield text, len(begun) + 1

    def _parse(self, piece: tuple[NDArray[np.uint8], int]) -> _Parsed:
        """The events of a piece up to the first invalid line."""
        text, length = piece
        layout = self._layout
        if layout.decimal_comma:
            text[text == ord(",")] = ord(".")
        events = Events.allocated(length // SHORTEST_LINE_BYTES + 1)
        count, lines, cell = parse_lines(
            text, length, ord(layout.separator), layout.columns, layout.power, layout.exact,
            events.t_us, events.x, events.y, events.p,
        )  # fmt: skip
        fault = None
        if cell >= 0:
            fault = layout.fault(text[:length].tobytes().split(b"\n", lines + 1)[lines] + b"\n", cell)
        events = events[:count]
        return _Parsed(Events(events.t_us, events.x, events.y, without_unsigned_minus_one(events.p)), lines, fault)

    def smallest_sensor(self, width: int, height: int) -> Sensor:
        """See `source.Source`."""
        return width, height

    def close(self) -> None:
        """Do nothing: no file stays open between passes."""


class _CsvSink:
    """See `source.Sink`."""

    def __init__(self, file: BinaryIO, sensor: Sensor) -> None:
        self._file = file
        file.write("t_us,x@{},y@{},p\n".format(*sensor).encode())

    def write(self, events: Events) -> None:
        events = events.read_only()
        text = np.empty(len(events) * LINE_BYTES, np.uint8)
        length = format_lines(events.t_us, events.x, events.y, events.p, text)
        self._file.write(text[:length].data)

    def close(self) -> None:
        """Do nothing: the format has no trailer."""


FORMATS = (Format("text", "CSV or text", lambda start, _: is_text(start), _TextSource),)
WRITABLE = (WritableFormat("csv", "CSV", ".csv", _CsvSink),)
