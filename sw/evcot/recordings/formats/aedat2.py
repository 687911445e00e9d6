# SPDX-License-Identifier: Apache-2.0
"""AEDAT 2.0 and 1.0, as jAER writes them.

Layout: iniVation's pages on AEDAT 2.0 and 1.0; address bits, polarity convention and origin after jAER's extractors
(DVS128.Extractor, DavisChip, DavisBaseCamera). Lines that start with "#", then records of a big-endian address (32 bits; 16 in
1.0) and a 32-bit time in microseconds that wraps around.

- DVS128: bit 0 is 1 for darker, x in bits 1 to 7, y in bits 8 to 14. With bit 15 (sync input) or 31 set: not an event.
- DAVIS: bit 11 is 1 for brighter, x in bits 12 to 21, y in bits 22 to 30. With bit 31 (frame or IMU sample) or 10 (external
  input) set: not an event.

In both, y counts from the bottom and x from the right; this reader mirrors x, as jAER does.

The chip is named by the line "# AEChip:", else by "# HardwareInterface:". Without either, a DVS128 is assumed if no address
has a bit set in 16 to 30, else the smallest DAVIS that holds all events.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ...errors import RecordingError
from ...events import Events
from .printable import shortened
from .sensors import chip_sensor, mirrored
from .source import BLOCK_EVENTS, AnySensor, Format, Sensor

__all__ = ["FORMATS", "Aedat2File"]

_RECORDS = {
    b"#!AER-DAT1.0": np.dtype([("address", ">u2"), ("t", ">u4")]),
    b"#!AER-DAT2.0": np.dtype([("address", ">u4"), ("t", ">u4")]),
}
_MAGIC_BYTES = 12
_LINE_BYTES_MAX = 1 << 16
# jAER writes the camera's settings into the header, hundreds of kilobytes of XML.
_HEADER_BYTES_MAX = 1 << 24
_HEADER_LINES_MAX = 1 << 18
_KEPT_LINES = 1 << 10
_CONTROL = re.compile(rb"[\x00-\x08\x0a-\x1f]")
_KEYS = ("AEChip:", "HardwareInterface:")
_TURN_US = 1 << 32
# A time is located by bisection if this many samples, evenly spread over the file, do not decrease; reading starts a little
# before it, since records of different kinds may be slightly out of order.
_PROBES = 257
_READ_AHEAD = 4096


@dataclass(frozen=True)
class _Layout:
    """Bit layout of an address. `other`: bits that mark a record as not an event; `spare`: bits that such a chip never sets."""

    other: int
    spare: int
    p_shift: int
    darker: int
    x_shift: int
    x_mask: int
    y_shift: int
    y_mask: int

    def x(self, address: NDArray[Any]) -> NDArray[Any]:
        return address >> self.x_shift & self.x_mask

    def y(self, address: NDArray[Any]) -> NDArray[Any]:
        return address >> self.y_shift & self.y_mask


_DVS128 = _Layout(0x8000_8000, 0x7FFF_0000, p_shift=0, darker=1, x_shift=1, x_mask=0x7F, y_shift=8, y_mask=0x7F)
_DAVIS = _Layout(0x8000_0400, 0, p_shift=11, darker=0, x_shift=12, x_mask=0x3FF, y_shift=22, y_mask=0x1FF)
_DAVIS_SENSORS = ((240, 180), (346, 260), (640, 480))


@dataclass(frozen=True)
class _Chip:
    name: str
    layout: _Layout
    sensor: Sensor


class Aedat2File(AnySensor):
    """The brightness changes of an AEDAT 2.0 or 1.0 file. See `source.Source`.

    Raises:
        RecordingError: the header is truncated, or names a chip of unknown layout.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.left_out: Counter[str] = Counter()
        self.remarks: list[str] = []
        with path.open("rb") as file:
            self._record = _RECORDS[file.read(_MAGIC_BYTES)]
            file.seek(0)
            lines, self._begin = _read_header(file)
            self._count, self._rest = divmod(path.stat().st_size - self._begin, self._record.itemsize)
            chip = _named_chip(lines) or self._guess_chip(file)
        if chip.layout is _DAVIS and self._record["address"].itemsize == 2:
            raise RecordingError(f"header: chip {shortened(chip.name)!r}: must be a DVS128 in AEDAT 1.0")
        self._chip = chip
        self.sensor: Sensor | None = chip.sensor
        self.details: Mapping[str, str] = {"chip": chip.name}

    def _guess_chip(self, file: BinaryIO) -> _Chip:
        """The chip inferred from the addresses, see the module docstring."""
        bits = width = height = 0
        for records in self._records(file, 0):
            address = records["address"].astype(np.uint32)
            bits |= int(np.bitwise_or.reduce(address, initial=0))
            address = address[address & _DAVIS.other == 0]
            width = max(width, int(_DAVIS.x(address).max(initial=0)) + 1)
            height = max(height, int(_DAVIS.y(address).max(initial=0)) + 1)
        if bits & _DVS128.spare == 0:
            return _Chip("none named, a DVS128 by its addresses", _DVS128, (128, 128))
        for sensor in _DAVIS_SENSORS:
            if width <= sensor[0] and height <= sensor[1]:
                return _Chip(f"none named, a DAVIS of {sensor[0]}x{sensor[1]} by its addresses", _DAVIS, sensor)
        raise RecordingError(f"header names no chip, and none that is known has {width}x{height} pixels")

    def _records(self, file: BinaryIO, first: int) -> Iterator[NDArray[np.void]]:
        file.seek(self._begin + first * self._record.itemsize)
        for at in range(first, self._count, BLOCK_EVENTS):
            data = file.read(min(BLOCK_EVENTS, self._count - at) * self._record.itemsize)
            yield np.frombuffer(data, self._record, len(data) // self._record.itemsize)

    def blocks(self, from_us: int | None = None) -> Iterator[Events]:
        """See `source.Source`."""
        layout, (width, height) = self._chip.layout, self._chip.sensor
        self.left_out = Counter()
        before: tuple[int, int] | None = None
        with self._path.open("rb") as file:
            for records in self._records(file, 0 if from_us is None else self._find(file, from_us)):
                address, t_us = records["address"].astype(np.uint32), records["t"].astype(np.int64)
                event = address & layout.other == 0
                strange = event & (address & layout.spare != 0)
                if strange.any():
                    self.left_out["address bits that the chip does not have"] += int(np.count_nonzero(strange))
                    event &= ~strange
                if not event.all():
                    address, t_us = address[event], t_us[event]
                if not len(address):
                    continue
                t_us, before = _unwrapped(t_us, before)
                yield Events(
                    t_us,
                    mirrored(layout.x(address), width),
                    mirrored(layout.y(address), height),
                    (address >> layout.p_shift & 1 ^ layout.darker).astype(np.uint8),
                )
        if self._rest:
            raise RecordingError(
                f"{self._rest} bytes behind the last record: records must be of {self._record.itemsize} bytes; is it cut off?"
            )

    def _find(self, file: BinaryIO, from_us: int) -> int:
        """The latest record that precedes all events from a time on; 0 where times wrap around or decrease."""

        def time_of(index: int) -> int:
            file.seek(self._begin + index * self._record.itemsize)
            return int(np.frombuffer(file.read(self._record.itemsize), self._record)["t"][0])

        if not self._count:
            return 0
        probes = [time_of(int(index)) for index in np.linspace(0, self._count - 1, _PROBES)]
        if probes != sorted(probes):
            return 0
        return max(0, bisect_left(range(self._count), from_us, key=time_of) - _READ_AHEAD)

    def close(self) -> None:
        """Do nothing: no file stays open between passes."""


def _read_header(file: BinaryIO) -> tuple[list[str], int]:
    """The header lines that may name the chip, without their "#", and the offset of the first record.

    The first record may start with the code of "#", too, but usually has a control character before the next newline. jAER's
    newer files mark the end of the header with a line of its own.
    """
    lines: list[str] = []
    at = 0
    for _ in range(_HEADER_LINES_MAX):
        line = file.readline(_LINE_BYTES_MAX)
        text = line.rstrip(b"\r\n")
        if not line.startswith(b"#") or _CONTROL.search(text):
            return lines, at
        if not line.endswith(b"\n"):
            raise RecordingError(f"header line at byte {at}: must end in a newline; is it cut off?")
        at += len(line)
        said = text[1:].decode("latin-1").strip()
        if said.startswith(_KEYS) and len(lines) < _KEPT_LINES:
            lines.append(said)
        if said.lower() == "end of ascii header":
            return lines, at
        if at > _HEADER_BYTES_MAX:
            break
    raise RecordingError(
        f"header does not end by byte {at}: must have at most {_HEADER_LINES_MAX} lines and {_HEADER_BYTES_MAX} bytes"
    )


def _named_chip(lines: list[str]) -> _Chip | None:
    for key in _KEYS:
        for name in (line.removeprefix(key).strip() for line in lines if line.startswith(key)):
            sensor = chip_sensor(name)
            if sensor is not None:
                return _Chip(name, _DVS128 if re.search("dvs128|tmpdiff128", name.lower()) else _DAVIS, sensor)
            if key == "AEChip:":
                raise RecordingError(f"header: chip {shortened(name)!r}: must be a DVS128, or a DAVIS of known size")
    return None


def _unwrapped(t_us: NDArray[np.int64], before: tuple[int, int] | None) -> tuple[NDArray[np.int64], tuple[int, int]]:
    """Unwrap 32-bit times; `before`: last time and wrap-around count of the previous block."""
    last, turns = before or (int(t_us[0]), 0)
    steps = np.diff(t_us, prepend=last)
    turn = turns + np.cumsum((steps < -_TURN_US // 2).astype(np.int64) - (steps > _TURN_US // 2))
    return t_us + turn * _TURN_US, (int(t_us[-1]), int(turn[-1]))


FORMATS = (Format("aedat2", "AEDAT 2.0", lambda start, _: start[:_MAGIC_BYTES] in _RECORDS, Aedat2File),)
