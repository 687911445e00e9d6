# SPDX-License-Identifier: Apache-2.0
"""Rules for reading and scoring a ground truth: one small TOML file per kind of truth."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

from ..errors import ConfigError
from ..outputs import note_input
from ..ranges import Range, check_range
from ..toml_file import read_toml

__all__ = ["RULES", "Rule", "load_rule"]

_FOLDER = files(__package__) / "rules"
RULES = tuple(sorted(file.name.removesuffix(".toml") for file in _FOLDER.iterdir() if file.name.endswith(".toml")))

_BOX = ("left", "top", "width", "height")
_POINT = ("x", "y")
_COLUMNS = ("id", "t_us", "t_begin_us", "t_end_us", *_BOX, *_POINT, "vx", "vy", "class_id")
_EDGES = ("left", "top", "right", "bottom")
_SIMILARITIES = ("centre", "iou")

# field -> (lowest, highest, meaning); integer limits require an integer
_RANGES: Mapping[str, Range] = {
    "origin_us": (-(2**60), 2**60, "added to the truth's times to make them the recording's"),
    "at_us": (-(10**9), 10**9, "when a line is evaluated, after its t_us or t_end_us"),
    "max_age_us": (0, 10**12, "age past which a track's state is no output"),
    "threshold": (0.0, 1.0, "similarity from which on a pair may match"),
    "edge_px": (-1.0, 1.0, "where the first pixel begins in the truth's coordinates"),
}
_REACH = (0.01, 1e6, "distance at which a point's similarity is 0")


@dataclass(frozen=True)
class Rule:
    """How to read and score a ground truth.

    Attributes:
        columns: meaning -> name of the CSV's column; empty for files of boxes (`tracks.formats`). `id`; `t_us`, or `t_begin_us`
            and `t_end_us`, in us; `left`, `top`, `width`, `height`, or `x` and `y`, in pixels; optionally `vx` and `vy`, in
            pixels per second, and `class_id`, a column that a file may lack.
        title: one-line description.
        sensor: (width, height) in pixels; required by `clip` and `ignore`.
        origin_us: offset from the truth's times to the recording's.
        at_us: a line is evaluated this long after its `t_us` or `t_end_us`.
        max_age_us: maximum age at which a track's newest state counts as an output.
        similarity: "centre": 1 - d / (half the box's diagonal), at least 0, at distance d between the centres; "iou":
            intersection over union of the box and the track's box; of one that is turned, the upright rectangle around it.
        reach_px: for points: the distance at which the similarity is 0.
        threshold: minimum similarity of a match for CLEAR and ID scores.
        clip: whether boxes are clipped to the sensor; with "iou" the tracks' boxes, too.
        edge_px: coordinate of the first pixel's left and upper edge.
        ignore: edge -> width in pixels of a band along it in which an output outside every box is ignored.
        counted: column -> (lowest, highest): an object counts only if all these columns are within limits; otherwise it need
            not be detected, and an output in its box is not a false positive.

    Raises:
        ConfigError: a field outside its range, or fields that contradict each other.
    """

    columns: Mapping[str, str]
    title: str = ""
    sensor: tuple[int, int] | None = None
    origin_us: int = 0
    at_us: int = 0
    max_age_us: int = 60_000
    similarity: str = "centre"
    reach_px: float | None = None
    threshold: float = 0.5
    clip: bool = False
    edge_px: float = -0.5
    ignore: Mapping[str, float] = field(default_factory=dict)
    counted: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.columns != {}:
            _check_columns(self.columns)
        for name, limits in _RANGES.items():
            check_range(name, getattr(self, name), *limits)
        if self.similarity not in _SIMILARITIES:
            raise ConfigError(f"similarity = {self.similarity!r}: must be one of {', '.join(_SIMILARITIES)}")
        if not isinstance(self.clip, bool):
            raise ConfigError(f"clip = {self.clip!r}: must be true or false")
        if not isinstance(self.title, str):
            raise ConfigError(f"title = {self.title!r}: must be text")
        self._check_points()
        self._check_sensor()
        for edge, width in _entries(self.ignore, _EDGES, "ignore"):
            check_range(f"ignore.{edge}", width, 0.0, 1e6, "width of a band in pixels")
        for column, limits in _table(self.counted, "counted").items():
            if not _is_interval(limits):
                raise ConfigError(f"counted.{column} = {limits!r}: must be [lowest, highest]")

    @property
    def of_points(self) -> bool:
        """Whether the truth has points instead of boxes."""
        return "x" in self.columns

    def on(self, sensor: tuple[int, int] | None) -> Rule:
        """A copy with this sensor (width, height); None keeps the rule's own."""
        return self if sensor is None else replace(self, sensor=sensor)

    def size(self) -> tuple[int, int]:
        """(width, height) of the sensor.

        Raises:
            ConfigError: it is unknown.
        """
        if self.sensor is None:
            raise ConfigError("sensor: must be given (--sensor WxH, or the rule's field), to clip boxes or to ignore bands")
        return self.sensor

    def _check_points(self) -> None:
        if not self.of_points:
            if self.reach_px is not None:
                raise ConfigError(f"reach_px = {self.reach_px!r}: must be given for points alone, boxes have a diagonal")
            return
        check_range("reach_px", self.reach_px, *_REACH)
        if self.similarity == "iou" or self.clip:
            raise ConfigError("columns x, y: points must have similarity 'centre' and no clip")

    def _check_sensor(self) -> None:
        if self.sensor is None:
            return
        sensor: object = self.sensor
        if not (
            isinstance(sensor, list | tuple) and len(sensor) == 2 and all(type(n) is int and 1 <= n <= 65_536 for n in sensor)
        ):
            raise ConfigError(f"sensor = {sensor!r}: must be [width, height], each from 1 to 65536")
        object.__setattr__(self, "sensor", tuple(sensor))


def load_rule(name: str | Path) -> Rule:
    """A rule by its name in `RULES`, or from a TOML file whose keys are the fields of `Rule`.

    With the key `base`, the name of a rule, missing fields are taken from that rule.

    Raises:
        ConfigError: unknown rule, a file that cannot be read or is not TOML, an unknown field, or one outside its range.
    """
    shipped = str(name) in RULES
    if not shipped and Path(name).suffix.lower() != ".toml":
        raise ConfigError(f"rule {str(name)!r}: must be one of {', '.join(RULES)}, or a .toml file")
    path = _FOLDER / f"{name}.toml" if shipped else Path(name)
    if not shipped:
        note_input(Path(name))
    try:
        data = read_toml(Path(str(path)))
        base = data.pop("base", None)
        if base is not None:
            if base not in RULES:
                raise ConfigError(f"base = {base!r}: must be one of {', '.join(RULES)}")
            data = {f.name: getattr(load_rule(base), f.name) for f in fields(Rule)} | data
        _entries(data, [f.name for f in fields(Rule)], "rule")
        if "columns" not in data:
            raise ConfigError("columns: must be given")
        return Rule(**data)
    except ConfigError as error:
        raise ConfigError(f"{name}: {error}") from error


def _check_columns(columns: object) -> None:
    for meaning, name in _entries(columns, _COLUMNS, "columns"):
        if not isinstance(name, str):
            raise ConfigError(f"columns.{meaning} = {name!r}: must be a column's name")
    assert isinstance(columns, Mapping)
    choices = ((("id",),), (("t_us",), ("t_begin_us", "t_end_us")), (_BOX, _POINT))
    for ways in choices:
        there = [way for way in ways if set(way) <= set(columns)]
        partly = {name for way in ways for name in way} & set(columns)
        if len(there) != 1 or partly != set(there[0]):
            raise ConfigError(f"columns {', '.join(columns)}: must have {' or '.join(' + '.join(way) for way in ways)}")
    if ("vx" in columns) != ("vy" in columns):
        raise ConfigError("columns vx, vy: must be given both, or neither")


def _table(value: object, where: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise ConfigError(f"{where} = {value!r}: must be a table")
    return value


def _entries(value: object, allowed: Iterable[str], where: str) -> list[tuple[str, Any]]:
    """The entries of a table; raises ConfigError for an unknown name."""
    table = _table(value, where)
    for key in table:
        if key not in allowed:
            raise ConfigError(f"{where}: unknown field {key!r}: must be one of {', '.join(allowed)}")
    return list(table.items())


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _is_interval(limits: object) -> bool:
    return isinstance(limits, list | tuple) and len(limits) == 2 and all(map(_is_number, limits)) and limits[0] <= limits[1]
