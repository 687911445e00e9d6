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

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from io import BufferedReader
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import RecordingError
from ...events import Events
from ._text_kernel import LINE_BYTES, PADDING_BYTES, SHORTEST_LINE_BYTES, UNUSED, P, T, X, Y, format_lines, parse_lines
from .blocks import in_order
from .numeric import SAMPLED_ROWS, UNITS, Naming, column_order, find_fields, order_text, without_unsigned_minus_one
from .printable import whole_number
from .source import BLOCK_EVENTS, AnySensor, Format, Sensor, WritableFormat

__all__ = ["FORMATS", "WRITABLE", "Layout"]

LONGEST_LINE_BYTES = 1 << 16
_MOST_HEADER_BYTES = 1 << 22  # before the first event
_MOST_HEADER_LINES = 1 << 16
SEPARATORS = {",": "comma", ";": "semicolon", "\t": "tab", " ": "blanks"}

_NAMES = {T: "t", X: "x", Y: "y", P: "p", UNUSED: "text"}
_ADDRESS = "must be a whole number from 0 to 65535"
_RULES = {X: _ADDRESS, Y: _ADDRESS, P: "must be 0, 1 or -1, or true or false", UNUSED: "must be text"}
_TRUTHS = {"true": "1", "false": "0"}
_GEOMETRY = re.compile(r"[#%]\s*geometry[:=\s]\s*(\d+)\s*[,x]\s*(\d+)", re.IGNORECASE)  # Metavision's
_EVENT_START = re.compile(r"[-+.0-9]|(true|false)\b", re.IGNORECASE)
_JUDGED_CELLS = 8
_SHOWN = 60  # characters of a line in a message


@dataclass(frozen=True)
class Layout:
    """The layout of the lines.

    Attributes:
        offset, lines: position of the first event: bytes and lines before it.
        separator: between cells; a space stands for any number of spaces and tabs.
        columns: (k,) int8, the field in each cell: T, X, Y, P or UNUSED.
        power, exact: times are in units of 10**power us, and must be whole microseconds if `exact`.
        sensor: (width, height) in pixels, if stated.
        unnamed_order: the order of columns without names, such as "t, x, y, p"; empty where they have names.
    """

    offset: int
    lines: int
    separator: str
    columns: NDArray[np.int8]
    power: int
    exact: bool
    sensor: Sensor | None
    unnamed_order: str = ""
    decimal_comma: bool = False

    @property
    def needs_newline(self) -> bool:
        """Whether a line truncated in its last cell could look complete; a one-digit polarity cannot."""
        return int(self.columns[-1]) not in (P, UNUSED)

    def fault(self, raw: bytes, cell: int) -> str:
        """Error message for a line with an invalid cell."""
        what = _no_text(raw)
        if what:
            return what
        line = raw.decode("utf-8", "replace").strip(" \r\n")
        cells = _cells(line, self.separator)
        if len(cells) != len(self.columns):
            return f"{line[:_SHOWN]!r}: must have {len(self.columns)} cells, as the first event; it has {len(cells)}"
        column = int(self.columns[cell])
        return f"{_NAMES[column]} = {cells[cell][:_SHOWN]!r}: {_RULES.get(column) or self._time_rule}"

    @property
    def _time_rule(self) -> str:
        return f"must be a {'whole ' if self.exact else ''}number of {UNITS[self.power]}, below 2^63 us"


_UNNAMED = Naming((0, 1, 2, 3), None)  # of a file without events


def is_text(content: bytes) -> bool:
    """Whether the start of a file is text: UTF-8 without control characters other than tabs and line ends."""
    try:
        content.decode("utf-8")
    except UnicodeDecodeError as error:
        if error.reason != "unexpected end of data":
            return False
    return bool(content) and not _no_text(content.replace(b"\r", b"\n"))


def _no_text(raw: bytes) -> str:
    """Why the bytes are not a line of text; empty if they are."""
    plain = raw.replace(b"\r\n", b"\n")
    odd = next((byte for byte in plain if byte < 32 and byte not in b"\t\n"), None)
    return "" if odd is None else f"holds a byte of {odd:#04x}: must be text"


def _cells(line: str, separator: str) -> list[str]:
    return line.split() if separator == " " else [cell.strip() for cell in line.split(separator)]


def _separator(line: str) -> str:
    if line.count(";") >= 3:  # commas are then decimal marks
        return ";"
    return next((mark for mark in ",;" if mark in line), "\t" if line.count("\t") >= 3 else " ")


def read_layout(file: BinaryIO) -> Layout:
    """Read a text file from its start to its first event.

    Raises:
        RecordingError: a line before the first event that is not a header, sensor size or comment.
    """
    offset = lines = 0
    naming: Naming | None = None
    sensor: Sensor | None = None
    while raw := file.readline(LONGEST_LINE_BYTES):
        if offset > _MOST_HEADER_BYTES or lines > _MOST_HEADER_LINES:
            most = f"{_MOST_HEADER_LINES} lines and {_MOST_HEADER_BYTES} bytes"
            raise RecordingError(f"line {lines + 1}: no event before it: what stands before the first must be at most {most}")
        what = _no_text(raw)
        if what:
            raise RecordingError(f"line {lines + 1}: {what}")
        line = raw.decode("utf-8-sig" if offset == 0 else "utf-8", "replace").strip(" \r\n")
        passed = line[:1] in ("", "#", "%")
        geometry = _GEOMETRY.fullmatch(line) if passed else None
        sensor = (_side(geometry[1], lines), _side(geometry[2], lines)) if geometry else sensor
        if naming is None and not _EVENT_START.match(line):
            try:
                naming, stated = _header(line.lstrip("#% "))
                sensor = stated or sensor
            except RecordingError as error:
                if not passed:
                    raise RecordingError(f"line {lines + 1}: {line[:_SHOWN]!r}: is not an event: {error}") from error
        elif not passed:
            cells = _cells(line, _separator(line))
            if naming is not None or sensor is not None or len(cells) != 2 or not all(map(str.isdecimal, cells)):
                if naming is not None:
                    return _layout(offset, lines, _separator(line), cells, naming, sensor)
                order = _order(file, cells, _separator(line))
                layout = _layout(offset, lines, _separator(line), cells, Naming(order, None), sensor)
                return replace(layout, unnamed_order=order_text(order))
            sensor = _side(cells[0], lines), _side(cells[1], lines)
        offset, lines = offset + len(raw), lines + 1
    return _layout(offset, lines, " ", [], naming or _UNNAMED, sensor)


def _order(file: BinaryIO, event: Sequence[str], separator: str) -> tuple[int, int, int, int]:
    """Which of the first four cells are t, x, y, p, judged by the first event and the lines that follow."""
    rows: list[list[float]] = []
    cells = event
    while len(rows) < SAMPLED_ROWS:
        try:
            plain = [cell.replace(",", ".") if separator == ";" else cell for cell in cells[:_JUDGED_CELLS]]
            row = [float(_TRUTHS.get(cell.lower(), cell)) for cell in plain]
        except ValueError:
            break
        if len(row) < 4 or (rows and len(row) != len(rows[0])):
            break
        rows.append(row)
        raw = file.readline(LONGEST_LINE_BYTES)
        cells = _cells(raw.decode("utf-8", "replace").strip(" \r\n"), separator)
    return column_order(np.array(rows).reshape(len(rows), -1) if rows else np.empty((0, 4)))


def _header(line: str) -> tuple[Naming, Sensor | None]:
    """The fields named in a header line, and the sensor if it has `x@346` and `y@260`."""
    cells = [cell.partition("@") for cell in _cells(line, _separator(line))]
    naming = find_fields([name for name, _, _ in cells])
    width, height = (cells[i][2] for i in naming.columns[1:3])
    if not (width.isdecimal() and height.isdecimal()):
        return naming, None
    sides = whole_number(width), whole_number(height)
    if sides[0] is None or sides[1] is None:
        raise RecordingError(f"must name a sensor of at most 65536 pixels a side, not of {max(len(width), len(height))} digits")
    return naming, (sides[0], sides[1])


def _side(digits: str, lines: int) -> int:
    """A side of the sensor, parsed from the line after `lines` lines."""
    side = whole_number(digits)
    if side is None:
        raise RecordingError(f"line {lines + 1}: a sensor's side of {len(digits)} digits: must be a number up to 65536")
    return side


def _layout(offset: int, lines: int, separator: str, event: Sequence[str], naming: Naming, sensor: Sensor | None) -> Layout:
    places = naming.columns
    columns = np.full(max(*places, len(event) - 1) + 1, UNUSED, np.int8)
    columns[list(places)] = T, X, Y, P
    decimal_comma = separator == ";" and any("," in cell for cell in event)
    if naming.power is not None:
        return Layout(offset, lines, separator, columns, naming.power, False, sensor, decimal_comma=decimal_comma)
    in_seconds = places[0] < len(event) and any(mark in event[places[0]] for mark in ".,eE")
    power = 6 if in_seconds else 0
    return Layout(offset, lines, separator, columns, power, not in_seconds, sensor, decimal_comma=decimal_comma)


_CHUNK_BYTES = BLOCK_EVENTS * SHORTEST_LINE_BYTES
_NEWLINE = ord("\n")


class _Parsed(NamedTuple):
    """The events of some lines, the number of these lines, and the error in the next line, None if there is none."""

    events: Events
    lines: int
    fault: str | None


class _TextSource(AnySensor):
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
