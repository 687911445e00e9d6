# SPDX-License-Identifier: Apache-2.0
"""Zones and lines for the rules, from a TOML file."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._numba_private import njit, step
from ..errors import ConfigError
from ..outputs import note_input
from ..ranges import check_integer
from ..toml_file import read_toml

__all__ = ["Line", "Zone", "Zones", "crosses", "crossings", "holds", "inside", "load_zones", "offset"]


# Points in polygons and crossings of lines; exact for coordinates with few binary digits, such as whole and half pixels.
#
# A polygon includes its border. A line has a right and a left side, seen in its direction from begin to end in the picture (y
# points down); the line itself belongs to the left. A step from one side to the other crosses the line if the line's begin and
# end are on different sides of the straight line through the step, by the same rule: so a step through the common end of two
# lines crosses exactly one of them.


@step
def offset(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> float:
    """Twice the signed area of the triangle (a, b, point): positive to the right of the way from a to b in the picture."""
    return (bx - ax) * (y - ay) - (by - ay) * (x - ax)


@step
def holds(corners, first, last, x, y):  # type: ignore[no-untyped-def]
    """Whether the polygon with corners[first:last], (k, 2), contains a point: even-odd rule, the border is inside."""
    within = False
    bx, by = corners[last - 1]
    for i in range(first, last):
        ax, ay = bx, by
        bx, by = corners[i]
        side = offset(ax, ay, bx, by, x, y)
        if side == 0 and min(ax, bx) <= x <= max(ax, bx) and min(ay, by) <= y <= max(ay, by):
            return True
        if (ay > y) != (by > y) and (side > 0) == (by < ay):
            within = not within
    return within


@step
def crosses(line, px, py, qx, qy):  # type: ignore[no-untyped-def]
    """1 if the step from p to q crosses line (begin x, y, end x, y) from left to right, -1 from right to left, else 0."""
    ax, ay, bx, by = line
    from_right = offset(ax, ay, bx, by, px, py) > 0
    to_right = offset(ax, ay, bx, by, qx, qy) > 0
    if from_right == to_right or (offset(px, py, qx, qy, ax, ay) > 0) == (offset(px, py, qx, qy, bx, by) > 0):
        return 0
    return 1 if to_right else -1


@njit(cache=True, nogil=True)
def _inside(corners, x, y, out):  # type: ignore[no-untyped-def]
    for i in range(len(x)):
        out[i] = holds(corners, 0, len(corners), x[i], y[i])


@njit(cache=True, nogil=True)
def _crossings(line, x, y, out):  # type: ignore[no-untyped-def]
    for i in range(len(out)):
        out[i] = crosses(line, x[i], y[i], x[i + 1], y[i + 1])


def inside(corners: ArrayLike, x: ArrayLike, y: ArrayLike) -> NDArray[np.bool_]:
    """Whether a polygon, (k, 2) corners in order, contains each of (n,) points."""
    xs, ys = np.asarray(x, np.float64), np.asarray(y, np.float64)
    out = np.empty(len(xs), np.bool_)
    _inside(np.asarray(corners, np.float64), xs, ys, out)
    return out


def crossings(line: ArrayLike, x: ArrayLike, y: ArrayLike) -> NDArray[np.int8]:
    """Crossings of a line (begin x, y, end x, y) by the (n - 1,) steps of a path: 1 to its right, -1 to its left, else 0."""
    xs, ys = np.asarray(x, np.float64), np.asarray(y, np.float64)
    out = np.empty(max(len(xs) - 1, 0), np.int8)
    _crossings(np.asarray(line, np.float64), xs, ys, out)
    return out


_PIXELS_MAX = 1e6
_CORNERS_MAX = 10_000
_DWELL_MAX_US = 10**12
_ALLOWED = {"both": 0, "to_right": 1, "to_left": -1}

Point = tuple[float, float]


@dataclass(frozen=True)
class Zone:
    """A polygon, including its border, in which no track may be at all, or for longer than `dwell_us`.

    Attributes:
        name: display name.
        corners: at least three, in order, (x, y) in pixels.
        dwell_us: longest allowed stay; 0 forbids every stay.
    """

    name: str
    corners: tuple[Point, ...]
    dwell_us: int = 0


@dataclass(frozen=True)
class Line:
    """A straight line on which crossings are counted.

    Attributes:
        begin, end: (x, y) in pixels.
        allowed: direction of crossing, seen from begin to end in the picture: 1: to the right; -1: to the left; 0: both.
    """

    name: str
    begin: Point
    end: Point
    allowed: int = 0


@dataclass(frozen=True)
class Zones:
    """All zones and lines of a picture; `sensor` is its (width, height), None if not stated in the file."""

    zones: tuple[Zone, ...] = ()
    lines: tuple[Line, ...] = ()
    sensor: tuple[int, int] | None = None

    def corners(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Corners of all zones, (n, 2), and the index at which each zone begins, (zones + 1,)."""
        corners = np.array([corner for zone in self.zones for corner in zone.corners], np.float64).reshape(-1, 2)
        return corners, np.cumsum([0, *(len(zone.corners) for zone in self.zones)], dtype=np.int64)


def load_zones(path: Path | str) -> Zones:
    """Read a TOML file: `sensor = [width, height]`, tables `[[zone]]` and `[[line]]` (docs/anomalies.md).

    Raises:
        ConfigError: the file cannot be read, is not TOML, or has an invalid field.
    """
    note_input(path)
    try:
        data = read_toml(Path(path))
        _fields(data, ("sensor", "zone", "line"), "zones")
        zones = tuple(_zone(table, f"zone[{i}]") for i, table in enumerate(_tables(data, "zone")))
        lines = tuple(_line(table, f"line[{i}]") for i, table in enumerate(_tables(data, "line")))
        if not zones and not lines:
            raise ConfigError("zone, line: must have one at least")
        names = [zone.name for zone in zones] + [line.name for line in lines]
        for name in names:
            if names.count(name) > 1:
                raise ConfigError(f"name = {name!r}: must be unique among zones and lines")
        return Zones(zones, lines, _sensor(data))
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from error


def _zone(table: Mapping[str, Any], where: str) -> Zone:
    kind = table.get("kind")
    if kind not in ("forbidden", "dwell"):
        raise ConfigError(f"{where}.kind = {kind!r}: must be one of forbidden, dwell")
    _fields(table, ("name", "kind", "polygon", *(("dwell_us",) if kind == "dwell" else ())), where)
    polygon = table.get("polygon")
    if not isinstance(polygon, list) or not 3 <= len(polygon) <= _CORNERS_MAX:
        raise ConfigError(f"{where}.polygon: must have from 3 to {_CORNERS_MAX} corners [x, y]")
    corners = tuple(_point(corner, f"{where}.polygon[{i}]") for i, corner in enumerate(polygon))
    if kind == "dwell":
        check_integer(f"{where}.dwell_us", table.get("dwell_us"), 1, _DWELL_MAX_US, "longest stay")
    return Zone(_name(table, where), corners, table.get("dwell_us", 0))


def _line(table: Mapping[str, Any], where: str) -> Line:
    _fields(table, ("name", "begin", "end", "allowed"), where)
    allowed = table.get("allowed", "both")
    if not isinstance(allowed, str) or allowed not in _ALLOWED:
        raise ConfigError(f"{where}.allowed = {allowed!r}: must be one of {', '.join(_ALLOWED)}")
    begin, end = (_point(table.get(which), f"{where}.{which}") for which in ("begin", "end"))
    if begin == end:
        raise ConfigError(f"{where}.end = {list(end)}: must be another point than begin")
    return Line(_name(table, where), begin, end, _ALLOWED[allowed])


def _tables(data: Mapping[str, Any], key: str) -> list[Mapping[str, Any]]:
    tables = data.get(key, [])
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        raise ConfigError(f"{key}: must be tables [[{key}]]")
    return tables


def _fields(table: Mapping[str, Any], known: Iterable[str], where: str) -> None:
    for key in table:
        if key not in known:
            raise ConfigError(f"{where}: unknown field {key!r}: must be one of {', '.join(known)}")


def _name(table: Mapping[str, Any], where: str) -> str:
    name = table.get("name")
    if not isinstance(name, str) or not name or not name.isprintable():
        raise ConfigError(f"{where}.name = {name!r}: must be a text of one line")
    return name


def _point(value: object, where: str) -> Point:
    if not isinstance(value, list) or len(value) != 2 or not all(map(_is_pixel, value)):
        raise ConfigError(f"{where} = {value!r}: must be [x, y], each from -{_PIXELS_MAX:g} to {_PIXELS_MAX:g}")
    return float(value[0]), float(value[1])


def _is_pixel(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value) and abs(value) <= _PIXELS_MAX


def _sensor(data: Mapping[str, Any]) -> tuple[int, int] | None:
    sensor = data.get("sensor")
    if sensor is None:
        return None
    if not isinstance(sensor, list) or len(sensor) != 2 or not all(type(n) is int and 1 <= n <= 65_536 for n in sensor):
        raise ConfigError(f"sensor = {sensor!r}: must be [width, height], each from 1 to 65536")
    return sensor[0], sensor[1]
