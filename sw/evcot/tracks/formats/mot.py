# SPDX-License-Identifier: Apache-2.0
"""MOTChallenge text: https://motchallenge.net/instructions. One box per line; frames, ids and pixels are counted from 1.

    frame, id, left, top, width, height, confidence, x, y, z               10 columns: results, detections (id -1), some truths
    frame, id, left, top, width, height, counted, class, visibility         9 columns: truths

The world coordinates x, y, z are not read, and written as -1. In a truth a box whose `counted` is 0 need not be found.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ...errors import TrackLogError
from ...outputs import note_input
from .base import BOX, FRAME_MAX, NOBODY, Boxes, FrameClock, decimal

__all__ = ["MotDetections", "MotResult", "MotTruth"]

_EDGE = 1.5  # where the first pixel begins, 1, less where it does in evcot, -0.5
_TRUTH, _RESULT = 9, 10  # columns
_INTEGER_MAX = 2**53
_NAMES = ("frame", "id", "left", "top", "width", "height", "confidence", "x", "y", "z")
_TRUTH_NAMES = (*_NAMES[:6], "counted", "class", "visibility")


class MotResult:
    """A tracker's result."""

    NAME, SUFFIX, TITLE = "mot", ".txt", "MOTChallenge result"

    @staticmethod
    def read(path: Path, clock: FrameClock) -> Boxes:
        """See `BoxFormat`; results, detections and truths are distinguished by their columns."""
        lines = _lines(path)
        if not lines:  # the result of a tracker that found nothing
            return Boxes(np.empty(0, np.int64), np.zeros(0, BOX), None, "line")
        columns = len(lines[0][1])
        if columns not in (_TRUTH, _RESULT):
            number, cells = lines[0]
            rule = f"must be {_TRUTH} (truth) or {_RESULT} (results, detections), separated by commas"
            raise TrackLogError(f"{path}: line {number}: {len(cells)} values: {rule}")
        names = _TRUTH_NAMES if columns == _TRUTH else _NAMES
        values = np.array([_values(path, number, cells, names) for number, cells in lines])
        frames = values[:, 0].astype(np.int64)
        rows = np.zeros(len(values), BOX)
        rows["instant"] = frames - 1
        rows["id"] = values[:, 1]
        rows["left"], rows["top"] = values[:, 2] - _EDGE, values[:, 3] - _EDGE
        rows["width"], rows["height"], rows["confidence"] = values[:, 4], values[:, 5], values[:, 6]
        rows["counted"] = values[:, 6] != 0
        rows["class_id"] = values[:, 7] if columns == _TRUTH else 1
        rows["visibility"] = values[:, 8] if columns == _TRUTH else 1.0
        every = np.arange(1, frames.max() + 1)
        return Boxes(clock.times_us(every, path), rows, None, "line", np.array([number for number, _ in lines]))

    @staticmethod
    def write(file: BinaryIO, path: Path, boxes: Boxes, clock: FrameClock) -> None:
        """See `BoxFormat`."""
        _write(file, path, boxes, clock, "result")


class MotDetections(MotResult):
    """Detections: as a result, with the id -1."""

    NAME, TITLE = "mot-det", "MOTChallenge detections"

    @staticmethod
    def write(file: BinaryIO, path: Path, boxes: Boxes, clock: FrameClock) -> None:
        """See `BoxFormat`."""
        _write(file, path, boxes, clock, "detections")


class MotTruth(MotResult):
    """A ground truth, of 9 columns."""

    NAME, TITLE = "mot-gt", "MOTChallenge ground truth"

    @staticmethod
    def write(file: BinaryIO, path: Path, boxes: Boxes, clock: FrameClock) -> None:
        """See `BoxFormat`."""
        _write(file, path, boxes, clock, "truth")


def _lines(path: Path) -> list[tuple[int, list[str]]]:
    note_input(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise TrackLogError(f"{path}: cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise TrackLogError(f"{path}: byte {error.start}: must be UTF-8 text") from error
    return [
        (number, [cell.strip() for cell in line.split(",")]) for number, line in enumerate(text.splitlines(), 1) if line.strip()
    ]


def _values(path: Path, number: int, cells: list[str], names: tuple[str, ...]) -> list[float]:
    if len(cells) != len(names):
        raise TrackLogError(f"{path}: line {number}: {len(cells)} values: must be {len(names)}, as the lines before")
    values = []
    for name, cell in zip(names, cells, strict=True):
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise TrackLogError(f"{path}: line {number}: {name} = {cell[:40]!r}: must be a number")
        if name in ("frame", "id", "class"):
            low, high = (1, FRAME_MAX) if name == "frame" else (-_INTEGER_MAX, _INTEGER_MAX)
            if not (value.is_integer() and low <= value <= high):
                rule = f"must be an integer from 1 to {FRAME_MAX}" if name == "frame" else "must be an integer"
                raise TrackLogError(f"{path}: line {number}: {name} = {cell[:40]!r}: {rule}")
        values.append(value)
    return values


def _write(file: BinaryIO, path: Path, boxes: Boxes, clock: FrameClock, kind: str) -> None:
    rows = boxes.rows
    frames = clock.frames(boxes.instants_us[rows["instant"]], path)
    for frame, row in zip(frames.tolist(), rows, strict=True):
        place = (row["left"] + _EDGE, row["top"] + _EDGE, row["width"], row["height"])
        identity = NOBODY if kind == "detections" else int(row["id"])
        if kind == "truth":
            counted = decimal(row["confidence"]) if row["counted"] else "0"
            rest = [counted, str(row["class_id"]), decimal(row["visibility"])]
        else:
            rest = [decimal(row["confidence"]), "-1", "-1", "-1"]
        file.write((",".join([str(frame), str(identity), *map(decimal, place), *rest]) + "\n").encode())
