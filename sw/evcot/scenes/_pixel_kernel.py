# SPDX-License-Identifier: Apache-2.0
"""Kernel: the pixels of an event camera between two frames.

Between the frames a pixel's log intensity is interpolated linearly. The pixel stores the log intensity at its last event; when
the difference to it reaches a threshold, the pixel emits an event and the stored value changes by that threshold. During the
refractory time after an event the pixel is held in reset, and at its end it stores the current log intensity. A spontaneous
event resets the pixel in the same way.
"""

from __future__ import annotations

import math

import numpy as np

from .._numba_private import njit, step
from ._order import KEY_T_SHIFT

__all__ = [
    "AT_ONCE",
    "LOG_INTENSITY_MAX",
    "MEMORY",
    "NEVER",
    "OFF",
    "ON",
    "READY",
    "ROUNDING",
    "STATES",
    "are_within",
    "begin",
    "exponential",
    "levels_of",
    "logarithm",
    "longer",
    "one_pixel",
    "pixel_events",
    "quiet_bounds",
]

_SQRT_HALF = 0x3FE6A09E667F3BCD  # the bits of sqrt(1/2)
_LN2_HIGH, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
_LOG2_E = 1.0 / math.log(2.0)
_LOG = (  # coefficients of (log((1 + s) / (1 - s)) - 2 s) / s in powers of s^2
    6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01, 2.222219843214978396e-01,
    1.818357216161805012e-01, 1.531383769920937332e-01, 1.479819860511658591e-01,
)  # fmt: skip


@step
def logarithm(value):  # type: ignore[no-untyped-def]
    """Natural logarithm of a positive normal number, to less than an ulp: fdlibm's method.

    A value is 2^k z with z from sqrt(1/2) to sqrt(2); with f = z - 1 and s = f / (2 + f), log z = log((1 + s) / (1 - s)).
    """
    bits = np.float64(value).view(np.int64)
    k = (bits - _SQRT_HALF) >> 52
    f = np.int64(bits - (k << 52)).view(np.float64) - 1.0
    s = f / (2.0 + f)  # never divides by 0: z is at least sqrt(1/2)
    w = s * s
    q = w * w
    odd = w * (_LOG[0] + q * (_LOG[2] + q * (_LOG[4] + q * _LOG[6])))
    even = q * (_LOG[1] + q * (_LOG[3] + q * _LOG[5]))
    half = 0.5 * f * f
    return k * _LN2_HIGH - ((half - (s * (half + odd + even) + k * _LN2_LOW)) - f)


@step
def exponential(value):  # type: ignore[no-untyped-def]
    """e^value to a relative error of 1e-8, for values from -700 to 700: 2^k times a Taylor polynomial of the rest."""
    k = np.floor(value * _LOG2_E + 0.5)
    r = value - k * (_LN2_HIGH + _LN2_LOW)
    s = r * r
    low, high = 1.0 + r + s * (1 / 2 + r * (1 / 6)), 1 / 24 + r * (1 / 120) + s * (1 / 720 + r * (1 / 5040))
    return np.int64((np.int64(k) + 1023) << 52).view(np.float64) * (low + s * s * high)


NEVER = -np.inf  # in `ready`: the pixel is not in its refractory time
LOG_INTENSITY_MAX = 100.0

ROUNDING = 1.0 - 1e-9  # tolerance for the rounding of a sum of steps towards a threshold
_STRICTER = 1e-6, 2e-5  # how much inside linear bounds (relative), and logarithmic ones, are kept, which are float32
_LIGHT_MAX = math.exp(LOG_INTENSITY_MAX) * (1 - _STRICTER[0])
_LIGHT_MIN = math.exp(-LOG_INTENSITY_MAX) * (1 + _STRICTER[0])

MEMORY, READY, ON, OFF = range(4)  # of `states`; those of one pixel lie in one line of the cache
STATES = 4
AT_ONCE = 64  # pixels whose memory is fetched in parallel


@njit(cache=True, nogil=True)
def are_within(rectangles, width, height):  # type: ignore[no-untyped-def]
    """Whether rectangles, as of `pixel_events`, lie within the sensor."""
    for i in range(len(rectangles)):
        if rectangles[i, 0] < 0 or rectangles[i, 1] < 0 or rectangles[i, 2] > width or rectangles[i, 3] > height:
            return False
    return True


@njit(cache=True, nogil=True)
def pixel_events(rectangles, frame, linear, pixels, head, own, from_us, span_us, refractory_us):  # type: ignore[no-untyped-def]
    """Keys of the events in (0, span_us] after the last frame, which is at from_us, in any order; times are relative to it.

    `rectangles` (n, 4): left, top, right, bottom, half open: where `frame` (at span_us) may have changed. `linear`: whether
    frames hold intensity; else its logarithm. `pixels`: see `begin`; it is updated. `head`: a map of -1. `own`: dtype `OWN`,
    spontaneous events in time order. At a log intensity outside -LOG_INTENSITY_MAX to LOG_INTENSITY_MAX the result ends, and
    its second part is the pixel's index, else -1.
    """
    last, low, high, states = pixels
    link = np.empty(len(own), np.int64)
    for i in range(len(own) - 1, -1, -1):
        x, y = own[i].x, own[i].y
        link[i] = head[y, x]
        head[y, x] = i
        low[y, x] = high[y, x] = np.inf
    keys, n = np.empty(256 + 2 * len(own), np.int64), 0
    restless = _restless(rectangles, frame, last, low, high)
    levels, known = np.empty((2, AT_ONCE)), np.empty((AT_ONCE, STATES))
    for begin in range(0, len(restless), AT_ONCE):
        some = restless[begin : begin + AT_ONCE]
        fault = _measure(some, frame, linear, last, states, levels, known)
        if fault >= 0:
            return keys[:n], fault
        for i in range(len(some)):
            x, y, first = some[i] >> 17, some[i] >> 1 & 0xFFFF, -1
            if high[y, x] == np.inf:
                first, head[y, x] = head[y, x], -1
            if frame[y, x] == last[y, x] and first < 0:
                continue
            last[y, x] = frame[y, x]
            now = first, levels[0, i], levels[1, i]
            while True:
                past = _move(keys, n, x, y, now, known[i], linear, pixels, link, own, from_us, span_us, refractory_us)
                if past <= len(keys):
                    break
                keys = longer(keys, n, past)
            n = past
    for i in range(len(own)):
        x, y = own[i].x, own[i].y
        if head[y, x] >= 0:
            level = _level(last[y, x], linear)
            now = head[y, x], level, level
            while True:
                past = _move(keys, n, x, y, now, states[y, x], linear, pixels, link, own, from_us, span_us, refractory_us)
                if past <= len(keys):
                    break
                keys = longer(keys, n, past)
            n, head[y, x] = past, -1
    return keys[:n], -1


@step
def _move(keys, n, x, y, now, state, linear, pixels, link, own, from_us, span_us, refractory_us):  # type: ignore[no-untyped-def]
    """Append the events of one pixel of this state. `now`: its first spontaneous event, and its log intensity before and after.
    Updates `pixels` if the keys have room; returns the new count."""
    (_, low, high, states), (first, before, after) = pixels, now
    on, off = state[ON], state[OFF]
    n, _, memory, ready = one_pixel(
        keys, n, 0, x << 17 | y << 1, before, after, state[MEMORY], state[READY], on, off, link, first, len(own), own, from_us,
        span_us, refractory_us,
    )  # fmt: skip
    if n <= len(keys):
        states[y, x, MEMORY], states[y, x, READY] = memory, ready
        low[y, x], high[y, x] = quiet_bounds(memory, ready, on, off, linear)
    return n


@njit(cache=True, nogil=True)
def longer(keys, n, least):  # type: ignore[no-untyped-def]
    """The first `n` keys, with room for at least so many."""
    more = np.empty(2 * least, np.int64)
    for i in range(n):  # a copy of slices would take a second more to compile: Numba then formats what it raises
        more[i] = keys[i]
    return more


@njit(cache=True, nogil=True)
def _restless(rectangles, frame, last, low, high):  # type: ignore[no-untyped-def]
    """Pixels, as x << 17 | y << 1, whose values are not within their bounds; the values of the others are stored."""
    found, n = np.empty(1024, np.int64), 0
    for r in range(len(rectangles)):
        width = rectangles[r, 2] - rectangles[r, 0]
        for y in range(rectangles[r, 1], rectangles[r, 3]):
            if n + width > len(found):
                found = longer(found, n, n + width)
            n = _scan(frame, last, low, high, y, rectangles[r, 0], rectangles[r, 2], found, n)
    return found[:n]


@step
def _scan(frame, last, low, high, y, left, right, found, n):  # type: ignore[no-untyped-def]
    """`_restless` of one row, appended to the first `n` found; returns the new count."""
    row = np.uint64(y)  # unsigned indices do not count from the end, which takes instructions
    for x in range(np.uint64(left), np.uint64(right)):
        if low[row, x] < frame[row, x] and frame[row, x] < high[row, x]:
            last[row, x] = frame[row, x]
        else:
            found[n] = np.int64(x) << 17 | y << 1
            n += 1
    return n


@step
def _measure(some, frame, linear, last, states, levels, known):  # type: ignore[no-untyped-def]
    """Write the log intensity before and after of some pixels, and their states; returns the index of the first whose log
    intensity is not allowed, else -1. Pixels are independent here, so their memory is fetched in parallel."""
    for i in range(np.uint64(len(some))):
        x, y = np.uint64(some[i] >> 17), np.uint64(some[i] >> 1 & 0xFFFF)
        levels[0, i], levels[1, i] = last[y, x], frame[y, x]
        for j in range(STATES):
            known[i, j] = states[y, x, j]
    for row in range(2):
        for i in range(np.uint64(len(some))):
            levels[row, i] = _level(levels[row, i], linear)
    for i in range(len(some)):
        if not abs(levels[1, i]) <= LOG_INTENSITY_MAX:
            return (some[i] >> 1 & 0xFFFF) * frame.shape[1] + (some[i] >> 17)
    return -1


@step
def _level(value, linear):  # type: ignore[no-untyped-def]
    """Log intensity of a frame's value; NaN if there is none."""
    if not linear:
        return value
    return logarithm(value) if value > 0.0 else np.nan


@njit(cache=True, nogil=True)
def levels_of(frame, linear):  # type: ignore[no-untyped-def]
    """Log intensity of each of a frame's values; NaN where there is none."""
    levels = np.empty_like(frame)
    for y in range(frame.shape[0]):
        for x in range(frame.shape[1]):
            levels[y, x] = _level(frame[y, x], linear)
    return levels


@step
def quiet_bounds(memory, ready, on, off, linear):  # type: ignore[no-untyped-def]
    """The bounds within which a value of a frame makes no event; (inf, -inf) in the refractory time."""
    if ready != NEVER:
        return np.inf, -np.inf
    low, high = memory - off * ROUNDING, memory + on * ROUNDING
    if linear:
        return max(exponential(low) * (1 + _STRICTER[0]), _LIGHT_MIN), min(exponential(high) * (1 - _STRICTER[0]), _LIGHT_MAX)
    return max(low, -LOG_INTENSITY_MAX) + _STRICTER[1], min(high, LOG_INTENSITY_MAX) - _STRICTER[1]


@njit(cache=True, nogil=True)
def begin(frame, levels, linear, on, off):  # type: ignore[no-untyped-def]
    """Pixels in a steady state on a frame, whose log intensity is `levels`: (last, low, high, states), maps of the sensor: the
    last frame; the bounds within which the next makes no event; stored log intensity, end of the refractory time (absolute) or
    `NEVER`, and thresholds."""
    low, high = np.empty(frame.shape, np.float32), np.empty(frame.shape, np.float32)
    states = np.zeros((*frame.shape, STATES))
    for y in range(frame.shape[0]):
        for x in range(frame.shape[1]):
            state = states[y, x]
            state[MEMORY], state[READY], state[ON], state[OFF] = levels[y, x], NEVER, on[y, x], off[y, x]
            low[y, x], high[y, x] = quiet_bounds(levels[y, x], NEVER, on[y, x], off[y, x], linear)
    return frame.copy(), low, high, states


@step
def one_pixel(  # type: ignore[no-untyped-def]
    keys, n, begin_us, address, before, after, memory, ready, on, off, link, first, past, own, from_us, span_us, refractory_us
):
    """Append the events of one pixel, whose log intensity goes from `before` to `after` in the `span_us` after `from_us`.

    Args:
        keys: of the events, of which there are `n`; those that have no room are only counted.
        begin_us, address: of the keys: time of the begin, and x << 17 | y << 1.
        memory, ready, on, off: its state, see `begin`.
        first, past: the pixel's next spontaneous event, or -1; those from `past` on are later.

    Returns:
        The new count, and the new `first`, stored log intensity and end of the refractory time.
    """
    ready -= from_us
    slope, address = (after - before) / span_us, begin_us << KEY_T_SHIFT | address
    now = 0.0
    i = first
    while True:
        due = 0 <= i < past
        until = own[i].t_us if due else span_us
        level = before + slope * until if due else after
        while True:
            if ready != NEVER:
                if ready > until:
                    break
                memory = before + slope * max(ready, 0.0)
                now = max(now, ready)
                ready = NEVER
            if level - memory >= on * ROUNDING:
                p, memory = 1, memory + on
            elif memory - level >= off * ROUNDING:
                p, memory = 0, memory - off
            else:
                break
            if slope != 0.0:
                now = min(max((memory - before) / slope, now), until)
            n = _append(keys, n, now, address | p)
            if refractory_us > 0:
                ready = now + refractory_us
        if not due:
            break
        now = until
        if ready == NEVER:
            n = _append(keys, n, now, address | own[i].p)
            memory = level
            if refractory_us > 0:
                ready = now + refractory_us
        i = link[i]
    return n, i, memory, ready + from_us


@step
def _append(keys, n, now_us, key):  # type: ignore[no-untyped-def]
    """Append a key, which is later by some time; returns the new count."""
    if n < len(keys):
        keys[n] = (int(now_us + 0.5) << KEY_T_SHIFT) + key
    return n + 1
