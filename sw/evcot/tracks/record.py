# SPDX-License-Identifier: Apache-2.0
"""The output of a tracker: records of its tracks, the geometry of boxes, owners of the events; and the rules of records."""

from __future__ import annotations

import json
from collections.abc import Mapping
from enum import IntEnum
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError, TrackLogError

__all__ = [
    "BEGIN_US",
    "DROPPED",
    "NO_CLASS",
    "NO_NAMES",
    "TRACK",
    "VERDICT",
    "ClassNames",
    "Kind",
    "box_corners",
    "check_class_name",
    "check_records",
    "class_label",
    "class_names_from",
    "class_names_text",
    "classes_at",
    "labels_at",
    "last_until",
    "no_verdicts",
    "upright_sides",
]

DROPPED = -2  # owner of an event that a filter dropped; -1 is an event that no tracker took


class Kind(IntEnum):
    """Kinds of records in a TrackLog."""

    BORN = 0
    MOVED = 1
    MERGED = 2
    LOST = 3


TRACK = np.dtype(
    [
        ("t_us", "<i8"),
        ("event_index", "<i8"),
        ("kind", "u1"),
        ("track_id", "<i8"),
        ("slot", "<i2"),
        ("x", "<f8"),
        ("y", "<f8"),
        ("radius", "<f8"),
        ("width", "<f8"),
        ("height", "<f8"),
        ("angle", "<f8"),
        ("vx", "<f8"),
        ("vy", "<f8"),
        ("confidence", "<f8"),
        ("n_ev", "<i4"),
        ("support", "<i8"),
        ("other_id", "<i8"),
    ]
)


VERDICT = np.dtype(
    [
        ("t_us", "<i8"),
        ("event_index", "<i8"),
        ("track_id", "<i8"),
        ("slot", "<i2"),
        ("class_id", "<i8"),
        ("margin", "<i4"),
        ("windows", "<i4"),
    ]
)
"""What a classifier says of a track: `class_id`, -1 for none of its classes; `margin` of the best class before the next one,
summed over the `windows` of the vote; the event that completed the last window, and its time."""


ClassNames = Mapping[int, str]
"""The name of each class by its number; a class without a name is shown by its number."""

NO_NAMES: ClassNames = MappingProxyType({})
NO_CLASS = "?"  # label of a track that is of none of the classes
_NAME_MAX = 64  # characters


def check_class_name(name: object) -> str:
    """The name of a class, if it can be shown in one line.

    Raises:
        ConfigError: no text, an empty or a long one, or one with control characters.
    """
    if not (isinstance(name, str) and 1 <= len(name) <= _NAME_MAX and name.isprintable() and name.strip() == name):
        rule = f"must be 1 to {_NAME_MAX} printable characters, without spaces around them"
        raise ConfigError(f"name of a class = {repr(name)[: _NAME_MAX + 2]}: {rule}")
    return name


def class_label(class_id: int, names: ClassNames) -> str:
    """How a class is shown: by its name, else by its number; -1 as `NO_CLASS`."""
    return NO_CLASS if class_id < 0 else names.get(class_id, str(class_id))


def class_names_text(names: ClassNames) -> str:
    """Names as JSON, as logs keep them."""
    return json.dumps({str(number): name for number, name in sorted(names.items())})


def class_names_from(text: str, path: Path) -> dict[int, str]:
    """The names in what `class_names_text` has made.

    Raises:
        TrackLogError: it has not made this; names the file.
    """
    try:
        return {int(number): check_class_name(name) for number, name in json.loads(text).items()}
    except (ValueError, AttributeError) as error:
        rule = "must be JSON, an object of class numbers and names"
        raise TrackLogError(f"{path}: class_names = {text[:60]!r}: {rule}") from error


def no_verdicts() -> NDArray[np.void]:
    """None, (0,) of dtype `VERDICT`."""
    return np.empty(0, VERDICT)


def classes_at(verdicts: NDArray[np.void], track_id: NDArray[np.int64], t_us: NDArray[np.int64]) -> NDArray[np.int64]:
    """The class of each of (n,) tracks at a time, (n,) int64: that of its last verdict until then; -1 before its first one.

    Args:
        verdicts: (k,) of dtype `VERDICT`, in chronological order.
    """
    last = last_until(verdicts["track_id"], verdicts["t_us"], track_id, t_us)
    return np.append(verdicts["class_id"], -1)[last]


def labels_at(verdicts: NDArray[np.void], names: ClassNames, track_id: NDArray[np.int64], t_us: NDArray[np.int64]) -> list[str]:
    """How the classes of (n,) tracks at a time are shown, as `classes_at`; empty text before a track's first verdict."""
    last = last_until(verdicts["track_id"], verdicts["t_us"], track_id, t_us)
    class_ids = verdicts["class_id"].tolist()
    return ["" if row < 0 else class_label(class_ids[row], names) for row in last.tolist()]


def last_until(
    keys: NDArray[np.integer], times: NDArray[np.int64], key: NDArray[np.integer], until: NDArray[np.int64]
) -> NDArray[np.int64]:
    """The last of (k,) rows in chronological order with a key until a time, (n,) indices; -1: none.

    Args:
        keys, times: (k,) of the rows.
        key, until: (n,) which are asked for.
    """
    rows = len(keys)
    both = np.concatenate((keys, key))
    order = np.lexsort((np.concatenate((times, until)), both))  # stable: of equal times the rows come first
    last = np.maximum.accumulate(np.where(order < rows, np.arange(len(order)), -1))
    found = np.empty(len(order), np.int64)
    found[order] = np.where((last >= 0) & (both[order[last]] == both[order]), order[last], -1)
    return found[rows:]


BEGIN_US = -(2**60)  # the earliest time of a record
_PIXELS_MAX = 1e9


def check_records(records: NDArray[np.void], first: int = 0, since_us: int = BEGIN_US) -> None:
    """Validate records.

    Args:
        first, since_us: of a part of a log, the number of records before it, and the time of the last of them.

    Raises:
        TrackLogError: a record that is out of order in time, of unknown kind, or without a valid position, box, velocity or
            confidence.
    """
    t_us = records["t_us"]
    rules = (
        ("t_us", (t_us >= BEGIN_US) & (t_us <= -BEGIN_US), "must be from -2^60 to 2^60"),
        ("t_us", np.append(t_us[:1] >= since_us, t_us[1:] >= t_us[:-1]), "must not be before the record before it"),
        ("kind", np.isin(records["kind"], list(Kind)), f"must be from 0 to {max(Kind):d}"),
        *(
            (name, np.abs(records[name]) <= _PIXELS_MAX, f"must be a number of at most {_PIXELS_MAX:g}")
            for name in ("x", "y", "radius", "vx", "vy", "angle")
        ),
        *(
            (name, (records[name] >= 0) & (records[name] <= most), f"must be a number from 0 to {most:g}")
            for name, most in (("width", _PIXELS_MAX), ("height", _PIXELS_MAX), ("confidence", 1.0))
        ),
    )
    for name, good, rule in rules:
        if not good.all():
            row = int(np.argmin(good))
            raise TrackLogError(f"record {first + row}: {name} = {records[name][row]}: {rule}")


def upright_sides(rows: NDArray[np.void]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Width and height, (k,) each, of the upright rectangle around each box; of an upright box its own, exactly."""
    width, height = np.array(rows["width"], np.float64), np.array(rows["height"], np.float64)
    turned = rows["angle"] != 0
    if turned.any():
        cos, sin = (np.abs(part(rows["angle"][turned])) for part in (np.cos, np.sin))
        wide, high = width[turned], height[turned]
        width[turned], height[turned] = cos * wide + sin * high, sin * wide + cos * high
    return width, height


def box_corners(rows: NDArray[np.void]) -> NDArray[np.float64]:
    """(k, 4, 2) x, y of the corners of each box, in turn; the first is the upper left one of a box that is not turned."""
    half = np.stack((rows["width"], rows["height"]), axis=-1) / 2
    offsets = half[:, None] * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    cos, sin = np.cos(rows["angle"])[:, None], np.sin(rows["angle"])[:, None]
    x, y = offsets[..., 0], offsets[..., 1]
    corners = np.stack((cos * x - sin * y, sin * x + cos * y), axis=-1)
    return np.asarray(corners + np.stack((rows["x"], rows["y"]), axis=-1)[:, None], np.float64)
