# SPDX-License-Identifier: Apache-2.0
"""Common names of the fields of an event, and time units stated in them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from ...errors import RecordingError
from .hdf5_survey import NAMES

__all__ = ["UNITS", "Naming", "find_fields"]

_MEANINGS = {name: field for field, names in NAMES.items() for name in names}
_POWERS = {"s": 6, "ms": 3, "us": 0, "ns": -3}
UNITS = {6: "seconds", 3: "milliseconds", 0: "microseconds", -3: "nanoseconds"}  # of 10**power us
_LONGEST_NAME = 256  # of a field: the regular expression takes quadratic time in the length
_NAME = re.compile(rf"(.*?)(?:(?:_|\s*[(\[])({'|'.join(_POWERS)})[)\]]?)?")


@dataclass(frozen=True)
class Naming:
    """Assignment of names to t, x, y and p.

    Attributes:
        columns: index of t, x, y, p among the names.
        power: the unit of time is 10**power us, as stated in its name (`t_us`, `t_s`, `t[s]`); None if not stated.
    """

    columns: tuple[int, int, int, int]
    power: int | None


def find_fields(names: Sequence[str]) -> Naming:
    """Find t, x, y and p among column names, ignoring case and other columns.

    Raises:
        RecordingError: no name, or more than one, for a field; the message is the rule and names the field.
    """
    found: dict[str, list[int]] = {"t": [], "x": [], "y": [], "p": []}
    power = None
    for i, name in enumerate(names):
        match = _NAME.fullmatch(name.strip().strip("\"'").lower()) if len(name) <= _LONGEST_NAME else None
        stem, unit = match.groups() if match else ("", None)
        field = _MEANINGS.get(stem)
        if field is not None and (unit is None or field == "t"):
            found[field].append(i)
            power = power if unit is None else _POWERS[unit]
    wrong = next((field for field, places in found.items() if len(places) != 1), None)
    if wrong is not None:
        raise RecordingError(f"must name each of t, x, y, p once; {wrong} is not")
    t, x, y, p = (places[0] for places in found.values())
    return Naming((t, x, y, p), power)
