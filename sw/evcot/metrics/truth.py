# SPDX-License-Identifier: Apache-2.0
"""Ground truth, read from CSV by a rule, or from a file of boxes: boxes at instants, in the recording's microseconds."""

from __future__ import annotations

import csv
import math
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError, RecordingError, TrackLogError
from ..outputs import note_input
from ..scenes.truth import Truth
from ..tracks.formats.base import NOBODY, Boxes, FrameClock
from ..tracks.formats.registry import is_boxes, read_boxes
from .rule import RULES, Rule, load_rule

__all__ = ["OBJECT", "TRUTH_SUFFIXES", "GroundTruth", "ground_truth_of", "read_truth", "rule_for", "truth_beside"]


OBJECT = np.dtype(
    [
        ("frame", "<i8"),  # index into the instants
        ("object", "<i8"),  # index into the ids
        ("x", "<f8"),  # centre
        ("y", "<f8"),
        ("width", "<f8"),
        ("height", "<f8"),
        ("vx", "<f8"),  # pixels per second; NaN if not in the truth
        ("vy", "<f8"),
        ("counted", "?"),
        ("class_id", "<i8"),  # -1 if not in the truth
    ]
)

_TIME_MAX_US = 2**60
_PIXELS_MAX = 1e9
_SIDE_MIN = 1e-3


@dataclass(frozen=True, eq=False)
class GroundTruth:
    """Positions and sizes of the objects.

    Attributes:
        instants_us: (f,) int64, ascending: times of evaluation, in the recording's microseconds.
        objects: (n,) of dtype `OBJECT`, by frame, then in the file's order; clipped according to the rule. A point is the
            square whose half diagonal is the rule's `reach_px`.
        ids: the objects' ids as in the file.
    """

    instants_us: NDArray[np.int64]
    objects: NDArray[np.void]
    ids: tuple[str, ...]


def read_truth(path: Path | str, rule: Rule, *, clock: FrameClock | None = None, format: str | None = None) -> GroundTruth:
    """Read a CSV file with a header according to a rule, or a file of boxes in one of `tracks.formats.registry.FORMATS`.

    The instants of a CSV file are those of its lines: an instant without objects is evaluated only if there is a line for it.
    Those of boxes are all frames from the first to the last, the data set's images, or the times of the boxes.

    Args:
        clock: the time of frames, for formats that have no times.
        format: name of a box format; None: chosen by the file's name, else CSV.

    Raises:
        RecordingError: the file cannot be read, lacks a column, or has an invalid line: names file, line, field, value and
            rule; no box counts, or one that does lies off the sensor.
        TrackLogError: the same for a file of boxes.
        ConfigError: the rule clips, and the sensor is unknown; a CSV file with a rule without columns; frames without a clock.
    """
    path = Path(path)
    if format is not None or is_boxes(path):
        return _truth_of_boxes(path, read_boxes(path, clock, format), rule)
    if not rule.columns:
        raise ConfigError(f"{path}: the rule has no columns: must have those of a CSV file")
    take = _read(path)
    columns, named = rule.columns, {meaning: take.numbers(name) for meaning, name in rule.columns.items() if meaning in _REAL}
    end_us = take.times(columns.get("t_us") or columns["t_end_us"])
    at_us = end_us + rule.at_us
    if "t_begin_us" in columns:
        begin_us = take.times(columns["t_begin_us"])
        take.check(columns["t_begin_us"], (begin_us <= at_us) & (at_us <= end_us), f"must hold the instant, {_instant(rule)}")
    instants_us, frame = np.unique(at_us + rule.origin_us, return_inverse=True)
    ids, number = _numbered(take.texts(columns["id"]))
    _, first = np.unique(frame * max(len(ids), 1) + number, return_index=True)
    take.check(columns["id"], np.isin(np.arange(len(frame)), first), "must not occur twice at one time")

    objects = np.zeros(len(frame), OBJECT)
    objects["frame"], objects["object"] = frame, number
    for axis, low, side in (("x", "left", "width"), ("y", "top", "height")):
        if rule.of_points:
            assert rule.reach_px is not None
            objects[axis], objects[side] = named[axis], rule.reach_px * math.sqrt(2)
        else:
            take.check(columns[side], named[side] >= _SIDE_MIN, f"must be at least {_SIDE_MIN:g}")
            objects[axis], objects[side] = named[low] + named[side] / 2, named[side]
        objects[f"v{axis}"] = named.get(f"v{axis}", math.nan)
    objects["counted"], objects["class_id"] = True, take.classes(columns.get("class_id"))
    for name, (low_limit, high_limit) in rule.counted.items():
        value = take.numbers(name)
        objects["counted"] &= (low_limit <= value) & (value <= high_limit)
    _check_objects(path, objects, rule, lambda row: f"line {take.lines[row]}")
    if rule.clip:
        objects = _clipped(objects, rule)
    return GroundTruth(instants_us, objects[np.argsort(objects["frame"], kind="stable")], ids)


def _truth_of_boxes(path: Path, boxes: Boxes, rule: Rule) -> GroundTruth:
    """Boxes as a truth; the sensor is that of the rule, else the size of the images that the file states."""
    rows = boxes.rows
    detected = rows["id"] == NOBODY
    if detected.any():
        place = boxes.place(int(np.argmax(detected)))
        raise TrackLogError(f"{path}: {place}: id = {NOBODY}: must be an object's: detections are no truth")
    rule = rule.on(rule.sensor or boxes.sensor)
    names, number = np.unique(rows["id"], return_inverse=True)
    objects = np.zeros(len(rows), OBJECT)
    objects["frame"], objects["object"], objects["counted"] = rows["instant"], number, rows["counted"]
    objects["class_id"] = rows["class_id"]
    for axis, low, side in (("x", "left", "width"), ("y", "top", "height")):
        objects[axis], objects[side], objects[f"v{axis}"] = rows[low] + rows[side] / 2, rows[side], math.nan
    for name, limits in rule.counted.items():
        if name not in _COUNTED_BY:
            raise ConfigError(f"counted.{name}: must be one of {', '.join(_COUNTED_BY)} with a file of boxes")
        value = rows[_COUNTED_BY[name]]
        objects["counted"] &= (limits[0] <= value) & (value <= limits[1])
    _check_objects(path, objects, rule, boxes.place)
    if rule.clip:
        objects = _clipped(objects, rule)
    return GroundTruth(boxes.instants_us + rule.origin_us + rule.at_us, objects, tuple(str(name) for name in names.tolist()))


def _check_objects(path: Path, objects: NDArray[np.void], rule: Rule, place: Callable[[int], str]) -> None:
    """Raise RecordingError where no box counts, or where one that does lies off the sensor and is not to be clipped."""
    if not objects["counted"].any():
        raise RecordingError(f"{path}: no box counts: must have one at least that is to be found")
    if rule.sensor is None or rule.clip:
        return
    for axis, side, size in zip("xy", ("width", "height"), rule.size(), strict=True):
        low, high = objects[axis] - objects[side] / 2, objects[axis] + objects[side] / 2
        off = objects["counted"] & ((high < rule.edge_px) | (low > rule.edge_px + size))
        if off.any():
            row = int(np.argmax(off))
            width, height = rule.size()
            what = f"{axis} = {objects[axis][row]:g}, {side} = {objects[side][row]:g}"
            raise RecordingError(f"{path}: {place(row)}: {what}: must reach the sensor's {width}x{height} pixels")


def rule_for(path: Path | str, format: str | None = None) -> Rule:
    """The named rule whose columns a CSV file has, the first if there is none; "boxes" for a file of boxes.

    Args:
        format: name of a box format; None: chosen by the file's name, else CSV.

    Raises:
        RecordingError: the file's first line cannot be read.
    """
    if format is not None or is_boxes(path):
        return load_rule("boxes")
    with _csv(Path(path)) as (header, _):
        pass
    rules = [rule for rule in map(load_rule, RULES) if rule.columns]
    return next((rule for rule in rules if set(rule.columns.values()) <= set(header)), rules[0])


_CLASS_MAX = 2**60
_ROWS = 1 << 12  # of a CSV file, taken apart at once
_COUNTED_BY = {"confidence": "confidence", "class": "class_id", "visibility": "visibility"}
_REAL = ("left", "top", "width", "height", "x", "y", "vx", "vy")


def _instant(rule: Rule) -> str:
    return f"t_end_us {'-' if rule.at_us < 0 else '+'} {abs(rule.at_us)}"


@contextmanager
def _csv(path: Path) -> Iterator[tuple[list[str], Iterator[tuple[int, list[str]]]]]:
    """The header of a CSV file, and its other lines with their numbers, read as they are taken."""
    note_input(path)
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(file)
            header = [name.strip() for name in next(reader, [])]
            yield header, ((reader.line_num, row) for row in reader if row)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        rule = "must be a truth as CSV, or a file of boxes; recordings and track logs hold none"
        raise RecordingError(f"{path}: is no text, at byte {error.start}: {rule}") from error
    except csv.Error as error:
        raise RecordingError(f"{path}: line {reader.line_num}: is no CSV: {error}") from error


def _read(path: Path) -> _Columns:
    lines: list[int] = []
    with _csv(path) as (header, rows):
        columns: list[list[str]] = [[] for _ in header]
        while some := list(islice(rows, _ROWS)):
            if any(len(row) != len(header) for _, row in some):
                line, count = next((line, len(row)) for line, row in some if len(row) != len(header))
                raise RecordingError(f"{path}: line {line}: {count} values: must be {len(header)}, as the header")
            lines += [line for line, _ in some]
            for column, cells in zip(columns, zip(*(row for _, row in some), strict=True), strict=True):
                column += cells
    if not lines:
        raise RecordingError(
            f"{path}: has {'no line after the header' if header else 'no header'}: must have one line an object"
        )
    return _Columns(path, header, columns, lines)


class _Columns:
    """The cells of a file by column, with parsing and validation.

    Attributes:
        lines: number of each row's line.
    """

    def __init__(self, path: Path, header: list[str], columns: list[list[str]], lines: list[int]) -> None:
        self._path, self._header, self._columns, self.lines = path, header, columns, lines

    def texts(self, name: str) -> list[str]:
        return [cell.strip() for cell in self._cells(name)]

    def numbers(self, name: str) -> NDArray[np.float64]:
        return np.asarray(self._parsed(name, float, np.float64, _PIXELS_MAX, "must be a number"), np.float64)

    def times(self, name: str) -> NDArray[np.int64]:
        rule = "must be an integer, microseconds, of at most 2^60"
        return np.asarray(self._parsed(name, int, np.int64, _TIME_MAX_US, rule), np.int64)

    def classes(self, name: str | None) -> NDArray[np.int64]:
        """The classes in a column that the file may lack: then all are -1."""
        if name not in self._header:
            return np.full(len(self.lines), -1)
        rule = "must be a class's number, an integer of at most 2^60"
        return np.asarray(self._parsed(name, int, np.int64, _CLASS_MAX, rule), np.int64)

    def check(self, name: str, good: NDArray[np.bool_], rule: str) -> None:
        """Raise RecordingError for the first line that is not `good`."""
        if not good.all():
            row = int(np.argmin(good))
            raise RecordingError(f"{self._path}: line {self.lines[row]}: {name} = {self.texts(name)[row][:40]!r}: {rule}")

    def _parsed(self, name: str, parse: type[float], dtype: type[Any], most: float, rule: str) -> NDArray[Any]:
        cells = self._cells(name)
        try:
            values = np.fromiter(map(parse, cells), dtype, len(cells))
            good = np.abs(values) <= most
        except (ValueError, OverflowError):
            good = np.array([_fits(parse, cell, most) for cell in cells])
        self.check(name, good, rule)
        return values

    def _cells(self, name: str) -> list[str]:
        if self._header.count(name) != 1:
            shown = ",".join(self._header)[:120]
            raise RecordingError(f"{self._path}: line 1: {shown!r}: must have one column {name!r} (the rule's `columns`)")
        return self._columns[self._header.index(name)]


def _fits(parse: type[float], cell: str, most: float) -> bool:
    try:
        return abs(parse(cell)) <= most
    except ValueError:
        return False


def _numbered(texts: list[str]) -> tuple[tuple[str, ...], NDArray[np.int64]]:
    """The distinct texts in order of appearance, and the index of each."""
    numbers: Mapping[str, int] = {text: number for number, text in enumerate(dict.fromkeys(texts))}
    return tuple(numbers), np.array([numbers[text] for text in texts], np.int64)


def _clipped(objects: NDArray[np.void], rule: Rule) -> NDArray[np.void]:
    """The boxes clipped to the sensor; those entirely outside are removed."""
    clipped = objects.copy()
    for axis, side, size in zip("xy", ("width", "height"), rule.size(), strict=True):
        low = np.maximum(objects[axis] - objects[side] / 2, rule.edge_px)
        high = np.minimum(objects[axis] + objects[side] / 2, rule.edge_px + size)
        clipped[axis], clipped[side] = (low + high) / 2, high - low
    inside: NDArray[np.void] = clipped[(clipped["width"] > 0) & (clipped["height"] > 0)]
    return inside


def ground_truth_of(truth: Truth, rule: Rule) -> GroundTruth:
    """What `read_truth` makes of the file beside the scene's recording; errors as of it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "truth.csv"
        truth.save(path)
        return read_truth(path, rule)


TRUTH_SUFFIXES = (".truth.csv", "_gt.csv")  # behind a recording's stem: as `evcot simulate` writes it, and as data sets name it


def truth_beside(recording: Path) -> Path | None:
    """The truth beside a recording, None if there is none."""
    paths = (recording.with_name(f"{recording.stem}{suffix}") for suffix in TRUTH_SUFFIXES)
    return next((path for path in paths if path.is_file()), None)
