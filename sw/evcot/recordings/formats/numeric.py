# SPDX-License-Identifier: Apache-2.0
"""Columns of numbers as general containers hold them: of any width, often floating, polarity as 0 and 1 or as -1 and 1."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ...errors import RecordingError
from ...events import Events

__all__ = ["events_from_numbers", "events_from_records", "microseconds", "whole_numbers"]

_Width = TypeVar("_Width", bound=np.integer[Any])
# From here on, floating numbers are not told apart from their neighbours; and sums of times stay within 64 bits.
_EXACT = 1 << 53
_LATEST_US = 1 << 62


@njit(cache=True, nogil=True)
def _fill_whole(values, least, most, signed, out):  # type: ignore[no-untyped-def]
    """Integers of integers, -1 as 0 if `signed`: the index of the first outside the limits, or how many there are."""
    for i in range(len(values)):
        value = np.int64(values[i])
        value += signed & (value == -1)
        if (value < least) | (value > most):
            return i
        out[i] = value
    return len(values)


@njit(cache=True, nogil=True)
def _fill_rounded(values, scale, least, most, signed, out):  # type: ignore[no-untyped-def]
    """The same of floating numbers times `scale`, rounded; unscaled ones must be whole."""
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
    """(n,) numbers of any type as integers of `dtype`.

    Args:
        first_index: of the first value, for messages.
        signed: whether -1 stands for 0.

    Raises:
        RecordingError: a value that is no whole number, or that the type cannot hold.
    """
    if not signed and values.dtype.kind in "iub" and np.can_cast(values.dtype, dtype):
        return np.ascontiguousarray(values, dtype)
    limits = np.iinfo(dtype)
    return _filled(name, values, dtype, (limits.min, limits.max), first_index, signed=signed)


def microseconds(values: NDArray[Any], first_index: int = 0, t0_us: int = 0) -> NDArray[np.int64]:
    """(n,) times: integers are microseconds, floating numbers are seconds, rounded to the nearest microsecond; from `t0_us`,
    which must be below 2^62.

    Raises:
        RecordingError: a time that is no number, or not below 2^62.
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
    """In a type that the kernels know."""
    if values.dtype == np.float16:
        return values.astype(np.float32)
    if values.dtype.kind == "f" and values.dtype.itemsize > 8:
        with np.errstate(over="ignore", invalid="ignore"):
            return values.astype(np.float64)
    return values if values.dtype.isnative else values.astype(values.dtype.newbyteorder("="))


# Prophesee's record in HDF5, as C lays it out: two words, of which `events_from_records` takes the fields in one pass.
_RECORD = np.dtype({"names": ["x", "y", "p", "t"], "formats": ["<u2", "<u2", "<i2", "<i8"], "offsets": [0, 2, 4, 8]})


@njit(cache=True, nogil=True)
def _fill_records(words, latest_us, t0_us, t_us, x, y, p):  # type: ignore[no-untyped-def]
    """Fills the four columns; false where some time or polarity is not an ordinary one."""
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
    """Prophesee's records as events; None where they are others, or a value is no ordinary one: `events_from_numbers` then says
    which."""
    if records.dtype != _RECORD or not records.flags.c_contiguous:
        return None
    events = Events.allocated(len(records))
    columns = events.t_us, events.x, events.y, events.p
    return events if _fill_records(records.view("<i8"), np.int64(_LATEST_US), t0_us, *columns) else None


def events_from_numbers(
    t: NDArray[Any], x: NDArray[Any], y: NDArray[Any], p: NDArray[Any], first_index: int = 0, t0_us: int = 0
) -> Events:
    """Four (n,) columns of numbers as events: times as in `microseconds`, polarities 0 and 1 or -1 and 1.

    Raises:
        RecordingError: a value that its field cannot hold.
    """
    return Events(
        t_us=microseconds(t, first_index, t0_us),
        x=whole_numbers("x", x, np.uint16, first_index),
        y=whole_numbers("y", y, np.uint16, first_index),
        p=whole_numbers("p", p, np.uint8, first_index, signed=p.dtype.kind in "if"),
    )
