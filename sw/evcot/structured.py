# SPDX-License-Identifier: Apache-2.0
"""Events as one structured array with the fields x, y, p and t, as other packages hold them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import RecordingError

__all__ = ["EVENT_CD", "Columns", "array_of", "columns_of"]

EVENT_CD = np.dtype([("x", "<u2"), ("y", "<u2"), ("p", "<i2"), ("t", "<i8")])
"""The layout of OpenEB and Metavision, EventCD: 14 bytes an event."""

Columns = tuple[NDArray[np.int64], NDArray[np.uint16], NDArray[np.uint16], NDArray[np.uint8]]
"""t in microseconds, x, y, p."""

_TYPES: dict[str, np.dtype[Any]] = {
    "t": np.dtype(np.int64),
    "x": np.dtype(np.uint16),
    "y": np.dtype(np.uint16),
    "p": np.dtype(np.uint8),
}
_LIMITS = {"t": (-(2**63), 2**63 - 1), "x": (0, 65_535), "y": (0, 65_535), "p": (0, 1)}


def columns_of(array: NDArray[np.void]) -> Columns:
    """The four fields of (n,) structured events, checked; views of the array wherever the field's bytes allow it.

    Raises:
        RecordingError: see `events.Events.from_array`.
    """
    _check_fields(array.dtype)
    if array.ndim != 1:
        raise RecordingError(f"array: {array.ndim} dimensions: must be one, with one entry an event")
    t, x, y, p = (_column(name, array[name]) for name in _TYPES)
    backwards = np.flatnonzero(t[1:] < t[:-1])
    if len(backwards):
        i = int(backwards[0]) + 1
        raise RecordingError(f"array: event {i}: t = {t[i]} us follows t = {t[i - 1]} us: time must not run back")
    return t, x, y, p


def array_of(columns: Columns, dtype: np.dtype[Any]) -> NDArray[np.void]:
    """(n,) structured events of a dtype with the fields x, y, p and t, in any order: a copy.

    Raises:
        RecordingError: see `events.Events.to_array`.
    """
    _check_fields(dtype)
    unknown = [name for name in dtype.names or () if name not in _TYPES]
    if unknown:
        raise RecordingError(f"array: field {unknown[0]!r}: must be one of x, y, p, t")
    array = np.empty(len(columns[0]), dtype)
    named: dict[str, NDArray[Any]] = dict(zip(_TYPES, columns, strict=True))
    for name, values in named.items():
        if dtype[name].kind != "b":
            limits = np.iinfo(dtype[name])
            _check_range(name, values, int(limits.min), int(limits.max))
        array[name] = values
    return array


def _check_fields(dtype: np.dtype[Any]) -> None:
    for name in _TYPES:
        if name not in (dtype.names or ()):
            raise RecordingError(f"array: no field {name}: must be a structured array with the fields x, y, p and t")
        kinds = "iub" if name == "p" else "iu"
        if dtype[name].kind not in kinds:
            raise RecordingError(f"array: field {name} is {dtype[name]}: must be a whole number")


def _column(name: str, values: NDArray[Any]) -> NDArray[Any]:
    """A field as the column's type: a view of its low bytes where they are that type, else a copy."""
    _check_range(name, values, *_LIMITS[name])
    wanted = _TYPES[name]
    own = values.dtype
    if own == wanted:
        return values
    if own.itemsize < wanted.itemsize or own.byteorder == ">":
        return np.asarray(values.astype(wanted))
    low = np.dtype({"names": ["low"], "formats": [wanted], "offsets": [0], "itemsize": own.itemsize})
    return np.asarray(values.view(low)["low"])


def _check_range(name: str, values: NDArray[Any], low: int, high: int) -> None:
    if len(values) and not low <= int(values.min()) <= int(values.max()) <= high:
        i = next(i for i, value in enumerate(values.tolist()) if not low <= value <= high)
        raise RecordingError(f"array: event {i}: {name} = {values[i]}: must be from {low} to {high}")
