# SPDX-License-Identifier: Apache-2.0
"""From what a file holds to the four columns of `Events`, narrowed without losing anything on the way."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..errors import RecordingError
from ..events import Events

__all__ = ["Decoded", "Sensor", "events_from_columns", "events_from_packets", "smallest_sensor"]

Sensor = tuple[int, int]
_Width = TypeVar("_Width", bound=np.integer[Any])


@dataclass(frozen=True)
class Decoded:
    """What a file says: its events, and the sensor's (width, height) in pixels, given or inferred."""

    events: Events
    sensor: Sensor


def _narrow(name: str, values: NDArray[Any], dtype: type[_Width]) -> NDArray[_Width]:
    if values.ndim != 1 or values.dtype.kind not in "iub":
        raise RecordingError(f"{name}: is {values.ndim}-D of {values.dtype}: must be a list of integers")
    limits = np.iinfo(dtype)
    if values.dtype.kind != "b" and not np.can_cast(values.dtype, dtype):
        outside = np.flatnonzero((values < limits.min) | (values > limits.max))
        if len(outside):
            i = int(outside[0])
            raise RecordingError(f"event {i}: {name} = {values[i]}: must be from {limits.min} to {limits.max}")
    return np.ascontiguousarray(values, dtype)


def events_from_columns(t_us: NDArray[Any], x: NDArray[Any], y: NDArray[Any], p: NDArray[Any]) -> Events:
    """Four (n,) integer columns of any width as `Events`; columns that fit already are not copied.

    Raises:
        RecordingError: a column that is no list of integers, or a value that its field cannot hold.
    """
    return Events(
        t_us=_narrow("t", t_us, np.int64),
        x=_narrow("x", x, np.uint16),
        y=_narrow("y", y, np.uint16),
        p=_narrow("p", p, np.uint8),
    )


def events_from_packets(packets: Iterable[NDArray[np.void]]) -> Events:
    """Packets with the fields t (below 2^63), x, y, on, joined; two copies of the events exist at a time."""
    parts = list(packets)
    if not parts:
        return Events.empty()

    def joined(field: str, dtype: type[_Width]) -> NDArray[_Width]:
        return np.concatenate([part[field] for part in parts], dtype=dtype, casting="unsafe")

    return Events(joined("t", np.int64), joined("x", np.uint16), joined("y", np.uint16), joined("on", np.uint8))


def smallest_sensor(events: Events) -> Sensor:
    """The smallest (width, height) that holds every event; (1, 1) for none."""
    if not len(events):
        return 1, 1
    return int(events.x.max()) + 1, int(events.y.max()) + 1
