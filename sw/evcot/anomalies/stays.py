# SPDX-License-Identifier: Apache-2.0
"""Stays: how long an object has lingered at a place, across tracks.

An object that stands still causes no events, and gets a new track afterwards. So stays are stored independently of tracks: a
track that lingers nearby before `gap_us` have passed continues the stay.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._numba_private import step

__all__ = ["Stays", "leave", "no_stays", "settle"]

_STAYS = 256  # capacity; the oldest are overwritten
_NEVER = -1e300


class Stays(NamedTuple):
    """Stays without a current track, (256,) each: position (px), start and end (us after the first record), time during which
    something was observed to linger (us), and whether an alarm was raised."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    since: NDArray[np.float64]
    until: NDArray[np.float64]
    lingered: NDArray[np.float64]
    raised: NDArray[np.uint8]


def no_stays() -> Stays:
    """An empty memory of stays."""
    x, y, since, lingered = np.zeros((4, _STAYS))
    return Stays(x, y, since, np.full(_STAYS, _NEVER), lingered, np.zeros(_STAYS, np.uint8))


@step
def leave(stays, trace, raised, least_us):  # type: ignore[no-untyped-def]
    """Store a track's stay, if it was long enough, when the track ends or leaves the place."""
    if not trace.settled or trace.lingered_t - trace.anchor_t < least_us:
        return
    i = np.argmin(stays.until)
    stays.x[i] = trace.anchor_x
    stays.y[i] = trace.anchor_y
    stays.since[i] = trace.anchor_t
    stays.until[i] = trace.lingered_t
    stays.lingered[i] = trace.lingered_us
    stays.raised[i] = raised


@step
def settle(stays, trace, radius_px, gap_us):  # type: ignore[no-untyped-def]
    """Let a track that begins, or arrives at a place, take over the longest stay there; returns whether that has an alarm."""
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
