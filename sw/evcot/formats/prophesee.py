# SPDX-License-Identifier: Apache-2.0
"""Prophesee's files: an ASCII header of lines that start with `% `, then the words of EVT 2, EVT 3 or DAT.

Every event keeps the time that its own words give. The words are decoded here because faery 0.7 replaces a time that
runs backwards by the latest one seen: that hides a damaged file, and moves events of a good EVT 3 file, where a camera's
periodic time mark may run a few microseconds ahead of the events after it.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..errors import RecordingError
from ..events import Events
from . import evt
from .columns import Decoded, Sensor, smallest_sensor
from .source import Format
from .whole import opens_whole

__all__ = ["FORMATS", "PROPHESEE_SENSORS", "Header", "parse_header", "read_dat", "read_evt", "read_prophesee"]

_Word = TypeVar("_Word", bound=np.unsignedinteger)

# Where a header leaves the size out: the smallest of these that holds every event is taken.
PROPHESEE_SENSORS: tuple[Sensor, ...] = ((304, 240), (320, 320), (480, 360), (640, 480), (1280, 720))

_DAT_WRAP_US = 1 << 32
# The second byte of a DAT payload's preamble; the first is the kind of event: 0 and 12 are brightness changes.
_DAT_EVENT_BYTES = 8
_DAT_CHANGES = (0, 12)


@dataclass(frozen=True)
class Header:
    """The `% key value` lines, keys in lower case, and the offset in bytes of what follows them."""

    fields: dict[str, str]
    length: int

    @property
    def _format(self) -> tuple[str, dict[str, str]]:
        """`EVT3;height=720;width=1280` as ("evt3", {"height": "720", "width": "1280"})."""
        name, *options = self.fields.get("format", "").lower().replace(" ", "").split(";")
        return name, dict(option.split("=", 1) for option in options if "=" in option)

    @property
    def evt_version(self) -> str | None:
        """`2`, `2.1` or `3`, as `evt` or `format` say; None in the header of a DAT file."""
        version = self.fields.get("evt", "") or self._format[0].removeprefix("evt")
        return {"21": "2.1"}.get(version, version.removesuffix(".0")) or None

    @property
    def sensor(self) -> Sensor | None:
        """(width, height) from `geometry`, `format`, or `Width` and `Height`; None where nothing says it."""
        options = self._format[1]
        for width, _, height in (
            self.fields.get("geometry", "").partition("x"),
            (options.get("width", ""), "", options.get("height", "")),
            (self.fields.get("width", ""), "", self.fields.get("height", "")),
        ):
            if width.strip().isdecimal() and height.strip().isdecimal():
                return int(width), int(height)
        return None

    @property
    def t0_us(self) -> int:
        """What to add to every time, microseconds."""
        t0 = self.fields.get("t0", "0")
        if not t0.isdecimal() or int(t0) >= 1 << 62:
            raise RecordingError(f"header: t0 = {t0}: must be a whole number of microseconds below 2^62")
        return int(t0)


def parse_header(content: bytes) -> Header:
    """Read the header at the start of `content`, which must hold the file as far as the header goes.

    Raises:
        RecordingError: the file ends within the header.
    """
    fields: dict[str, str] = {}
    at = 0
    while content.startswith(b"%", at) and content[at + 1 : at + 2] in (b" ", b""):
        end = content.find(b"\n", at)
        if end < 0:
            raise RecordingError(f"ends within its header, at byte {len(content)}: a header line must end in a newline")
        key, _, value = content[at + 1 : end].decode("latin-1").strip().partition(" ")
        at = end + 1
        if key.lower() == "end":
            break
        fields[key.lower()] = value.strip()
    return Header(fields, at)


def read_prophesee(path: Path) -> Decoded:
    """Read a RAW (EVT 2, EVT 3) or a DAT file; the header tells which."""
    with path.open("rb") as file:
        header = parse_header(file.read(1 << 16))
    return read_dat(path, header) if header.evt_version is None else read_evt(path, header)


def _words(path: Path, offset: int, dtype: type[_Word]) -> NDArray[_Word]:
    payload_bytes = path.stat().st_size - offset
    word_bytes = np.dtype(dtype).itemsize
    if payload_bytes % word_bytes:
        raise RecordingError(f"{payload_bytes} bytes of events: must be a multiple of {word_bytes}; is it cut off?")
    return np.fromfile(path, np.dtype(dtype).newbyteorder("<"), offset=offset)


def _sensor(header: Header, events: Events) -> Sensor:
    if header.sensor is not None:
        return header.sensor
    width, height = smallest_sensor(events)
    fitting = (sensor for sensor in PROPHESEE_SENSORS if width <= sensor[0] and height <= sensor[1])
    return next(fitting, PROPHESEE_SENSORS[-1])


def read_evt(path: Path, header: Header) -> Decoded:
    """Decode EVT 2.0 or EVT 3.0. Triggers and other words that are no brightness change are passed over.

    A camera's stream may start between two time marks. Events before the first one have no time: they are left out, with
    a warning that says how many.
    """
    t0_us = header.t0_us
    if header.evt_version == "2":
        events, untimed = evt.decode_evt2(_words(path, header.length, np.uint32), t0_us)
    elif header.evt_version == "3":
        events, untimed = evt.decode_evt3(_words(path, header.length, np.uint16), t0_us)
    else:
        raise RecordingError(f"EVT version {header.evt_version}: must be 2.0 or 3.0")
    if untimed:
        warnings.warn(f"{path}: the first {untimed} events precede any time mark and are left out", stacklevel=2)
    return Decoded(events, _sensor(header, events))


def read_dat(path: Path, header: Header) -> Decoded:
    """Decode DAT version 1 or 2 (the default): 32-bit times that wrap around, 9 + 8 or 14 + 14 bits of address."""
    version = header.fields.get("version", "2")
    if version not in ("1", "2"):
        raise RecordingError(f"DAT version {version}: must be 1 or 2")
    x_bits, y_bits = (9, 8) if version == "1" else (14, 14)
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
    words = _words(path, header.length + len(preamble), np.uint64)
    t_us = (words & np.uint64(_DAT_WRAP_US - 1)).astype(np.int64)
    wraps = np.flatnonzero(np.diff(t_us) < -_DAT_WRAP_US // 2) + 1
    for start in wraps:
        t_us[start:] += _DAT_WRAP_US
    t_us += header.t0_us
    address = (words >> np.uint64(32)).astype(np.uint32)
    x = (address & ((1 << x_bits) - 1)).astype(np.uint16)
    y = (address >> x_bits & ((1 << y_bits) - 1)).astype(np.uint16)
    p = (address >> (x_bits + y_bits) & 15 != 0).view(np.uint8)
    events = Events(t_us, x, y, p)
    return Decoded(events, _sensor(header, events))


FORMATS = (Format("prophesee", "Prophesee RAW or DAT", lambda start, _: start.startswith(b"% "), opens_whole(read_prophesee)),)
