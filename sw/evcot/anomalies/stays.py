# SPDX-License-Identifier: Apache-2.0
"""Stays: how long something has lingered at a place, whichever track it is at the moment.

Who stands still for a moment makes no events, and is another track afterwards. So a stay outlives the track: what lingers near
it before `gap_us` have passed goes on with it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

__all__ = ["Stays", "leave", "no_stays", "settle"]

_STAYS = 256  # remembered; of more the oldest are forgotten
_NEVER = -1e300


class Stays(NamedTuple):
    """Stays that no track has at the moment, (256,) each: the place (px), since when and until when (us after the first
    record), for how long of that something was seen to linger (us), and whether an alarm was raised."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    since: NDArray[np.float64]
    until: NDArray[np.float64]
    lingered: NDArray[np.float64]
    raised: NDArray[np.uint8]


def no_stays() -> Stays:
    """A memory without any."""
    x, y, since, lingered = np.zeros((4, _STAYS))
    return Stays(x, y, since, np.full(_STAYS, _NEVER), lingered, np.zeros(_STAYS, np.uint8))


@njit(cache=True, nogil=True)
def leave(stays, trace, raised, least_us):  # type: ignore[no-untyped-def]
    """A track ends, or goes away from its place: what it lingered there, if it did for long enough, is remembered."""
    if not trace.settled or trace.lingered_t - trace.anchor_t < least_us:
        return
    i = np.argmin(stays.until)
    stays.x[i] = trace.anchor_x
    stays.y[i] = trace.anchor_y
    stays.since[i] = trace.anchor_t
    stays.until[i] = trace.lingered_t
    stays.lingered[i] = trace.lingered_us
    stays.raised[i] = raised


@njit(cache=True, nogil=True)
def settle(stays, trace, radius_px, gap_us):  # type: ignore[no-untyped-def]
    """A track begins, or has come to another place: the longest stay there is its own now. Whether that has raised an alarm."""
    best = -1
    for i in range(len(stays.until)):
        if trace.t - stays.until[i] > gap_us or math.hypot(stays.x[i] - trace.x, stays.y[i] - trace.y) > radius_px:
            continue
        if best < 0 or stays.since[i] < stays.since[best]:
            best = i
    if best < 0:
        trace.anchor_t = trace.lingered_t = trace.t
        trace.anchor_x = trace.x
        trace.anchor_y = trace.y
        trace.lingered_us = 0.0
        return 0
    trace.anchor_t = stays.since[best]
    trace.lingered_t = stays.until[best]
    trace.anchor_x = stays.x[best]
    trace.anchor_y = stays.y[best]
    trace.lingered_us = stays.lingered[best]
    return stays.raised[best]
