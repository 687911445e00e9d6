# SPDX-License-Identifier: Apache-2.0
"""The velocities of a slot: that of its box, by an alpha-beta correction with the time since the last, and the stated one."""

from __future__ import annotations

import numpy as np

from ..._numba_private import njit, step
from ._state import (
    COAST_SLOW,
    CORRECTIONS,
    FRICTION,
    GAIN_FAST,
    GAIN_LOG2,
    GAIN_SLOW,
    HI_X,
    HI_Y,
    LAST,
    LO_X,
    LO_Y,
    MEETS,
    OFF_HI_X,
    OFF_HI_Y,
    OFF_LO_X,
    OFF_LO_Y,
    PACE_MAX,
    PACE_SLOW,
    PACE_X,
    PACE_Y,
    REACH,
    RUN_FROM,
    RUN_MAX,
    RUN_X,
    RUN_Y,
    SETTLE,
    SPEED_MAX,
    STATED_X,
    STATED_Y,
    STEP_LOG2,
    TICKS_MAX,
    USUAL,
    V_X,
    V_Y,
    WAS_X,
    WAS_Y,
    WAY_MAX,
    Table,
)

__all__ = ["advance", "begin_pace", "bit_length", "correct_velocity", "follow_pace", "gain_log2", "over", "settle_pace"]

INVERSES = np.array([round(1024 / (8.5 + m)) for m in range(8)], np.int64)  # 128 / (1 + (m + 1/2) / 8)


@step
def bit_length(value: int) -> int:
    """The number of bits of a value that is not negative."""
    bits = 0
    while value > 0:
        value >>= 1
        bits += 1
    return bits


@njit(cache=True, nogil=True)
def over(distance: int, ticks: int, shift: int) -> int:
    """distance * 2^shift / ticks, by the leading bit of `ticks` and the three below it, within 6 %."""
    leading = bit_length(ticks) - 1
    below = (ticks >> (leading - 3)) & 7 if leading >= 3 else (ticks << (3 - leading)) & 7
    product = distance * INVERSES[below]
    down = leading + 7 - shift
    return int(product >> down if down >= 0 else product << -down)


@step
def _common(low: int, high: int, slower: bool) -> int:
    """Twice the way that two sides have in common: their mean, or the shorter of two ways in one direction."""
    if not slower:
        return low + high
    if (low > 0) != (high > 0):
        return 0
    return 2 * low if abs(low) < abs(high) else 2 * high


@step
def _run(run: int, way: int) -> int:
    """How many corrections in a row went upwards, or downwards if negative, with this one."""
    if way > 0:
        return min(max(run, 0) + 1, RUN_MAX)
    return max(min(run, 0) - 1, -RUN_MAX) if way < 0 else 0


@step
def gain_log2(s: Table, r: Table, i: int, done: int, run: int, in_burst: bool) -> int:
    """The gain of an axis, as -log2: it falls with the number of corrections, and rises while these agree in direction.

    While the slot meets another, its events may be the other's: the gain is halved, and does not rise. Within a burst, the gain
    is 1/2, or 1 while corrections agree.
    """
    gain = 1 if in_burst else min(1 + (done >> r[GAIN_SLOW]), r[GAIN_LOG2])
    if s[i, MEETS]:
        return int(gain + 1)
    if in_burst:
        return 0 if abs(run) > RUN_FROM else 1
    if r[GAIN_FAST] == 0:
        return int(gain)
    return int(max(gain - max(abs(run) - RUN_FROM, 0), min(gain, r[GAIN_FAST])))


@step
def correct_velocity(s: Table, r: Table, i: int, now: int, in_burst: bool) -> None:
    """Turn what the sides had to be moved since the last correction, beyond the prediction, into a change of velocity.

    The movement that a second correction within a burst finds stays for the next burst.
    """
    ticks = min(max(now - s[i, LAST], 1), TICKS_MAX)
    done = s[i, CORRECTIONS]
    if done >= 2 and ticks > 1:
        slower = done < r[SETTLE] and not in_burst
        d_x = _common(s[i, OFF_LO_X], s[i, OFF_HI_X], slower)
        d_y = _common(s[i, OFF_LO_Y], s[i, OFF_HI_Y], slower)
        s[i, RUN_X] = _run(s[i, RUN_X], d_x)
        s[i, RUN_Y] = _run(s[i, RUN_Y], d_y)
        shift = r[STEP_LOG2] - 1
        most = r[SPEED_MAX]
        v_x = s[i, V_X] + over(d_x, ticks, shift - gain_log2(s, r, i, done, s[i, RUN_X], in_burst))
        v_y = s[i, V_Y] + over(d_y, ticks, shift - gain_log2(s, r, i, done, s[i, RUN_Y], in_burst))
        s[i, V_X] = max(-most, min(most, v_x))
        s[i, V_Y] = max(-most, min(most, v_y))
    if ticks > 1:
        s[i, OFF_LO_X] = 0
        s[i, OFF_HI_X] = 0
        s[i, OFF_LO_Y] = 0
        s[i, OFF_HI_Y] = 0
    if done == 0:
        s[i, USUAL] = ticks
    elif ticks > 1:
        s[i, USUAL] += (ticks - s[i, USUAL]) >> 2
    s[i, LAST] = now


@step
def _move(s: Table, lo: int, hi: int, way: int, i: int, reach: int) -> None:
    """Move both sides of an axis, unless one of them would go too far out of the sensor."""
    low = s[i, lo] + way
    high = s[i, hi] + way
    if -reach <= low and low < 2 * reach and -reach <= high and high < 2 * reach:
        s[i, lo] = low
        s[i, hi] = high


@step
def advance(s: Table, r: Table, lim: Table, i: int, now: int) -> None:
    """A motion step: box and velocity go on; what has been silent for long slows down, unless another may hide it."""
    v_x = s[i, V_X]
    v_y = s[i, V_Y]
    silent = not s[i, MEETS] and now - s[i, LAST] > s[i, USUAL] << 1
    slow = r[COAST_SLOW] if silent else 0
    _move(s, LO_X, HI_X, v_x >> slow, i, lim[REACH])
    _move(s, LO_Y, HI_Y, v_y >> slow, i, lim[REACH])
    if silent and r[FRICTION]:
        s[i, V_X] = v_x - (v_x >> r[FRICTION])
        s[i, V_Y] = v_y - (v_y >> r[FRICTION])


@step
def _follow(s: Table, i: int, lo: int, hi: int, was: int, pace: int, stated: int, slow: int) -> None:
    """How far an axis has moved since the last step, smoothed twice."""
    middle = s[i, lo] + s[i, hi]
    way = ((middle - s[i, was] + WAY_MAX + 1) & (2 * WAY_MAX + 1)) - WAY_MAX - 1
    way = max(-PACE_MAX - 1, min(PACE_MAX, way))
    half = 1 << (slow - 1)
    s[i, pace] += (way - s[i, pace] + half) >> slow
    s[i, stated] += (s[i, pace] - s[i, stated] + half) >> slow
    s[i, was] = middle


@step
def begin_pace(s: Table, i: int) -> None:
    """The stated velocity begins with that of the corrections."""
    settle_pace(s, i)
    s[i, PACE_X] = s[i, V_X] << 1
    s[i, PACE_Y] = s[i, V_Y] << 1
    s[i, STATED_X] = s[i, PACE_X]
    s[i, STATED_Y] = s[i, PACE_Y]


@step
def settle_pace(s: Table, i: int) -> None:
    """The next displacement counts from where the box is now."""
    s[i, WAS_X] = s[i, LO_X] + s[i, HI_X]
    s[i, WAS_Y] = s[i, LO_Y] + s[i, HI_Y]


@step
def follow_pace(s: Table, i: int) -> None:
    """The stated velocity at a motion step: over as many steps as the box takes to move by about its shorter side."""
    shorter = max(min(s[i, HI_X] - s[i, LO_X], s[i, HI_Y] - s[i, LO_Y]), 0)
    speed = max(abs(s[i, STATED_X]), abs(s[i, STATED_Y]))
    slow = PACE_SLOW
    while slow > 1 and speed << slow > shorter:
        slow -= 1
    _follow(s, i, LO_X, HI_X, WAS_X, PACE_X, STATED_X, slow)
    _follow(s, i, LO_Y, HI_Y, WAS_Y, PACE_Y, STATED_Y, slow)
