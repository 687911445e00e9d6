# SPDX-License-Identifier: Apache-2.0
"""Kernels: objects that fly straight between common turns, and bounce off the walls of a room."""

from __future__ import annotations

import numpy as np

from .._numba_private import njit
from .shapes import INTENSITY, X, Y

__all__ = ["bounce", "insects_at"]


@njit(cache=True, nogil=True)
def bounce(times_s, turns_s, starts, speeds, room, low):  # type: ignore[no-untyped-def]
    """Places and velocities, (2, k, n) each, of n objects at k times.

    Args:
        times_s, turns_s: the times, and those at which a leg begins.
        starts, speeds: (2, legs, n) place at the begin of each leg, without walls and counted from `low`, and velocity.
        room, low: (2,) size and least place of the room.
    """
    places, velocities = np.empty((2, len(times_s), starts.shape[2])), np.empty((2, len(times_s), starts.shape[2]))
    for k in range(len(times_s)):
        leg = min(np.searchsorted(turns_s, times_s[k], side="right") - 1, speeds.shape[1] - 1)
        elapsed_s = times_s[k] - turns_s[leg]
        for axis in range(2):
            there_and_back = 2 * room[axis]
            for i in range(starts.shape[2]):
                speed = speeds[axis, leg, i]
                way = (starts[axis, leg, i] + speed * elapsed_s) % there_and_back
                back = way > room[axis]
                places[axis, k, i] = low[axis] + (there_and_back - way if back else way)
                velocities[axis, k, i] = -speed if back else speed
    return places, velocities


@njit(cache=True, nogil=True)
def insects_at(times_s, still, wave, contrast, tip_x, wave_px, flight):  # type: ignore[no-untyped-def]
    """The shapes of `insects` at k times, (k, n, columns).

    Args:
        still: (n, columns) glints, blades and insects, with what never changes.
        wave: (2, glints + blades) angular frequency and first angle of the sine of each: that of a glint is its log intensity,
            up to `contrast` each way; that of a blade moves the middle of its upper end, `tip_x`, by `wave_px` each way.
        flight: the arguments of `bounce` but the times.
    """
    places, _ = bounce(times_s, *flight)
    shapes = np.empty((len(times_s), *still.shape))
    insects = wave.shape[1]
    blades = insects - len(tip_x)
    for k in range(len(shapes)):
        for i in range(len(still)):
            for column in range(still.shape[1]):
                shapes[k, i, column] = still[i, column]
        for i in range(insects):
            height = np.sin(wave[0, i] * times_s[k] + wave[1, i])
            if i < blades:
                shapes[k, i, INTENSITY] = np.exp(contrast * (1 + height))
            else:
                tip = tip_x[i - blades] + wave_px * height
                shapes[k, i, X + 2], shapes[k, i, X + 3] = tip + 0.5, tip - 0.5
        for i in range(places.shape[2]):
            shapes[k, insects + i, X], shapes[k, insects + i, Y] = places[0, k, i], places[1, k, i]
    return shapes
