# SPDX-License-Identifier: Apache-2.0
"""The boxes of the box experiment: six lanes, each of which tests one aspect of a tracker.

From the top: a box in continuous motion (with a downward drift: a slanted path), two that meet and cross, one that stops and
restarts, one in continuous motion, two that meet and cross, and one that leaves before another enters. With both speeds the
upper three lanes are slow and the lower three fast.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .truth import Box

__all__ = ["LANES", "cast"]

LANES = 6
_DRIFT = 0.25  # of a lane, over the whole scene
_STOP = (0.35, 0.65)  # of the duration: when the stopping box stands still
_LEAVES, _ENTERS = 0.4, 0.5  # of the duration

_Path = tuple[NDArray[np.float64], NDArray[np.float64]]


def _bounce(x: float, speed_px_s: float, start_us: float, end_us: float, walls: tuple[float, float]) -> _Path:
    """Times and positions of turns, between two walls at constant speed; a start outside a wall adds the way in as a leg."""
    per_us = speed_px_s * 1e-6
    times, places = [start_us], [x]
    while times[-1] < end_us:
        wall = walls[1] if per_us > 0 else walls[0]
        arrival = times[-1] + (wall - places[-1]) / per_us
        stop = min(arrival, end_us)
        if stop > times[-1]:
            places.append(wall if stop == arrival else places[-1] + per_us * (stop - times[-1]))
            times.append(stop)
        per_us = -per_us
    return np.array(times), np.array(places)


def _with_pause(path: _Path, start_us: float, end_us: float) -> _Path:
    """The same path, interrupted from `start_us` to `end_us`."""
    times, places = path
    before = times < start_us
    stop = float(np.interp(start_us, times, places))
    return (
        np.concatenate((times[before], [start_us, end_us], times[~before & (times > start_us)] + (end_us - start_us))),
        np.concatenate((places[before], [stop, stop], places[~before & (times > start_us)])),
    )


def cast(sensor: tuple[int, int], duration_us: int, speeds_px_s: tuple[float, ...], side_px: float) -> tuple[Box, ...]:
    """The boxes for a sensor of (width, height) pixels, with one speed per lane, squares of `side_px` pixels."""
    width, height = sensor
    lane = height / LANES
    walls = (side_px / 2 - 0.5, width - 0.5 - side_px / 2)
    outside = (-0.5 - side_px / 2, width - 0.5 + side_px / 2)
    middle = (width - 1) / 2
    end = float(duration_us)

    def box(row: int, path: _Path, brighter: bool, drift_px: float = 0.0) -> Box:
        times, x = path
        y = (row + 0.5) * lane - 0.5 + drift_px * (times / end - 0.5)
        return Box(side_px, side_px, brighter, times, x, y)

    def pair(row: int) -> list[Box]:
        # Far enough apart to meet at half time, or as far as the walls allow.
        apart = min(walls[1] - middle, speeds_px_s[row] * end * 0.5e-6)
        return [
            box(row, _bounce(middle - apart, speeds_px_s[row], 0.0, end, walls), True),
            box(row, _bounce(middle + apart, -speeds_px_s[row], 0.0, end, walls), False),
        ]

    stop_us, go_us = (share * end for share in _STOP)
    stopping = _with_pause(_bounce(walls[0], speeds_px_s[2], 0.0, end - (go_us - stop_us), walls), stop_us, go_us)
    # The way out, computed backwards from the time when the box has left.
    backwards, way_out = _bounce(outside[1], -speeds_px_s[5], 0.0, _LEAVES * end, walls)
    leaving = (_LEAVES * end - backwards)[::-1], way_out[::-1]
    return (
        box(0, _bounce(walls[0], speeds_px_s[0], 0.0, end, walls), True, _DRIFT * lane),
        *pair(1),
        box(2, stopping, True),
        box(3, _bounce(middle, speeds_px_s[3], 0.0, end, walls), False, _DRIFT * lane),
        *pair(4),
        box(5, leaving, True),
        box(5, _bounce(outside[0], speeds_px_s[5], _ENTERS * end, end, walls), False),
    )
