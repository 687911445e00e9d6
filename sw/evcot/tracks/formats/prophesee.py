# SPDX-License-Identifier: Apache-2.0
"""Prophesee's `_bbox.npy`: a NumPy file of structured boxes, times in us. The first pixel begins at 0.

Files of 2020 have `ts` and `confidence` in place of `t` and `class_confidence`; both are read, the newer names are written, in
the layout of OpenEB's `EventBbox`.
"""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO

import numpy as np

from ...errors import TrackLogError
from ...outputs import note_input
from .base import BOX, Boxes, FrameClock

__all__ = ["EVENT_BBOX", "PropheseeBoxes"]

EVENT_BBOX = np.dtype(
    {
        "names": ["t", "x", "y", "w", "h", "class_id", "track_id", "class_confidence"],
        "formats": ["<i8", "<f4", "<f4", "<f4", "<f4", "<u4", "<u4", "<f4"],
        "offsets": [0, 8, 12, 16, 20, 24, 28, 32],
        "itemsize": 40,
    }
)
_OLDER = {"ts": "t", "confidence": "class_confidence"}
_EDGE = 0.5  # where the first pixel begins, 0, less where it does in evcot, -0.5
_TIME_MAX_US = 2**60


class PropheseeBoxes:
    """Labels and results of Prophesee's data sets and tools."""

    NAME, SUFFIX, TITLE = "prophesee", ".npy", "Prophesee boxes"

    @staticmethod
    def read(path: Path, clock: FrameClock) -> Boxes:
        """See `BoxFormat`; the file has times, so the clock is not needed."""
        note_input(path)
        try:
            with path.open("rb") as file:
                stored = np.load(file, allow_pickle=False)
        except OSError as error:
            raise TrackLogError(f"{path}: cannot be read: {error.strerror or error}") from error
        except (ValueError, EOFError) as error:
            raise TrackLogError(f"{path}: is no NumPy file: {' '.join(str(error).split())}") from error
        if not isinstance(stored, np.ndarray) or stored.dtype.names is None or stored.ndim != 1:
            raise TrackLogError(f"{path}: must hold one row a box, with the fields {', '.join(EVENT_BBOX.names or ())}")
        columns = {_OLDER.get(name, name): stored[name] for name in stored.dtype.names}
        for name in EVENT_BBOX.names or ():
            if name not in columns:
                raise TrackLogError(f"{path}: has no field {name}: must have {', '.join(EVENT_BBOX.names or ())}")
        for name, column in columns.items():
            if name not in (EVENT_BBOX.names or ()):
                raise TrackLogError(f"{path}: unknown field {name}: must have {', '.join(EVENT_BBOX.names or ())}")
            if column.dtype.kind not in "iuf" or column.ndim != 1:
                raise TrackLogError(f"{path}: field {name} is {column.dtype}: must be numbers")
        wrong = ~((columns["t"] >= 0) & (columns["t"] <= _TIME_MAX_US))
        if wrong.any():
            row = int(np.argmax(wrong))
            raise TrackLogError(f"{path}: box {row}: t = {columns['t'][row]}: must be from 0 to 2^60")
        instants_us, instant = np.unique(columns["t"].astype(np.int64), return_inverse=True)
        rows = np.zeros(len(stored), BOX)
        rows["instant"] = instant
        rows["id"], rows["class_id"] = columns["track_id"], columns["class_id"]
        rows["left"], rows["top"] = columns["x"].astype(np.float64) - _EDGE, columns["y"].astype(np.float64) - _EDGE
        rows["width"], rows["height"], rows["confidence"] = columns["w"], columns["h"], columns["class_confidence"]
        rows["visibility"], rows["counted"] = 1.0, True
        return Boxes(instants_us, rows)

    @staticmethod
    def write(file: BinaryIO, path: Path, boxes: Boxes, clock: FrameClock) -> None:
        """See `BoxFormat`; positions are rounded to the nearest 32-bit number."""
        rows = boxes.rows
        made = np.zeros(len(rows), EVENT_BBOX)
        made["t"] = boxes.instants_us[rows["instant"]]
        made["x"], made["y"] = rows["left"] + _EDGE, rows["top"] + _EDGE
        made["w"], made["h"], made["class_confidence"] = rows["width"], rows["height"], rows["confidence"]
        for name, source in (("track_id", "id"), ("class_id", "class_id")):
            wrong = (rows[source] < 0) | (rows[source] >= 1 << 32)
            if wrong.any():
                value = rows[source][int(np.argmax(wrong))]
                raise TrackLogError(f"{path}: {name} = {value}: must be from 0 to 2^32 - 1 in this format")
            made[name] = rows[source]
        np.save(file, made, allow_pickle=False)
