# SPDX-License-Identifier: Apache-2.0
"""Motion of a track from a stream of records: positions averaged over steps, and a straight line fitted to the latest.

The compiled part common to learning and rules. Time is divided into steps of `step_us`; a step of a track is closed by the
track's first record in a later step. The line is fitted by least squares, x and y over time, to the fewest latest positions
that span `travel_px`, limited to `window_us`. A position farther from the prediction than the track's window reaches (a merge,
an identity switch) restarts the line.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .._numba_private import step
from .config import RING, AnomalyConfig

__all__ = ["MOTION", "Steps", "add_place", "begin", "close_step", "extent_px", "steps"]

_PLACES_MIN = 5  # minimum number of positions for a fit
_SPAN_MIN = 4  # steps between the first and the last of them

# One track's motion; a part of every row of a table of tracks.
MOTION = np.dtype(
    [
        ("step", "<i8"),  # index of the open step
        ("n", "<i8"),  # records in it
        ("sum_t", "<f8"),  # of their times after the step's begin, us
        ("sum_x", "<f8"),
        ("sum_y", "<f8"),
        ("places", "<i8"),  # in the ring
        ("head", "<i8"),  # index of the next entry
        ("ring_t", "<f8", RING),  # us after the first record of the run
        ("ring_x", "<f8", RING),
        ("ring_y", "<f8", RING),
        ("ring_extent", "<f8", RING),
        # Of the newest closed step:
        ("t", "<f8"),
        ("x", "<f8"),
        ("y", "<f8"),
        ("jumped", "?"),  # whether it is too far from the previous position
        ("was_x", "<f8"),
        ("was_y", "<f8"),
        ("elapsed_us", "<f8"),  # since the previous step; 0 for the first after a jump
        # Of the line, if available: position and velocity in the middle of its window.
        ("known", "?"),
        ("mid_x", "<f8"),
        ("mid_y", "<f8"),
        ("vx", "<f8"),  # px/s
        ("vy", "<f8"),
        ("error", "<f8"),  # standard error of each of the two, px/s
        ("swell", "<f8"),  # largest over smallest extent in that window
    ]
)


class Steps(NamedTuple):
    """`AnomalyConfig` in the form used here."""

    step_us: int
    window_us: float
    travel_px: float


def steps(config: AnomalyConfig) -> Steps:
    """The settings for measuring motion."""
    return Steps(config.step_us, float(config.window_us), float(config.travel_px))


@step
def begin(motion: Any, step: int) -> None:
    """Initialise a track without history."""
    motion.step = step
    motion.n = 0
    motion.sum_t = motion.sum_x = motion.sum_y = 0.0
    motion.places = motion.head = 0
    motion.known = False


@step
def extent_px(record: Any) -> float:
    """Half the longer side of a record's box."""
    return 0.5 * max(record.width, record.height)  # type: ignore[no-any-return]


@step
def add_place(motion: Any, after_us: int, step: int, step_us: int, x: float, y: float) -> None:
    """Add a record to the open step; `after_us`: its time after the first record of the run."""
    motion.step = step
    motion.n += 1
    motion.sum_t += after_us - step * step_us
    motion.sum_x += x
    motion.sum_y += y


@step
def close_step(settings: Steps, motion: Any, reach_px: float, extent_px: float) -> None:
    """Average the open step, which must have a record, to a position, and refit the line.

    Args:
        reach_px: half the tracker's search window: an object that is farther from its prediction has jumped.
        extent_px: half the longer side of its box.
    """
    t = motion.step * settings.step_us + motion.sum_t / motion.n
    x = motion.sum_x / motion.n
    y = motion.sum_y / motion.n
    motion.n = 0
    motion.sum_t = motion.sum_x = motion.sum_y = 0.0
    motion.elapsed_us = 0.0
    motion.jumped = False
    if motion.places > 0:
        elapsed_us = t - motion.t
        ahead_s = 1e-6 * elapsed_us if motion.known else 0.0
        off_px = max(abs(motion.x + motion.vx * ahead_s - x), abs(motion.y + motion.vy * ahead_s - y))
        if off_px > reach_px:
            motion.places = motion.head = 0
            motion.jumped = True
        else:
            motion.elapsed_us = elapsed_us
    motion.was_x = motion.x
    motion.was_y = motion.y
    motion.t = t
    motion.x = x
    motion.y = y
    motion.ring_t[motion.head] = t
    motion.ring_x[motion.head] = x
    motion.ring_y[motion.head] = y
    motion.ring_extent[motion.head] = extent_px
    motion.head = (motion.head + 1) % RING
    motion.places = min(motion.places + 1, RING)
    _fit(settings, motion)


@step
def _fit(settings: Steps, motion: Any) -> None:
    n = 0
    st = sx = sy = stt = stx = sty = sxx = syy = 0.0
    span_us = 0.0
    largest, smallest = 0.0, np.inf
    for back in range(motion.places):
        i = (motion.head - 1 - back) % RING
        dt = 1e-6 * (motion.ring_t[i] - motion.t)
        dx = motion.ring_x[i] - motion.x
        dy = motion.ring_y[i] - motion.y
        if -1e6 * dt > settings.window_us:
            break
        n += 1
        span_us = -1e6 * dt
        largest = max(largest, motion.ring_extent[i])
        smallest = min(smallest, motion.ring_extent[i])
        st += dt
        sx += dx
        sy += dy
        stt += dt * dt
        stx += dt * dx
        sty += dt * dy
        sxx += dx * dx
        syy += dy * dy
        enough = n >= _PLACES_MIN and span_us >= (_SPAN_MIN - 0.5) * settings.step_us
        if enough and dx * dx + dy * dy >= settings.travel_px * settings.travel_px:
            break
    motion.known = n >= _PLACES_MIN and span_us >= (_SPAN_MIN - 0.5) * settings.step_us
    if not motion.known:
        return
    motion.swell = largest / max(smallest, 1.0)
    spread = stt - st * st / n
    motion.vx = (stx - st * sx / n) / spread
    motion.vy = (sty - st * sy / n) / spread
    motion.mid_x = motion.x + sx / n
    motion.mid_y = motion.y + sy / n
    left = sxx - sx * sx / n - motion.vx * (stx - st * sx / n) + syy - sy * sy / n - motion.vy * (sty - st * sy / n)
    motion.error = (max(left, 0.0) / (2 * n - 4) / spread) ** 0.5
