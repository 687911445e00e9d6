# SPDX-License-Identifier: Apache-2.0
"""Sort keys: events packed into integers that sort by time, and their conversion to events."""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit, step
from ..events import Events

__all__ = ["KEY_T_SHIFT", "events_of", "sorted_keys", "unpacked", "without_intervals"]

# An event as one integer: t_us << 33 | x << 17 | y << 1 | p, with times from 0 to 2**30.
KEY_T_SHIFT = 33

_FEW = 512  # below, a comparison sort is faster
_SHORT = 32  # maximum number of keys in a bucket for insertion sort


def events_of(keys: NDArray[np.int64], end_us: int) -> Events:
    """The events before `end_us`, sorted by time, then x, y and p; from (n,) keys in any order."""
    ordered = sorted_keys(keys)
    return unpacked(ordered[: int(np.searchsorted(ordered, end_us << KEY_T_SHIFT))])


def unpacked(keys: NDArray[np.int64]) -> Events:
    """The events of sorted keys."""
    events = Events.allocated(len(keys))
    _unpack(keys, events.t_us, events.x, events.y, events.p)
    return events


def sorted_keys(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """A sorted copy."""
    return np.sort(keys) if len(keys) < _FEW else cast("NDArray[np.int64]", _by_key(keys))


@njit(cache=True, nogil=True)
def _by_key(keys):  # type: ignore[no-untyped-def]
    """A sorted copy: bucket sort by time, with one or two keys per bucket on average, followed by insertion sort."""
    base = keys.min() >> KEY_T_SHIFT << KEY_T_SHIFT
    span, shift = keys.max() - base, KEY_T_SHIFT
    while span >> shift > len(keys):
        shift += 1
    ends = np.zeros((span >> shift) + 2, np.uint32)
    for key in keys:
        ends[((key - base) >> shift) + 1] += np.uint32(1)
    for bucket in range(1, len(ends)):
        ends[bucket] += ends[bucket - 1]
    ordered = np.empty_like(keys)
    for key in keys:
        bucket = (key - base) >> shift
        ordered[ends[bucket]] = key
        ends[bucket] += np.uint32(1)
    begin = 0
    for bucket in range(len(ends) - 1):
        end = int(ends[bucket])
        if end - begin > _SHORT:
            ordered[begin:end].sort()
        begin = end
    _insert(ordered)
    return ordered


@step
def _insert(keys):  # type: ignore[no-untyped-def]
    """Insertion sort, for keys that are almost in order."""
    for i in range(1, len(keys)):
        key, at = keys[i], i
        while at > 0 and keys[at - 1] > key:
            keys[at] = keys[at - 1]
            at -= 1
        keys[at] = key


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
