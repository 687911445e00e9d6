# SPDX-License-Identifier: Apache-2.0
"""Follows lines through the spikes of the transform, on an angle axis that is cyclic; docs/lines.md has the rules.

State of a line: angle of the normal, turning speed, distance from the anchor along the normal, speed of that distance.
The anchor is the running mean of the pixels of its spikes. A pixel at (dx, dy) from the anchor measures
e = dx cos(angle) + dy sin(angle) - distance, which is 0 on the line. The filter is the extended Kalman filter with a fading
memory: Simon, Optimal State Estimation, Wiley 2006, section 7.4.
"""

from __future__ import annotations

from math import cos, floor, pi, sin

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit, step
from ..events import Events
from .contract import HoughConfig
from .transform import HoughTransform

__all__ = ["LINE", "LineFollower"]

LINE = np.dtype([("t_us", "<i8"), ("line_id", "<i4"), ("angle_deg", "<f8"), ("rho_px", "<f8"), ("turn_deg_s", "<f8")])
"""A measurement of a line: time, id from 1, direction of its normal, distance from the middle of the sensor, turning speed.

A point (x, y) of the line, in pixels from the middle of the sensor, has x cos(angle) + y sin(angle) = rho. The angle of a line
is continuous: it goes beyond 180 degrees and below 0, and rho keeps its sign meanwhile.
"""

_SLOTS = 16  # lines and candidates at one time

# Columns of a slot: own spikes (0: free), id (0: candidate), number of the spike with which it began, time of the last spike,
# anchor, state, covariance.
_SPIKES, _ID, _BEGAN, _LAST, _X, _Y, _STATE, _COVARIANCE = 0, 1, 2, 3, 4, 5, 6, 10
_FIELDS = _COVARIANCE + 16

# Tuned on the validation seeds of benchmarks/lines.py.
_GATE_PX = 6.0  # farthest pixel from the line that is the line's
_NEAR_PX = 12.0  # up to this distance from a reported line nothing begins
_GATE_STEPS = 1.5  # farthest angle of a spike from the line's, in steps of the transform
_CONFIRM = 32  # spikes before a line is reported
_TRIAL = 512  # spikes of all lines after which a candidate that is not reported ends
_LIFE_US = 100_000.0  # time without a spike after which a line ends
_FADING = 128.0 / 127.0  # growth of the covariance per spike: a memory of 128 spikes
_NOISE_PX2 = 2.0  # variance of a pixel across the line
_ANCHOR_SHARE = 1.0 / 16.0  # of a spike's pixel in the anchor
# Standard deviations of a new line, and the largest ones of any line.
_TURN_RAD_S, _SLIDE_PX_S, _PLACE_PX = 10.0, 100.0, 2.0


@njit(cache=True, nogil=True)
def _follow(t_us, x, y, index, step_rad, slots, counts, lines):  # type: ignore[no-untyped-def]
    """Follow lines through a run of spikes.

    Args:
        t_us, x, y, index: (n,), time, pixel from the middle of the sensor, and index of the angle of each spike.
        step_rad: from one angle to the next.
        slots, counts: (_SLOTS, _FIELDS) and (2,), the state: lines and candidates; numbers of spikes and of ids so far.
        lines: the columns of `follower.LINE`, (n,) each, which are filled in.

    Returns:
        Number of entries in `lines`.
    """
    out_t, out_id, out_angle, out_rho, out_turn = lines
    count = 0
    for i in range(len(t_us)):
        spike_angle = index[i] * step_rad
        counts[0] += 1
        slot = _line_of(slots, counts[0], t_us[i], x[i], y[i], spike_angle, step_rad)
        if slot == -1:
            _begin(slots, counts[0], t_us[i], x[i], y[i], spike_angle, step_rad)
        if slot < 0:
            continue
        line = slots[slot]
        _correct(line, t_us[i], x[i], y[i], step_rad)
        if line[_SPIKES] < _CONFIRM:
            continue
        if line[_ID] == 0:
            counts[1] += 1
            line[_ID] = counts[1]
        _end_doubles(slots, slot, step_rad)
        angle = line[_STATE]
        out_t[count], out_id[count] = t_us[i], line[_ID]
        out_angle[count], out_turn[count] = angle * (180 / pi), line[_STATE + 1] * (180 / pi)
        out_rho[count] = line[_X] * cos(angle) + line[_Y] * sin(angle) + line[_STATE + 2]
        count += 1
    return count


@step
def _apart(one, other):  # type: ignore[no-untyped-def]
    """Difference of two angles of lines, modulo half a turn: from -pi/2 to pi/2."""
    difference = one - other
    return difference - pi * floor(difference / pi + 0.5)


@step
def _line_of(slots, number, t_us, x, y, spike_angle, step_rad):  # type: ignore[no-untyped-def]
    """The slot whose line the spike belongs to, reported lines first; -1: none; -2: none, and nothing begins here."""
    best, best_px, none = -1, 1e9, -1
    for slot in range(len(slots)):
        line = slots[slot]
        if line[_SPIKES] == 0:
            continue
        dt_us = t_us - line[_LAST]
        if dt_us > _LIFE_US or (line[_ID] == 0 and number - line[_BEGAN] > _TRIAL):
            line[_SPIKES] = 0
            continue
        angle = line[_STATE] + line[_STATE + 1] * dt_us * 1e-6
        if abs(_apart(spike_angle, angle)) > _GATE_STEPS * step_rad:
            continue
        place = line[_STATE + 2] + line[_STATE + 3] * dt_us * 1e-6
        off_px = abs((x - line[_X]) * cos(angle) + (y - line[_Y]) * sin(angle) - place)
        if off_px <= _GATE_PX:
            rank_px = off_px if line[_ID] > 0 else off_px + _GATE_PX
            if rank_px < best_px:
                best, best_px = slot, rank_px
        elif line[_ID] > 0 and off_px < _NEAR_PX:
            none = -2
    return best if best >= 0 else none


@step
def _begin(slots, number, t_us, x, y, spike_angle, step_rad):  # type: ignore[no-untyped-def]
    """A candidate begins in the first free slot; none if all are in use."""
    for slot in range(len(slots)):
        line = slots[slot]
        if line[_SPIKES] == 0:
            line[:] = 0
            line[_SPIKES], line[_BEGAN], line[_LAST] = 1, number, t_us
            line[_X], line[_Y], line[_STATE] = x, y, spike_angle
            for i in range(4):
                line[_COVARIANCE + 5 * i] = _largest(i, step_rad)
            return


@step
def _largest(i, step_rad):  # type: ignore[no-untyped-def]
    """Largest variance of a component of the state."""
    if i == 0:
        return (0.5 * step_rad) ** 2
    if i == 1:
        return _TURN_RAD_S**2
    return _PLACE_PX**2 if i == 2 else _SLIDE_PX_S**2


@step
def _correct(line, t_us, x, y, step_rad):  # type: ignore[no-untyped-def]
    """Predict the line to the time of a spike, then correct it by the spike's pixel."""
    dt = (t_us - line[_LAST]) * 1e-6
    state, p = line[_STATE : _STATE + 4], line[_COVARIANCE : _COVARIANCE + 16]
    state[0] += state[1] * dt
    state[2] += state[3] * dt
    for i in range(4):
        p[i] += dt * p[4 + i]
        p[8 + i] += dt * p[12 + i]
    for i in range(0, 16, 4):
        p[i] += dt * p[i + 1]
        p[i + 2] += dt * p[i + 3]
    for i in range(16):
        p[i] *= _FADING

    cosine, sine = cos(state[0]), sin(state[0])
    dx, dy = x - line[_X], y - line[_Y]
    along = dy * cosine - dx * sine
    off = dx * cosine + dy * sine - state[2]
    # The derivative of `off` by the state is (along, 0, -1, 0).
    g0, g1 = along * p[0] - p[2], along * p[4] - p[6]
    g2, g3 = along * p[8] - p[10], along * p[12] - p[14]
    variance = along * g0 - g2 + _NOISE_PX2
    gain = (g0, g1, g2, g3)
    for i in range(4):
        state[i] -= gain[i] * off / variance
        for j in range(i + 1):
            # One value for both halves: the matrix must stay symmetric, or it grows without bound.
            p[4 * i + j] = p[4 * j + i] = p[4 * i + j] - gain[i] * gain[j] / variance
    for i in range(4):
        excess = p[5 * i] / _largest(i, step_rad)
        if excess > 1:
            for j in range(4):
                p[4 * i + j] *= excess**-0.5
                p[4 * j + i] *= excess**-0.5

    move_x, move_y = _ANCHOR_SHARE * dx, _ANCHOR_SHARE * dy
    line[_X] += move_x
    line[_Y] += move_y
    state[2] -= move_x * cos(state[0]) + move_y * sin(state[0])
    line[_SPIKES] += 1
    line[_LAST] = t_us


@step
def _end_doubles(slots, slot, step_rad):  # type: ignore[no-untyped-def]
    """End candidates and younger lines that have become the same line."""
    line = slots[slot]
    cosine, sine = cos(line[_STATE]), sin(line[_STATE])
    for i in range(len(slots)):
        other = slots[i]
        if other[_SPIKES] == 0 or (0 < other[_ID] <= line[_ID]):
            continue
        off = (other[_X] - line[_X]) * cosine + (other[_Y] - line[_Y]) * sine - line[_STATE + 2]
        if abs(off) < _GATE_PX and abs(_apart(other[_STATE], line[_STATE])) < step_rad:
            other[_SPIKES] = 0


class LineFollower:
    """The lines in a stream of events: feed events in blocks of any length.

    Args:
        config: shape and registers of the transform.
    """

    def __init__(self, config: HoughConfig) -> None:
        self._transform = HoughTransform(config)
        self._config = config
        self._slots = np.zeros((_SLOTS, _FIELDS))
        self._counts = np.zeros(2, np.int64)  # spikes, ids

    def feed(self, events: Events) -> NDArray[np.void]:
        """The lines of a block of events: (m,) of dtype `LINE`, one entry for each spike of a line, in time order."""
        first = self._transform.events
        spikes = self._transform.feed(events.x, events.y)
        index = spikes["event"] - first
        config = self._config
        x = events.x[index] - (config.width - 1) / 2
        y = events.y[index] - (config.height - 1) / 2
        lines = np.empty(len(spikes), LINE)
        columns = tuple(lines[name] for name in LINE.names or ())
        t_us = events.t_us[index]
        return lines[: _follow(t_us, x, y, spikes["angle"], np.pi / config.angles, self._slots, self._counts, columns)].copy()
