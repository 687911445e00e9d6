# SPDX-License-Identifier: Apache-2.0
"""Columns of numbers as in general containers: of any type, often floating-point, polarity as 0 and 1 or as -1 and 1.

Four columns without names are judged by their first values. The orders in use are t, x, y, p; x, y, t, p; x, y, p, t
(Metavision, eDVS); p, t, x, y; and p, x, y, t. An order is possible if its x and y can be addresses and its p can be a
polarity. Of the possible ones:

1. A time that cannot be an address (fractions, or above 65535) settles the order, however few the rows are.
2. Else, with 16 rows or more, times hardly ever run back. Of several such orders it is the one whose times do not all stand
   still, then the one whose times run back least. Addresses of one frame, pixel by pixel, do not count as times.
3. With fewer rows it is t, x, y, p.
4. If times run back in more than a quarter of the rows in every order, the columns are in none of these.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import njit
from ...errors import RecordingError
from ...events import Events
from .hdf5_survey import NAMES

__all__ = [
    "RECORD",
    "SAMPLED_ROWS",
    "UNITS",
    "Naming",
    "Order",
    "column_order",
    "events_from_numbers",
    "events_from_records",
    "find_fields",
    "microseconds",
    "order_text",
    "polarities",
    "whole_numbers",
    "without_unsigned_minus_one",
]

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


_Width = TypeVar("_Width", bound=np.integer[Any])
# Above this, floating-point numbers cannot represent every microsecond; and sums of times stay within 64 bits.
_EXACT = 1 << 53
_LATEST_US = 1 << 62


@njit(cache=True, nogil=True)
def _fill_whole(values, least, most, signed, out):  # type: ignore[no-untyped-def]
    """Copy integers, -1 as 0 if `signed`; returns the index of the first outside the limits, or the number of values."""
    for i in range(len(values)):
        value = np.int64(values[i])
        value += signed & (value == -1)
        if (value < least) | (value > most):
            return i
        out[i] = value
    return len(values)


@njit(cache=True, nogil=True)
def _fill_rounded(values, scale, least, most, signed, out):  # type: ignore[no-untyped-def]
    """The same for floating-point numbers times `scale`, rounded; with a scale of 1 they must be whole."""
    for i in range(len(values)):
        value = np.float64(values[i])
        if signed & (value == -1.0):
            value = np.float64(0.0)
        rounded = np.rint(value * scale)
        if not ((rounded >= least) & (rounded <= most)) or ((scale == 1.0) & (rounded != value)):
            return i
        out[i] = np.int64(rounded)
    return len(values)


def whole_numbers(
    name: str, values: NDArray[Any], dtype: type[_Width], first_index: int = 0, *, signed: bool = False
) -> NDArray[_Width]:
    """Convert (n,) numbers of any type to integers of `dtype`.

    Args:
        first_index: index of the first value, for messages.
        signed: whether -1 means 0.

    Raises:
        RecordingError: a value that is not a whole number, or outside the range of the type.
    """
    if not signed and values.dtype.kind in "iub" and np.can_cast(values.dtype, dtype):
        return np.ascontiguousarray(values, dtype)
    limits = np.iinfo(dtype)
    return _filled(name, values, dtype, (limits.min, limits.max), first_index, signed=signed)


def polarities(values: NDArray[Any], first_index: int = 0) -> NDArray[np.uint8]:
    """Convert (n,) polarities: 1 or true; 0, -1 or false. In an unsigned type, -1 is stored as the largest number.

    Raises:
        RecordingError: another value.
    """
    values = without_unsigned_minus_one(values)
    return whole_numbers("p", values, np.uint8, first_index, signed=values.dtype.kind in "if")


def without_unsigned_minus_one(values: NDArray[Any]) -> NDArray[Any]:
    """Polarities with 0 in place of the largest number of an unsigned type, which is -1 without its sign.

    Raises:
        RecordingError: 0 occurs, too, and 1 does not: the largest number may then stand for 1.
    """
    if values.dtype.kind != "u":
        return values
    most = np.iinfo(values.dtype).max
    minus_one = values == most
    if not minus_one.any():
        return values
    if (values == 0).any() and not (values == 1).any():
        raise RecordingError(f"p = {most} and p = 0: must be {most}, which is -1 without its sign, and 1; or 0 and 1")
    return np.where(minus_one, values.dtype.type(0), values)


def microseconds(values: NDArray[Any], first_index: int = 0, t0_us: int = 0) -> NDArray[np.int64]:
    """Convert (n,) times: integers are microseconds, floating-point numbers are seconds, rounded to the nearest microsecond;
    counted from `t0_us`, which must be below 2^62.

    Raises:
        RecordingError: a time that is not a number, or not below 2^62.
    """
    times: NDArray[np.int64]
    if values.dtype.kind in "iub" and values.dtype.itemsize < 8:
        times = np.add(values, t0_us, dtype=np.int64)
        return times
    times = _filled("t", values, np.int64, (-_LATEST_US, _LATEST_US), first_index, scale=1e6)
    times += t0_us
    return times


def _filled(
    name: str,
    values: NDArray[Any],
    dtype: type[_Width],
    limits: tuple[int, int],
    first_index: int,
    *,
    scale: float = 1.0,
    signed: bool = False,
) -> NDArray[_Width]:
    values = _plain(values)
    filled = np.empty(len(values), dtype)
    if values.dtype.kind == "f":
        least, most = (min(max(limit, -_EXACT), _EXACT) for limit in limits)
        wrong = int(_fill_rounded(values, scale, least, most, signed, filled))
    else:
        # From 2^63 on, unsigned ones are negative to the kernel, and so outside every range from 0.
        least, most = max(limits[0], 0) if values.dtype == np.uint64 else limits[0], limits[1]
        wrong = int(_fill_whole(values.view(np.int64) if values.dtype == np.uint64 else values, least, most, signed, filled))
    if wrong < len(values):
        rule = f"must be a whole number from {limits[0]} to {limits[1]}" if scale == 1 else "must be a number of seconds"
        raise RecordingError(f"event {first_index + wrong}: {name} = {values[wrong]}: {rule}")
    return filled


def _plain(values: NDArray[Any]) -> NDArray[Any]:
    """The values in a type that the kernels are compiled for."""
    if values.dtype == np.float16:
        return values.astype(np.float32)
    if values.dtype.kind == "f" and values.dtype.itemsize > 8:
        with np.errstate(over="ignore", invalid="ignore"):
            return values.astype(np.float64)
    return values if values.dtype.isnative else values.astype(values.dtype.newbyteorder("="))


# Prophesee's record in HDF5, laid out as in C: two words, which `events_from_records` decodes in one pass.
RECORD = np.dtype({"names": ["x", "y", "p", "t"], "formats": ["<u2", "<u2", "<i2", "<i8"], "offsets": [0, 2, 4, 8]})


@njit(cache=True, nogil=True)
def _fill_records(words, latest_us, t0_us, t_us, x, y, p):  # type: ignore[no-untyped-def]
    """Fill the four columns; returns False if some time or polarity is out of range."""
    beyond = polarity = np.int64(0)
    for i in range(len(t_us)):
        word, t = words[2 * i], words[2 * i + 1]
        beyond |= (t + latest_us) | (latest_us - t)  # one of them is negative, or wraps around to be so
        polarity |= word >> 32
        t_us[i] = t + t0_us
        x[i] = word
        y[i] = word >> 16
        p[i] = word >> 32
    return beyond >= 0 and polarity & 0xFFFE == 0


def events_from_records(records: NDArray[np.void], t0_us: int = 0) -> Events | None:
    """Decode Prophesee's records; None if they have another layout, or a value is out of range: `events_from_numbers` then
    reports which."""
    if records.dtype != RECORD or not records.flags.c_contiguous:
        return None
    events = Events.allocated(len(records))
    columns = events.t_us, events.x, events.y, events.p
    return events if _fill_records(records.view("<i8"), np.int64(_LATEST_US), t0_us, *columns) else None


def events_from_numbers(
    t: NDArray[Any], x: NDArray[Any], y: NDArray[Any], p: NDArray[Any], first_index: int = 0, t0_us: int = 0
) -> Events:
    """Convert four (n,) columns of numbers to events: times as in `microseconds`, polarities 0 and 1 or -1 and 1.

    Raises:
        RecordingError: a value outside the range of its field.
    """
    return Events(
        t_us=microseconds(t, first_index, t0_us),
        x=whole_numbers("x", x, np.uint16, first_index),
        y=whole_numbers("y", y, np.uint16, first_index),
        p=polarities(p, first_index),
    )


Order = tuple[int, int, int, int]  # the columns of t, x, y, p

SAMPLED_ROWS = 4096  # more than a row of pixels: events of a whole frame, pixel by pixel, may all have one time
_FEWEST_ROWS = 16  # with less, how times go on says nothing
_ORDERS: tuple[Order, ...] = ((0, 1, 2, 3), (2, 0, 1, 3), (3, 0, 1, 2), (1, 2, 3, 0), (3, 1, 2, 0))
_POLARITIES = (-1, 0, 1, *(float((1 << bits) - 1) for bits in (8, 16, 32, 64)))  # the last four are -1 without its sign
_DISORDER = 0.05  # share of rows that may run back in a recording: drivers and mergers swap neighbours
_NO_TIME = 0.25  # share of rows that run back, from which on a column is no time; of an address it is about a half


def column_order(sample: NDArray[Any]) -> Order:
    """The columns of t, x, y, p among the first four of (n, 4 or more) numbers, the first `SAMPLED_ROWS` rows.

    Raises:
        RecordingError: in every possible order, times run back in more than a quarter of the rows.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        columns = np.asarray(sample, np.float64).T
        possible = [order for order in _ORDERS if _is_possible(columns, order)]
        settled = [order for order in possible if _is_no_address(columns[order[0]])]
        enough = columns.shape[1] >= _FEWEST_ROWS
        back = [_back(column) for column in columns]

        def rank(order: Order) -> tuple[bool, bool, bool, float]:
            t, x, y, _ = (columns[i] for i in order)
            scanned = (_range(y) <= 1 and _is_scan(t, x)) or (_range(x) <= 1 and _is_scan(t, y))
            return back[order[0]] > _DISORDER, scanned, _range(t) == 0, back[order[0]]

        among = settled or (possible if enough else [_ORDERS[0]]) or [_ORDERS[0]]
        found = min(among, key=rank)
        if enough and possible and back[found[0]] > _NO_TIME:
            times = [f"column {i + 1}" for i, share in enumerate(back) if share <= _DISORDER and _range(columns[i]) > 0]
            looks = f"; {' or '.join(times)} goes on as a time does" if times else ""
            share = f"{100 * back[found[0]]:.0f} %"
            raise RecordingError(
                f"columns without names: as {order_text(found)}, times would run back in {share} of the first rows{looks}: "
                "must be t,x,y,p, x,y,t,p, x,y,p,t, p,t,x,y or p,x,y,t, or be named in a first line such as y,x,other,p,t"
            )
        return found


def order_text(order: Order) -> str:
    """An order as text, such as "x, y, t, p"."""
    return ", ".join(name for _, name in sorted(zip(order, "txyp", strict=True)))


def _is_address(column: NDArray[np.float64]) -> bool:
    return bool(((column >= 0) & (column <= 65535) & (column == np.rint(column))).all())


def _is_no_address(column: NDArray[np.float64]) -> bool:
    """Whether values are above all addresses, or most of them fractions."""
    return bool((column > 65535).any()) or bool((column != np.rint(column)).mean() > 0.5 if len(column) else False)


def _is_possible(columns: NDArray[np.float64], order: Order) -> bool:
    _, x, y, p = (columns[i] for i in order)
    return _is_address(x) and _is_address(y) and bool(np.isin(p, _POLARITIES).all())


def _range(column: NDArray[np.float64]) -> float:
    return float(np.ptp(column)) if len(column) else 0.0


def _is_scan(column: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    """Whether two columns are addresses of frames, pixel by pixel along rows or columns, but for a few steps: `column` is the
    slow one and has equal values, or the fast one and starts again."""
    step, other_step = np.diff(column), np.diff(other)
    slow = _mostly((step > 0) | ((step == 0) & (other_step > 0))) and bool((step == 0).any())
    fast = _mostly((other_step > 0) | ((other_step == 0) & (step > 0))) and bool((step < 0).any())
    return slow or fast


def _mostly(steps: NDArray[np.bool_]) -> bool:
    return bool(steps.mean() >= 1 - _DISORDER) if len(steps) else True


def _back(column: NDArray[np.float64]) -> float:
    """The share of rows whose value is below that of the row before."""
    return float((np.diff(column) < 0).mean()) if len(column) > 1 else 0.0
