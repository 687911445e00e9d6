# SPDX-License-Identifier: Apache-2.0
"""Boxes at instants, as all formats hold them, in evcot's coordinates and times.

The middle of the first pixel is (0, 0), so its left and upper edge is at -0.5. Formats whose first pixel begins at 0 or at 1
are moved when they are read and written. Text is written to a millionth of a pixel, so what was read is written as it was.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import BinaryIO, Protocol

import numpy as np
from numpy.typing import NDArray

from ...errors import ConfigError, TrackLogError
from ...ranges import check_range
from ..record import ClassNames

__all__ = ["BOX", "FRAME_MAX", "NOBODY", "BoxFormat", "Boxes", "FrameClock", "check_boxes", "decimal"]

NOBODY = -1  # the id of a detection

BOX = np.dtype(
    [
        ("instant", "<i8"),  # index into the instants
        ("id", "<i8"),  # of the track or object; NOBODY for a detection
        ("left", "<f8"),
        ("top", "<f8"),
        ("width", "<f8"),
        ("height", "<f8"),
        ("confidence", "<f8"),
        ("class_id", "<i8"),
        ("visibility", "<f8"),
        ("counted", "?"),  # whether a truth's box must be found
    ]
)

_TIME_MAX_US = 2**60
FRAME_MAX = 10**6  # more are no recording's, and would take memory without end
_PIXELS_MAX = 1e9
_SIDE_MIN = 1e-3
_DECIMALS = 6


@dataclass(frozen=True)
class FrameClock:
    """The time of frames: frame k, counted from 1, is at `origin_us` + (k - 1) `frame_us`, rounded to a microsecond.

    Attributes:
        frame_us: time from frame to frame; None if unknown.
        origin_us: time of frame 1 on the recording's clock.

    Raises:
        ConfigError: a value outside its range.
    """

    frame_us: float | None = None
    origin_us: int = 0

    def __post_init__(self) -> None:
        if self.frame_us is not None:
            check_range("frame_us", self.frame_us, 1.0, 1e9, "time from frame to frame")
        check_range("origin_us", self.origin_us, -_TIME_MAX_US, _TIME_MAX_US, "time of frame 1")

    def times_us(self, frames: NDArray[np.int64], path: Path | str) -> NDArray[np.int64]:
        """(n,) the time of each frame.

        Raises:
            ConfigError: `frame_us` is unknown; names the file.
        """
        after_us: NDArray[np.int64] = np.rint((frames - 1) * self._known_us(path)).astype(np.int64)
        return self.origin_us + after_us

    def frames(self, times_us: NDArray[np.int64], path: Path | str) -> NDArray[np.int64]:
        """(n,) the frame at each time.

        Raises:
            ConfigError: `frame_us` is unknown.
            TrackLogError: there is no frame at a time.
        """
        numbers = 1 + np.rint((times_us - self.origin_us) / self._known_us(path)).astype(np.int64)
        good = (numbers >= 1) & (numbers <= FRAME_MAX) & (self.times_us(numbers, path) == times_us)
        if not good.all():
            at_us = times_us[int(np.argmin(good))]
            rule = f"must be {self.origin_us} plus a multiple of {self.frame_us:g}, the time of a frame (origin_us, frame_us)"
            raise TrackLogError(f"{path}: t = {at_us} us: {rule}")
        return np.asarray(numbers, np.int64)

    def _known_us(self, path: Path | str) -> float:
        if self.frame_us is None:
            raise ConfigError(f"{path}: has frames in place of times: their length must be given (--frame-us)")
        return self.frame_us


@dataclass(frozen=True, eq=False)
class Boxes:
    """Boxes at instants.

    Attributes:
        instants_us: (f,) int64, ascending: all times that the file names, with or without boxes.
        rows: (n,) of dtype `BOX`, by instant.
        sensor: (width, height) in pixels, if the file has it.
        class_names: class number -> name, as far as known.
        unit, places: what a row is called in messages, as "line", and its number.
    """

    instants_us: NDArray[np.int64]
    rows: NDArray[np.void]
    sensor: tuple[int, int] | None = None
    unit: str = "box"
    places: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))
    class_names: ClassNames = field(default_factory=dict)

    def place(self, row: int) -> str:
        """A row in a message."""
        return f"{self.unit} {self.places[row] if len(self.places) else row}"


class BoxFormat(Protocol):
    """A format: its name, the end of its files' names, and how it is read and written."""

    NAME: str
    SUFFIX: str
    TITLE: str

    @staticmethod
    def read(path: Path, clock: FrameClock) -> Boxes:
        """Read a file; TrackLogError names file, place, value and rule."""
        ...

    @staticmethod
    def write(file: BinaryIO, path: Path, boxes: Boxes, clock: FrameClock) -> None:
        """Write boxes; `path` is for messages."""
        ...


def check_boxes(path: Path, boxes: Boxes) -> Boxes:
    """Validate what was read, and return it in order of time.

    Raises:
        TrackLogError: a value outside its range, or an id twice at one time.
    """
    rows = boxes.rows
    rules = [
        *((name, np.abs(rows[name]) <= _PIXELS_MAX, f"must be at most {_PIXELS_MAX:g}") for name in ("left", "top")),
        *(
            (name, (rows[name] >= _SIDE_MIN) & (rows[name] <= _PIXELS_MAX), f"must be from {_SIDE_MIN:g} to {_PIXELS_MAX:g}")
            for name in ("width", "height")
        ),
        *((name, np.isfinite(rows[name]), "must be a number") for name in ("confidence", "visibility")),
        ("id", rows["id"] >= NOBODY, "must be 0 or more, or -1 for a detection"),
    ]
    for name, good, rule in rules:
        if not good.all():
            row = int(np.argmin(good))
            raise TrackLogError(f"{path}: {boxes.place(row)}: {name} = {rows[name][row]:g}: {rule}")
    known = np.flatnonzero(rows["id"] != NOBODY)
    pairs = np.stack((rows["instant"][known], rows["id"][known]))
    _, first = np.unique(pairs, axis=1, return_index=True)
    if len(first) < len(known):
        row = int(known[np.setdiff1d(np.arange(len(known)), first)[0]])
        raise TrackLogError(f"{path}: {boxes.place(row)}: id = {rows['id'][row]}: must not occur twice at one time")
    order = np.argsort(rows["instant"], kind="stable")
    places = boxes.places[order] if len(boxes.places) else order
    return replace(boxes, rows=rows[order], places=places)


def decimal(value: float) -> str:
    """A number as text, to a millionth, without needless digits."""
    text = f"{value:.{_DECIMALS}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
