# SPDX-License-Identifier: Apache-2.0
"""Kernel: the pixels of an event camera between two frames.

Between the frames a pixel's log intensity is interpolated linearly. The pixel stores the log intensity at its last event; when
the difference to it reaches a threshold, the pixel emits an event and the stored value changes by that threshold. During the
refractory time after an event the pixel is held in reset, and at its end it stores the current log intensity. A spontaneous
event resets the pixel in the same way.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .._numba_private import step
from ._order import KEY_T_SHIFT

__all__ = ["LOG_INTENSITY_MAX", "NEVER", "are_within", "pixel_events"]

NEVER = -np.inf  # in `ready`: the pixel is not in its refractory time
LOG_INTENSITY_MAX = 100.0

_ROUNDING = 1.0 - 1e-9  # tolerance for the rounding of a sum of steps towards a threshold


@njit(cache=True, nogil=True)
def are_within(rectangles, width, height):  # type: ignore[no-untyped-def]
    """Whether rectangles, as of `pixel_events`, lie within the sensor."""
    for i in range(len(rectangles)):
        left, top, right, bottom = rectangles[i]
        if left < 0 or top < 0 or right > width or bottom > height:
            return False
    return True


@njit(cache=True, nogil=True)
def pixel_events(rectangles, frame, pixels, head, own, from_us, span_us, refractory_us):  # type: ignore[no-untyped-def]
    """Keys of the events in (0, span_us] after the last frame, which is at from_us, in any order; times are relative to it.

    `rectangles` (n, 4): left, top, right, bottom, half open: where `frame` (log intensity at span_us) may have changed.
    `pixels`: (last, memory, ready, on, off), maps of the sensor: log intensity at the last frame, stored value, end of the
    refractory time (absolute) or `NEVER`, thresholds. `head`: a map of -1. `own`: dtype `OWN`, spontaneous events in time
    order. All maps but the thresholds are updated. At a log intensity outside -LOG_INTENSITY_MAX to LOG_INTENSITY_MAX the
    result ends, and its second part is the pixel's index, else -1.
    """
    last, memory, ready, on, off = pixels
    link = np.empty(len(own), np.int64)
    for i in range(len(own) - 1, -1, -1):
        link[i] = head[own[i].y, own[i].x]
        head[own[i].y, own[i].x] = i
    keys, n = np.empty(256 + 2 * len(own), np.int64), 0
    for r in range(len(rectangles)):
        left, top, right, bottom = rectangles[r]
        for y in range(top, bottom):
            for x in range(left, right):
                after = frame[y, x]
                if after == last[y, x] and head[y, x] < 0:
                    continue
                if not abs(after) <= LOG_INTENSITY_MAX:
                    return keys[:n], y * frame.shape[1] + x
                change = after - memory[y, x]
                if -off[y, x] * _ROUNDING < change < on[y, x] * _ROUNDING and ready[y, x] == NEVER and head[y, x] < 0:
                    last[y, x] = after
                    continue
                most = int((abs(after - last[y, x]) + on[y, x] + off[y, x]) / min(on[y, x], off[y, x])) + 2 + len(own)
                if n + most > len(keys):
                    longer = np.empty(2 * (n + most), np.int64)
                    longer[:n] = keys[:n]
                    keys = longer
                n = _one_pixel(keys, n, x, y, after, pixels, head, link, own, from_us, span_us, refractory_us)
    for i in range(len(own)):
        x, y = own[i].x, own[i].y
        if head[y, x] >= 0:
            n = _one_pixel(keys, n, x, y, last[y, x], pixels, head, link, own, from_us, span_us, refractory_us)
    return keys[:n], -1


@step
def _one_pixel(keys, n, x, y, after, pixels, head, link, own, from_us, span_us, refractory_us):  # type: ignore[no-untyped-def]
    """Append the events of one pixel, whose log intensity at span_us is `after`, and return the new count."""
    last, memories, readies, on, off = pixels
    before, memory, ready = last[y, x], memories[y, x], readies[y, x] - from_us
    slope = (after - before) / span_us
    address = x << 17 | y << 1
    now = 0.0
    i = head[y, x]
    while True:
        until = own[i].t_us if i >= 0 else span_us
        level = before + slope * until if i >= 0 else after
        while True:
            if ready != NEVER:
                if ready > until:
                    break
                memory = before + slope * max(ready, 0.0)
                now = max(now, ready)
                ready = NEVER
            if level - memory >= on[y, x] * _ROUNDING:
                p, memory = 1, memory + on[y, x]
            elif memory - level >= off[y, x] * _ROUNDING:
                p, memory = 0, memory - off[y, x]
            else:
                break
            if slope != 0.0:
                now = min(max((memory - before) / slope, now), until)
            keys[n] = int(now + 0.5) << KEY_T_SHIFT | address | p
            n += 1
            if refractory_us > 0:
                ready = now + refractory_us
        if i < 0:
            break
        now = until
        if ready == NEVER:
            keys[n] = int(now + 0.5) << KEY_T_SHIFT | address | own[i].p
            n += 1
            memory = level
            if refractory_us > 0:
                ready = now + refractory_us
        i = link[i]
    last[y, x], memories[y, x], readies[y, x], head[y, x] = after, memory, ready + from_us, -1
    return n
