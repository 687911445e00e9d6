# SPDX-License-Identifier: Apache-2.0
"""NumPy's own files: .npz with one array per field."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ..errors import RecordingError
from ..events import Events
from .columns import Decoded, Sensor, events_from_columns
from .source import Format, WritableFormat
from .whole import opens_whole

__all__ = ["FORMATS", "WRITABLE"]

_NPZ_FIELDS = ("t_us", "x", "y", "p", "width", "height")


def _read_npz(path: Path) -> Decoded:
    try:
        # Opened here: NumPy would leave the file of a damaged archive open.
        with path.open("rb") as file, np.load(file, allow_pickle=False) as content:
            missing = [field for field in _NPZ_FIELDS if field not in content]
            if missing:
                raise RecordingError(f"has no array {', '.join(missing)}: must have {', '.join(_NPZ_FIELDS)}")
            events = events_from_columns(*(content[field] for field in _NPZ_FIELDS[:4]))
            width, height = (int(content[field]) for field in _NPZ_FIELDS[4:])
    except (zipfile.BadZipFile, zlib.error, EOFError, KeyError, TypeError, NotImplementedError) as error:
        raise RecordingError(f"is a damaged npz: {' '.join(str(error).split())}") from error
    except RecordingError:
        raise
    except ValueError as error:
        raise RecordingError(f"is a damaged npz: {' '.join(str(error).split())}") from error
    return Decoded(events, (width, height))


class _NpzSink:
    def __init__(self, file: BinaryIO, sensor: Sensor) -> None:
        self._file, self._sensor = file, sensor
        self._blocks: list[Events] = []

    def write(self, events: Events) -> None:
        self._blocks.append(events)

    def close(self) -> None:
        events = Events.joined(self._blocks)
        width, height = self._sensor
        np.savez(self._file, t_us=events.t_us, x=events.x, y=events.y, p=events.p, width=width, height=height)


FORMATS = (Format("npz", "NumPy npz", lambda start, _: start.startswith(b"PK\x03\x04"), opens_whole(_read_npz)),)
WRITABLE = (WritableFormat("npz", "NumPy npz", ".npz", _NpzSink),)
