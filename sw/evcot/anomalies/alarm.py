# SPDX-License-Identifier: Apache-2.0
"""Alarms, and the tables in which they are written."""

from __future__ import annotations

import json
from collections.abc import Sequence
from enum import IntEnum
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError
from ..outputs import written_aside

__all__ = ["ALARM", "UNITS", "Anomaly", "check_table_path", "rows", "write_alarms"]


class Anomaly(IntEnum):
    """Kinds of anomalies."""

    WRONG_WAY = 0
    CROSSING = 1
    FAST = 2
    SLOW = 3
    STOPPING = 4
    LOITERING = 5
    PLACE = 6
    FORBIDDEN = 7
    DWELL = 8
    LINE = 9


ALARM = np.dtype(
    [
        ("t_us", "<i8"),  # time of the alarm
        ("event_index", "<i8"),  # of the record that raised it
        ("track_id", "<i8"),
        ("kind", "u1"),  # Anomaly
        ("zone", "<i2"),  # index into the zones, for LINE into the lines; else -1
        ("x", "<f8"),  # where, pixels
        ("y", "<f8"),
        ("score", "<f8"),  # relative to the limit: 1 is at the limit
        ("expected", "<f8"),  # in the unit of `UNITS`
        ("seen", "<f8"),
        ("begin_us", "<i8"),  # time since which the rule has been violated
        ("birth_us", "<i8"),  # of the track
    ]
)


class Unit(NamedTuple):
    """Unit and meaning of `expected` and `seen` for a kind of alarm."""

    name: str
    expected: str


UNITS: dict[Anomaly, Unit] = {
    Anomaly.WRONG_WAY: Unit("deg", "normal direction, 0 to the right, 90 down"),
    Anomaly.CROSSING: Unit("deg", "normal direction"),
    Anomaly.FAST: Unit("px/s", "normal speed"),
    Anomaly.SLOW: Unit("px/s", "normal speed"),
    Anomaly.STOPPING: Unit("px/s", "normal speed"),
    Anomaly.LOITERING: Unit("s", "longest stay"),
    Anomaly.PLACE: Unit("tracks/cell", "least support"),
    Anomaly.FORBIDDEN: Unit("s", "longest stay"),
    Anomaly.DWELL: Unit("s", "longest stay"),
    Anomaly.LINE: Unit("side", "allowed: 1 to the right, -1 to the left"),
}

_COLUMNS = (
    "t_us", "event_index", "track_id", "kind", "zone", "x", "y", "score", "expected", "seen", "unit", "begin_us", "birth_us",
)  # fmt: skip


def rows(alarms: NDArray[np.void], zones: Sequence[str] = (), lines: Sequence[str] = ()) -> list[dict[str, Any]]:
    """Alarms as plain values by field name, with kinds and zones by name; `zone` is None if there is none."""
    found = []
    for alarm in alarms:
        kind = Anomaly(int(alarm["kind"]))
        names = lines if kind is Anomaly.LINE else zones
        row = {name: alarm[name].item() for name in _COLUMNS if name != "unit"}
        row["kind"], row["unit"] = kind.name.lower(), UNITS[kind].name
        row["zone"] = names[int(alarm["zone"])] if alarm["zone"] >= 0 else None
        found.append({name: round(row[name], 4) if isinstance(row[name], float) else row[name] for name in _COLUMNS})
    return found


def check_table_path(path: Path) -> None:
    """Raise ConfigError for a suffix that `write_alarms` does not support."""
    if path.suffix.lower() not in (".csv", ".json"):
        raise ConfigError(f"{path}: must end in .csv or .json")


def write_alarms(path: Path, table: Sequence[dict[str, Any]], *, force: bool = False) -> None:
    """Write `rows` as .csv or .json.

    Raises:
        ConfigError: unknown suffix.
        OutputError: the file cannot be written.
    """
    check_table_path(path)
    if path.suffix.lower() == ".json":
        text = json.dumps(list(table), indent=2, allow_nan=False) + "\n"
    else:
        lines = [",".join(_cell(row[name]) for name in _COLUMNS) for row in table]
        text = "\n".join([",".join(_COLUMNS), *lines]) + "\n"
    with written_aside(path, force=force) as file:
        file.write(text.encode())


def _cell(value: Any) -> str:
    text = "" if value is None else str(value)
    quoted = text.replace('"', '""')
    return f'"{quoted}"' if any(sign in text for sign in ',"\n\r') else text
