# SPDX-License-Identifier: Apache-2.0
"""CSV: one event per line, times in whole microseconds.

Read by NumPy: faery 0.7 would replace a time that runs backwards by the latest one seen.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import RecordingError
from .columns import Decoded, Sensor, events_from_columns, smallest_sensor
from .source import Format
from .whole import opens_whole

__all__ = ["FORMATS", "read_csv"]

_NAMES = {
    "t": ("t", "t_us", "timestamp"),
    "x": ("x",),
    "y": ("y",),
    "p": ("p", "on", "pol", "polarity"),
}
_ROW = np.dtype([("t", np.int64), ("x", np.int32), ("y", np.int32), ("p", np.int8)])


@dataclass(frozen=True)
class _Layout:
    """How a line is built: separator (None: blanks), columns of t, x, y, p, lines to pass over, and a size the header gives."""

    separator: str | None
    columns: tuple[int, int, int, int]
    skip: int
    sensor: Sensor | None


def _layout(first: str) -> _Layout:
    separator = next((mark for mark in ",;\t" if mark in first), None)
    if first[:1].isdecimal() or first[:1] == "-":
        return _Layout(separator, (0, 1, 2, 3), 0, None)
    cells = [cell.strip().lower().partition("@") for cell in first.lstrip("# ").split(separator)]
    columns = {field: [i for i, (name, _, _) in enumerate(cells) if name in known] for field, known in _NAMES.items()}
    wrong = [field for field, named in columns.items() if len(named) != 1]
    if wrong:
        raise RecordingError(f"line 1: {first[:60]!r}: must be an event, or name each of t, x, y, p once; {wrong[0]} is not")
    t, x, y, p = (named[0] for named in columns.values())
    width, height = cells[x][2], cells[y][2]
    stated = width.isdecimal() and height.isdecimal()
    return _Layout(separator, (t, x, y, p), 1, (int(width), int(height)) if stated else None)


def _ends_in_newline(path: Path) -> bool:
    with path.open("rb") as file:
        file.seek(-1, 2)
        return file.read(1) == b"\n"


def read_csv(path: Path) -> Decoded:
    """Read t, x, y, p in that order, or in the order that the first line names; other columns are passed over.

    Separated by comma, semicolon, tab or blanks. p is 1 where the pixel became brighter, 0 or -1 where darker. The sensor is
    what the first line says (`t,x@346,y@260,p`), else the smallest that holds every event.
    """
    try:
        with path.open(encoding="utf-8") as file:
            layout = _layout(file.readline().strip())
        # A cut in the polarity leaves no number behind; one in a longer last column leaves a wrong one.
        if layout.columns[3] != max(layout.columns) and not _ends_in_newline(path):
            raise RecordingError("the last line must end in a newline; is it cut off?")
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message=".*input contained no data")
            rows = np.loadtxt(
                path, _ROW, delimiter=layout.separator, usecols=layout.columns, skiprows=layout.skip, ndmin=1, encoding="utf-8"
            )
    except UnicodeDecodeError as error:
        raise RecordingError(f"is not text: byte {error.start} is {error.object[error.start]:#04x}") from error
    except RecordingError:
        raise
    except ValueError as error:
        raise RecordingError(f"{str(error).rstrip('.')}; must be whole numbers t (microseconds), x, y, p") from error
    rows["p"][rows["p"] == -1] = 0
    events = events_from_columns(rows["t"], rows["x"], rows["y"], rows["p"])
    return Decoded(events, layout.sensor or smallest_sensor(events))


def _is_text(start: bytes, _: Path) -> bool:
    return start.isascii() and start.decode("ascii").replace("\r", "").replace("\n", "").replace("\t", "").isprintable()


FORMATS = (Format("csv", "CSV", _is_text, opens_whole(read_csv)),)
