# SPDX-License-Identifier: Apache-2.0
"""Prophesee files: a header, then words of EVT 2.0, EVT 2.1, EVT 3.0 or DAT, as stated in the header.

Every event keeps the time encoded in its words. The words are decoded here because faery 0.7 replaces a decreasing time by
the latest one seen: that hides a damaged file, and shifts events of a valid EVT 3 file, in which a camera's periodic time
mark may be a few microseconds ahead of the events after it.

A camera's stream may start between two time marks. Events before the first one have no time: they are left out and counted.
"""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..._numba_private import njit
from ...errors import RecordingError
from .evt2 import evt2_layout, evt21_layout, is_upper_first
from .evt3 import evt3_layout
from .evt_writers import Evt2Sink, Evt3Sink
from .prophesee_header import HEADER_BYTES, Header, parse_header
from .source import Format, Sensor, WritableFormat
from .words import Layout, WordArray, WordFile, Words, advance, place_of_mark

__all__ = ["FORMATS", "PROPHESEE_SENSORS", "WRITABLE", "dat_layout"]


# DAT: 64-bit words, one event each: a 32-bit time that wraps around every 71.6 minutes, then x, y and polarity.
#
# https://docs.prophesee.ai/stable/data/file_formats/dat.html

_MARK_RANGE = 1 << 32
# version -> bits of x and of y
_ADDRESS_BITS = {1: (9, 8), 2: (14, 14)}


class _State(NamedTuple):
    """last: unwrapped time of the previous event, -1 before the first."""

    t0_us: int
    x_bits: int
    y_bits: int
    last: int = -1


@njit(cache=True, nogil=True)
def _fill(words, state, t_us, x, y, p):  # type: ignore[no-untyped-def]
    t0_us, x_bits, y_bits, last = state
    n = min(len(words), len(t_us))
    for i in range(n):
        address = np.int64(words[i] >> np.uint64(32))
        last = advance(last, np.int64(words[i] & np.uint64(_MARK_RANGE - 1)), _MARK_RANGE)
        t_us[i] = t0_us + last
        x[i] = address & ((1 << x_bits) - 1)
        y[i] = address >> x_bits & ((1 << y_bits) - 1)
        p[i] = address >> (x_bits + y_bits) & 15 != 0
    return n, n, _State(t0_us, x_bits, y_bits, last)


@njit(cache=True, nogil=True)
def _first_mark(words, least):  # type: ignore[no-untyped-def]
    for i in range(len(words)):
        mark = np.int64(words[i] & np.uint64(_MARK_RANGE - 1))
        if mark >= least:
            return i, mark
    return len(words), 0


def dat_layout(t0_us: int, version: int) -> Layout:
    """DAT of version 1 or 2, times from `t0_us`."""
    start = _State(t0_us, *_ADDRESS_BITS[version])

    def first_mark(piece: WordArray, least: int) -> tuple[int, int]:
        index, mark = _first_mark(piece, least)
        return index, mark

    def seek(words: Words, from_us: int) -> tuple[int, _State]:
        return place_of_mark(words, first_mark, from_us - t0_us), start

    return Layout(np.dtype(np.uint64), 1, start, _fill, seek, {})


# If a header does not state the size, the smallest of these that holds every event is assumed.
PROPHESEE_SENSORS: tuple[Sensor, ...] = ((304, 240), (320, 320), (480, 360), (640, 480), (1280, 720))

# The second byte of a DAT payload's preamble; the first is the kind of event: 0 and 12 are brightness changes.
_DAT_EVENT_BYTES = 8
_DAT_CHANGES = (0, 12)

_EVT_NAMES = {"2": "evt2", "2.1": "evt21", "3": "evt3"}


def _smallest_sensor(width: int, height: int) -> Sensor:
    fitting = (sensor for sensor in PROPHESEE_SENSORS if width <= sensor[0] and height <= sensor[1])
    return next(fitting, PROPHESEE_SENSORS[-1])


def _read_header(path: Path) -> Header:
    with path.open("rb") as file:
        return parse_header(file.read(HEADER_BYTES))


def _is(name: str, start: bytes, path: Path) -> bool:
    """Whether the file is of that format; a damaged header counts as DAT, whose reader then reports the damage. A digit
    behind lines that begin with % is text: the payload of DAT begins with a control character."""
    if not start.startswith(b"% "):
        return False
    try:
        header = _first_header(start, path)
        version = header.evt_version
        if version is None and start[header.length : header.length + 1].isdigit():
            return False
    except RecordingError:
        version = None
    return name == _EVT_NAMES.get(version or "", "dat")


def _first_header(start: bytes, path: Path) -> Header:
    with suppress(RecordingError):
        header = parse_header(start)
        if header.length < len(start):
            return header
    return _read_header(path)


def _open(path: Path, layout: Layout, header: Header, offset: int) -> WordFile:
    sensor, details = header.sensor, header.details
    words = Words(path, offset, layout.dtype)
    details["words"] = f"{len(words)} of {8 * layout.dtype.itemsize} bits"
    source = WordFile(words, layout, sensor, details, _smallest_sensor)
    source.remarks = header.remarks
    return source


def _open_evt2(path: Path) -> WordFile:
    header = _read_header(path)
    return _open(path, evt2_layout(header.t0_us), header, header.length)


def _open_evt21(path: Path) -> WordFile:
    header = _read_header(path)
    layout = evt21_layout(header.t0_us, upper_first=False)
    upper_first = header.endianness == "legacy"
    if header.endianness is None:
        words = Words(path, header.length, layout.dtype)
        upper_first = is_upper_first(words[: 1 << 16])
        words.close()
    if upper_first:
        layout = evt21_layout(header.t0_us, upper_first)
    source = _open(path, layout, header, header.length)
    source.details = {**source.details, "order": "legacy" if upper_first else "little"}
    return source


def _open_evt3(path: Path) -> WordFile:
    header = _read_header(path)
    return _open(path, evt3_layout(header.t0_us), header, header.length)


def _open_dat(path: Path) -> WordFile:
    header = _read_header(path)
    if header.evt_version is not None:
        raise RecordingError(f"EVT version {header.evt_version}: must be 2.0, 2.1 or 3.0")
    version = header.fields.get("version", "2")
    if version not in ("1", "2"):
        raise RecordingError(f"DAT version {version}: must be 1 or 2")
    with path.open("rb") as file:
        file.seek(header.length)
        preamble = file.read(2)
    if len(preamble) < 2:
        raise RecordingError("the header names no EVT version, and no DAT event type and size follow it; is it cut off?")
    if preamble[0] not in _DAT_CHANGES or preamble[1] != _DAT_EVENT_BYTES:
        raise RecordingError(
            f"the header names no EVT version, and DAT event type {preamble[0]} of {preamble[1]} bytes follows it: "
            f"must be one of {_DAT_CHANGES} of {_DAT_EVENT_BYTES}"
        )
    return _open(path, dat_layout(header.t0_us, int(version)), header, header.length + len(preamble))


FORMATS = (
    Format("evt2", "Prophesee RAW, EVT 2.0", partial(_is, "evt2"), _open_evt2),
    Format("evt21", "Prophesee RAW, EVT 2.1", partial(_is, "evt21"), _open_evt21),
    Format("evt3", "Prophesee RAW, EVT 3.0", partial(_is, "evt3"), _open_evt3),
    Format("dat", "Prophesee DAT", partial(_is, "dat"), _open_dat),
)
# The first is the default for the suffix .raw.
WRITABLE = (
    WritableFormat("evt3", "Prophesee RAW, EVT 3.0", ".raw", Evt3Sink),
    WritableFormat("evt2", "Prophesee RAW, EVT 2.0", ".raw", Evt2Sink),
)
