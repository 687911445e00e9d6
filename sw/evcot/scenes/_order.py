# SPDX-License-Identifier: Apache-2.0
"""Sort keys: events packed into integers that sort by time, and their conversion to events."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit
from ..events import Events

__all__ = ["KEY_T_SHIFT", "events_of", "unpacked", "without_intervals"]

# An event as one integer: t_us << 33 | x << 17 | y << 1 | p, with times from 0 to 2**30.
KEY_T_SHIFT = 33


def events_of(keys: NDArray[np.int64], end_us: int) -> Events:
    """The events before `end_us`, sorted by time, then x, y and p; from (n,) keys in any order."""
    ordered = np.sort(keys)
    return unpacked(ordered[: int(np.searchsorted(ordered, end_us << KEY_T_SHIFT))])


def unpacked(keys: NDArray[np.int64]) -> Events:
    """The events of sorted keys."""
    events = Events.allocated(len(keys))
    _unpack(keys, events.t_us, events.x, events.y, events.p)
    return events


@njit(cache=True, nogil=True)
def without_intervals(keys, times_us):  # type: ignore[no-untyped-def]
    """Sorted keys whose times have the number of their interval added (see `batch_events`), without that; changed in place."""
    k = 1
    for i in range(len(keys)):
        while keys[i] >> KEY_T_SHIFT > times_us[k] - times_us[0] + k:
            k += 1
        keys[i] -= k << KEY_T_SHIFT
    return keys


@njit(cache=True, nogil=True)
def _unpack(keys, t_us, x, y, p):  # type: ignore[no-untyped-def]
    for i in range(len(t_us)):
        key = keys[i]
        t_us[i] = key >> KEY_T_SHIFT
        x[i] = key >> 17 & 0xFFFF
        y[i] = key >> 1 & 0xFFFF
        p[i] = key & 1
