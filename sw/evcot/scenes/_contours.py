# SPDX-License-Identifier: Apache-2.0
"""Kernel: events of a rectangle in straight motion, in closed form per pixel.

A pixel emits an event when its log intensity has moved by a threshold K: dI = pK. The rectangle changes log intensity by
`steps` thresholds over an edge one pixel wide: at signed depth d inside the contour (the least distance to its four sides)
the change is `steps * K * clip(d + 1/2, 0, 1)`. So the pixel crosses the level k + 1/2 of `steps` where d = (k + 1/2) / steps
- 1/2: once when the rectangle shrunk by d takes it in and once when it lets it go, both linear in time.
"""

from __future__ import annotations

from .._numba_private import njit, step
from ._order import KEY_T_SHIFT

__all__ = ["leg_events"]


@step
def _inside(pixel, centre, speed, reach):  # type: ignore[no-untyped-def]
    """The interval of times (from, to) with |pixel - (centre + speed t)| <= reach."""
    if speed == 0.0:
        if abs(pixel - centre) <= reach:
            return -1e300, 1e300
        return 1e300, -1e300
    a = (pixel - centre - reach) / speed
    b = (pixel - centre + reach) / speed
    return min(a, b), max(a, b)


@step
def _pixels(centre, travel, reach, size):  # type: ignore[no-untyped-def]
    """First and last pixel, on a sensor of `size`, swept by a side of half length `reach`."""
    low = min(centre, centre + travel) - reach
    high = max(centre, centre + travel) + reach
    return max(0, int(low)), min(size - 1, int(high) + 1)


@njit(cache=True, nogil=True)
def leg_events(keys, n, sensor, half, start, speed, from_us, to_us, brighter, steps):  # type: ignore[no-untyped-def]
    """Append the keys of the events in [from_us, to_us) after the first `n` and return the new count.

    `sensor`, `half` (half sides), `start` (centre at from_us) and `speed` (pixels per microsecond) are pairs (x, y). Events
    beyond the end of `keys` are counted but not written.
    """
    duration = to_us - from_us
    first_x, last_x = _pixels(start[0], speed[0] * duration, half[0] + 0.5, sensor[0])
    first_y, last_y = _pixels(start[1], speed[1] * duration, half[1] + 0.5, sensor[1])
    for k in range(steps):
        depth = (k + 0.5) / steps - 0.5
        for y in range(first_y, last_y + 1):
            y_from, y_to = _inside(y, start[1], speed[1], half[1] - depth)
            if y_from > y_to:
                continue
            for x in range(first_x, last_x + 1):
                x_from, x_to = _inside(x, start[0], speed[0], half[0] - depth)
                taken = max(x_from, y_from)
                left = min(x_to, y_to)
                if taken >= left:
                    continue
                address = x << 17 | y << 1
                if 0.0 <= taken < duration:
                    if n < len(keys):
                        keys[n] = int(from_us + taken) << KEY_T_SHIFT | address | brighter
                    n += 1
                if 0.0 <= left < duration:
                    if n < len(keys):
                        keys[n] = int(from_us + left) << KEY_T_SHIFT | address | (1 - brighter)
                    n += 1
    return n
