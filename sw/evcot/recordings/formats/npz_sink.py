# SPDX-License-Identifier: Apache-2.0
"""NumPy .npz writer: arrays t_us, x, y, p, width, height, not compressed, readable with `numpy.load`.

The format stores field by field what arrives block by block, so blocks are spooled to an unnamed file on the same disk.
"""

from __future__ import annotations

import tempfile
import weakref
import zipfile
from pathlib import Path
from typing import IO, Any, BinaryIO

import numpy as np

from ...events import Events
from .source import Sensor, WritableFormat

__all__ = ["WRITABLE"]

_FIELDS: dict[str, np.dtype[Any]] = {
    name: np.dtype(of) for name, of in (("t_us", "<i8"), ("x", "<u2"), ("y", "<u2"), ("p", "u1"))
}
_EVENT_BYTES = sum(dtype.itemsize for dtype in _FIELDS.values())


class _NpzSink:
    """See `source.Sink`."""

    def __init__(self, file: BinaryIO, sensor: Sensor) -> None:
        self._file, self._sensor = file, sensor
        self._counts: list[int] = []
        self._spool: IO[bytes] = tempfile.TemporaryFile(dir=Path(file.name).parent)  # noqa: SIM115
        weakref.finalize(self, self._spool.close)

    def write(self, events: Events) -> None:
        """See `source.Sink`."""
        for field, dtype in _FIELDS.items():
            self._spool.write(np.ascontiguousarray(getattr(events, field), dtype).data)
        self._counts.append(len(events))

    def close(self) -> None:
        """See `source.Sink`."""
        with zipfile.ZipFile(self._file, "w", zipfile.ZIP_STORED) as archive:
            skipped = 0
            for field, dtype in _FIELDS.items():
                with _member(archive, field) as member:
                    np.lib.format.write_array_header_1_0(
                        member, {"descr": dtype.str, "fortran_order": False, "shape": (sum(self._counts),)}
                    )
                    self._copy(member, skipped, dtype.itemsize)
                skipped += dtype.itemsize
            for name, size in zip(("width", "height"), self._sensor, strict=True):
                with _member(archive, name) as member:
                    np.lib.format.write_array(member, np.array(size), (1, 0))
        self._spool.close()

    def _copy(self, member: IO[bytes], skipped_bytes: int, item_bytes: int) -> None:
        """Copy one field of every block; in a block, `skipped_bytes` per event precede this field."""
        at = 0
        for count in self._counts:
            self._spool.seek(at + count * skipped_bytes)
            member.write(self._spool.read(count * item_bytes))
            at += count * _EVENT_BYTES


def _member(archive: zipfile.ZipFile, name: str) -> IO[bytes]:
    return archive.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True)


WRITABLE = (WritableFormat("npz", "NumPy npz", ".npz", _NpzSink),)
