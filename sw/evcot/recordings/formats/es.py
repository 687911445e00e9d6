# SPDX-License-Identifier: Apache-2.0
"""Event Stream 2 (.es), DVS and ATIS events.

Layout: the specification of neuromorphic-paris/event_stream. An event is five bytes: time since the previous event, with the
event's kind in the low bits, then x and y. Bytes with which no event can start add to the time, or are padding. The origin is
at the bottom left, as in other readers and writers of this format, and time starts from 0.

Decoded here because each event depends on the ones before it, so that damage must be reported with its offset; faery 0.7 takes
a truncated event for the end of the recording.
"""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from ..._numba_private import njit
from ...errors import RecordingError
from ...events import Events
from .sensors import mirrored
from .source import BLOCK_EVENTS, AnySensor, Format, Sensor

__all__ = ["FORMATS", "MAGIC", "EsFile"]

MAGIC = b"Event Stream"

_HEADER = struct.Struct(f"<{len(MAGIC)}s3sBHH")  # magic, version, kind of events, width, height
_VERSION = 2
_DVS, _ATIS = 1, 2
_EVENT_BYTES = 5


@njit(cache=True, nogil=True)
def _decode(data, atis, t_us, t, x, y, p):  # type: ignore[no-untyped-def]
    """Decode the complete events in `data` into t, x, y, p; returns their number, the offset after them, and the last time."""
    n, at = 0, 0
    while at < len(data):
        first = np.int64(data[at])
        if atis and first >= 0xFC:
            t_us += 63 * (first & 3)
            at += 1
        elif not atis and first >= 0xFE:
            t_us += 127 * (first & 1)
            at += 1
        elif at + _EVENT_BYTES > len(data):
            break
        else:
            t_us += first >> 2 if atis else first >> 1
            if not (atis and first & 1):
                t[n] = t_us
                x[n] = data[at + 1] | np.uint16(data[at + 2]) << 8
                y[n] = data[at + 3] | np.uint16(data[at + 4]) << 8
                p[n] = first >> 1 & 1 if atis else first & 1
                n += 1
            at += _EVENT_BYTES
    return n, at, t_us


class EsFile(AnySensor):
    """The brightness changes of an ES file; the exposure events of an ATIS are skipped. See `source.Source`."""

    def __init__(self, path: Path) -> None:
        self._path = path
        with path.open("rb") as file:
            header = file.read(_HEADER.size)
        if len(header) < _HEADER.size:
            raise RecordingError(f"ends within its header, at byte {len(header)}: must be at least {_HEADER.size} bytes")
        _, version, kind, width, height = _HEADER.unpack(header)
        if version[0] != _VERSION:
            raise RecordingError(f"ES version {version[0]}: must be {_VERSION}")
        if kind not in (_DVS, _ATIS):
            raise RecordingError(f"ES events of kind {kind}: must be {_DVS} (DVS) or {_ATIS} (ATIS)")
        self._atis = kind == _ATIS
        self.sensor: Sensor | None = (width, height)
        self.details: Mapping[str, str] = {"events": "ATIS" if self._atis else "DVS", "version": ".".join(map(str, version))}
        self.left_out: Counter[str] = Counter()
        self.remarks: list[str] = []

    def blocks(self, from_us: int | None = None) -> Iterator[Events]:
        """See `source.Source`. A time is found by reading up to it: every event depends on the ones before."""
        _, height = self.sensor or (0, 0)
        t_us, at, rest = 0, _HEADER.size, b""
        with self._path.open("rb") as file:
            file.seek(at)
            while chunk := file.read(BLOCK_EVENTS * _EVENT_BYTES):
                data = np.frombuffer(rest + chunk, np.uint8)
                most = len(data) // _EVENT_BYTES
                found = Events.allocated(most)
                count, used, t_us = _decode(data, self._atis, t_us, found.t_us, found.x, found.y, found.p)
                at, rest = at + used, data[used:].tobytes()
                found = found[:count]
                yield Events(found.t_us, found.x, mirrored(found.y, height), found.p)
        if rest:
            raise RecordingError(f"ends within an event, at byte {at + len(rest)}; is it cut off?")

    def close(self) -> None:
        """Do nothing: no file stays open between passes."""


FORMATS = (Format("es", "Event Stream", lambda start, _: start.startswith(MAGIC), EsFile),)
