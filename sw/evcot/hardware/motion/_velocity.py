# SPDX-License-Identifier: Apache-2.0
"""The velocity of a slot: an alpha-beta correction with the time since the last one, and the displacement in a motion step."""

from __future__ import annotations

import numpy as np
from numba import njit

from ..._numba_private import step
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
    REACH,
    RUN_FROM,
    RUN_MAX,
    RUN_X,
    RUN_Y,
    SETTLE,
    SPEED_MAX,
    STEP_LOG2,
    TICKS_MAX,
    USUAL,
    V_X,
    V_Y,
    Table,
)

__all__ = ["advance", "bit_length", "correct_velocity", "gain_log2", "over"]

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
def gain_log2(s: Table, r: Table, i: int, done: int, run: int) -> int:
    """The gain of an axis, as -log2: it falls with the number of corrections, and rises while these agree in direction.

    While the slot meets another, its events may be the other's: the gain is halved, and does not rise.
    """
    gain = min(1 + (done >> r[GAIN_SLOW]), r[GAIN_LOG2])
    if s[MEETS, i]:
        return int(gain + 1)
    if r[GAIN_FAST] == 0:
        return int(gain)
    return int(max(gain - max(abs(run) - RUN_FROM, 0), min(gain, r[GAIN_FAST])))


@step
def correct_velocity(s: Table, r: Table, i: int, now: int) -> None:
    """Turn what the sides had to be moved since the last correction, beyond the prediction, into a change of velocity."""
    ticks = min(max(now - s[LAST, i], 1), TICKS_MAX)
    done = s[CORRECTIONS, i]
    if done >= 2:
        slower = done < r[SETTLE]
        d_x = _common(s[OFF_LO_X, i], s[OFF_HI_X, i], slower)
        d_y = _common(s[OFF_LO_Y, i], s[OFF_HI_Y, i], slower)
        s[RUN_X, i] = _run(s[RUN_X, i], d_x)
        s[RUN_Y, i] = _run(s[RUN_Y, i], d_y)
        shift = r[STEP_LOG2] - 1
        most = r[SPEED_MAX]
        v_x = s[V_X, i] + over(d_x, ticks, shift - gain_log2(s, r, i, done, s[RUN_X, i]))
        v_y = s[V_Y, i] + over(d_y, ticks, shift - gain_log2(s, r, i, done, s[RUN_Y, i]))
        s[V_X, i] = max(-most, min(most, v_x))
        s[V_Y, i] = max(-most, min(most, v_y))
    s[OFF_LO_X, i] = 0
    s[OFF_HI_X, i] = 0
    s[OFF_LO_Y, i] = 0
    s[OFF_HI_Y, i] = 0
    s[USUAL, i] = ticks if done == 0 else s[USUAL, i] + ((ticks - s[USUAL, i]) >> 2)
    s[LAST, i] = now


@step
def _move(s: Table, lo: int, hi: int, way: int, i: int, reach: int) -> None:
    """Move both sides of an axis, unless one of them would go too far out of the sensor."""
    low = s[lo, i] + way
    high = s[hi, i] + way
    if -reach <= low and low < 2 * reach and -reach <= high and high < 2 * reach:
        s[lo, i] = low
        s[hi, i] = high


@step
def advance(s: Table, r: Table, lim: Table, i: int, now: int) -> None:
    """A motion step: box and velocity go on; what has been silent for long slows down, unless another may hide it."""
    v_x = s[V_X, i]
    v_y = s[V_Y, i]
    silent = not s[MEETS, i] and now - s[LAST, i] > s[USUAL, i] << 1
    slow = r[COAST_SLOW] if silent else 0
    _move(s, LO_X, HI_X, v_x >> slow, i, lim[REACH])
    _move(s, LO_Y, HI_Y, v_y >> slow, i, lim[REACH])
    if silent and r[FRICTION]:
        s[V_X, i] = v_x - (v_x >> r[FRICTION])
        s[V_Y, i] = v_y - (v_y >> r[FRICTION])
