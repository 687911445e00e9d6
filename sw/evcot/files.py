# SPDX-License-Identifier: Apache-2.0
"""Recordings from and to files; what a file is, its content tells, whatever its name."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from .errors import RecordingError
from .events import Recording
from .formats.columns import Decoded, Sensor, events_from_columns
from .formats.native import AEDAT4_MAGIC, ES_MAGIC, read_aedat4, read_es
from .formats.prophesee import read_prophesee
from .formats.text import read_csv
from .outputs import written_aside

__all__ = ["read_recording", "write_npz"]

_SNIFF_BYTES = 512
_NPZ_FIELDS = ("t_us", "x", "y", "p", "width", "height")


def read_recording(path: Path | str, sensor: Sensor | None = None) -> Recording:
    """Read AEDAT4, Prophesee RAW (EVT 2, EVT 3), DAT, ES, CSV, or what `write_npz` wrote.

    Every event of the file is there, in the file's order and with the file's time: nothing is sorted, moved or dropped, but
    for events before a RAW file's first time mark, which have no time (a warning counts them).

    Args:
        path: the file; its content tells the format.
        sensor: (width, height) in pixels, in place of what the file says. Without it, a Prophesee file whose header has no
            size gets the smallest of `formats.prophesee.PROPHESEE_SENSORS` that holds every event, and a CSV without one the
            smallest size that does.

    Raises:
        RecordingError: the file is missing, unreadable, of no known format, empty, without events, cut off or damaged; or it
            holds an event outside the sensor, or one whose time runs backwards. One line: file, place, value, rule.
    """
    path = Path(path)
    name = path.stem
    try:
        decoded = _reader(path)(path)
        if not len(decoded.events):
            raise RecordingError("holds no events")
        width, height = sensor or decoded.sensor
        return Recording(decoded.events, width, height, name)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror or error}") from error
    except RecordingError as error:
        raise RecordingError(f"{path}: {str(error).removeprefix(f'{name}: ')}") from error


def _reader(path: Path) -> Callable[[Path], Decoded]:
    if path.exists() and not path.is_file():
        raise RecordingError("is a directory or a device: must be a file")
    with path.open("rb") as file:
        start = file.read(_SNIFF_BYTES)
    if not start:
        raise RecordingError("is empty")
    for magic, reader in (
        (AEDAT4_MAGIC, read_aedat4),
        (ES_MAGIC, read_es),
        (b"PK\x03\x04", _read_npz),
        (b"% ", read_prophesee),
    ):
        if start.startswith(magic):
            return reader
        if magic.startswith(start):
            raise RecordingError(f"ends after {len(start)} bytes: too early to hold an event")
    if start.startswith(b"#!AER-DAT"):
        raise RecordingError(f"is {start[2:12].decode('ascii', 'replace').strip()}: of AEDAT, only version 4.0 can be read")
    if start.isascii() and start.decode("ascii").replace("\r", "").replace("\n", "").replace("\t", "").isprintable():
        return read_csv
    raise RecordingError("is of no known format: must be AEDAT4, Prophesee RAW or DAT, ES, CSV or npz")


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


def write_npz(recording: Recording, path: Path | str) -> None:
    """Write a recording as arrays t_us, x, y, p, width, height; the file appears under its name only when it is whole.

    Raises:
        OutputError: the file cannot be written.
    """
    events = recording.events
    with written_aside(Path(path)) as file:
        np.savez(file, t_us=events.t_us, x=events.x, y=events.y, p=events.p, width=recording.width, height=recording.height)
