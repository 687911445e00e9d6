# SPDX-License-Identifier: Apache-2.0
"""The box experiment: bright and dark boxes on known paths, seen by an ideal event camera with noise.

Each of six lanes tests one aspect of a tracker. From the top: a box in continuous motion (with a downward drift: a slanted
path), two that meet and cross, one that stops and restarts, one in continuous motion, two that meet and cross, and one that
leaves before another enters. With both speeds the upper three lanes are slow and the lower three fast.

Boxes are transparent: where two overlap, their changes of log intensity add up, so each keeps its own contour. Boxes at rest
cause no events.

A pixel emits an event when its log intensity has moved by a threshold K: dI = pK. A box changes log intensity by `steps`
thresholds over an edge one pixel wide: at signed depth d inside the contour (the least distance to its four sides) the change
is `steps * K * clip(d + 1/2, 0, 1)`. So the pixel crosses the level k + 1/2 of `steps` where d = (k + 1/2) / steps - 1/2: once
when the box shrunk by d takes it in and once when it lets it go, both linear in time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit, step
from ..errors import ConfigError
from ..events import Recording
from ..ranges import check_ranges, setting
from ._order import KEY_T_SHIFT, events_of
from .truth import Box, Scene, Truth, sample

__all__ = ["BoxExperiment", "Scene", "Speed", "simulate"]


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


Speed = Literal["slow", "fast", "both"]

_LANE_SHARE = 0.28


@dataclass(frozen=True)
class BoxExperiment:
    """The box experiment's settings. `speed` selects the paper's slow or fast situation,
    or, with "both", slow boxes in the upper half and fast ones in the lower.

    Raises:
        ConfigError: a value outside its range, or boxes higher than their lanes.
    """

    width: int = setting(346, 64, 4096, "pixels of the sensor across")
    height: int = setting(260, 64, 4096, "pixels of the sensor down")
    duration_us: int = setting(2_500_000, 1_000, 1_000_000_000, "length of the scene")
    speed: Speed = "both"
    slow_px_s: float = setting(80.0, 1.0, 10_000.0, "speed of a slow box")
    fast_px_s: float = setting(400.0, 1.0, 10_000.0, "speed of a fast box")
    side_px: float = setting(0.0, 0.0, 512.0, "side of a box; 0 for 0.28 of a lane")
    contrast_steps: int = setting(4, 1, 32, "thresholds between background and box: events per pixel and edge")
    jitter_us: int = setting(200, 0, 10_000, "longest delay of an event of an edge")
    noise_hz_per_px: float = setting(0.1, 0.0, 1_000.0, "background events per pixel and second")
    flicker_hz_per_px: float = setting(
        20.0, 0.0, 10_000.0, "noise of a moving box's contour: events per pixel of its length and second"
    )
    truth_step_us: int = setting(1_000, 1, 1_000_000, "time between two samples of the truth")
    seed: int = setting(1, 0, 2**63 - 1, "seed of all noise")

    def __post_init__(self) -> None:
        check_ranges("boxes", self)
        if self.speed not in get_args(Speed):
            raise ConfigError(f"boxes.speed = {self.speed!r}: must be one of {', '.join(get_args(Speed))}")
        if self.side_px > self.height / LANES or 0 < self.side_px < 1:
            raise ConfigError(
                f"boxes.side_px = {self.side_px:g}: must be 0, or from 1 to a lane's {self.height / LANES:.1f} pixels"
            )

    @property
    def speeds_px_s(self) -> tuple[float, ...]:
        """Speed of each lane, from the top."""
        slow, fast = (self.slow_px_s,) * (LANES // 2), (self.fast_px_s,) * (LANES // 2)
        return {"slow": slow + slow, "fast": fast + fast, "both": slow + fast}[self.speed]

    @property
    def boxes(self) -> tuple[Box, ...]:
        """The objects on their paths, which do not depend on the seed."""
        side = self.side_px or round(_LANE_SHARE * self.height / LANES)
        return cast((self.width, self.height), self.duration_us, self.speeds_px_s, side)


def simulate(config: BoxExperiment) -> Scene:
    """Events in [0, duration_us) and truth every `truth_step_us`; equal settings give identical results."""
    random = np.random.default_rng(config.seed)
    boxes = config.boxes
    keys = [_noise(config, random)]
    for box in boxes:
        edges = _edges(config, box)
        edges += random.integers(0, config.jitter_us, len(edges), endpoint=True) << KEY_T_SHIFT
        keys += [edges, _flicker(config, box, random)]
    events = events_of(np.concatenate(keys), config.duration_us)
    times_us = np.arange(0, config.duration_us, config.truth_step_us)
    truth = Truth(sample(boxes, times_us, (config.width, config.height)), boxes)
    return Scene(Recording(events, config.width, config.height, f"boxes_{config.speed}"), truth, config.seed)


def _keys(
    t_us: NDArray[np.int64], x: NDArray[np.int64], y: NDArray[np.int64], random: np.random.Generator
) -> NDArray[np.int64]:
    """Events of random polarity."""
    return t_us << KEY_T_SHIFT | x << 17 | y << 1 | random.integers(0, 2, len(t_us))


def _noise(config: BoxExperiment, random: np.random.Generator) -> NDArray[np.int64]:
    """Background events: a Poisson process per pixel."""
    count = random.poisson(config.noise_hz_per_px * config.width * config.height * config.duration_us * 1e-6)
    t_us, x, y = (random.integers(0, high, count) for high in (config.duration_us, config.width, config.height))
    return _keys(t_us, x, y, random)


def _edges(config: BoxExperiment, box: Box) -> NDArray[np.int64]:
    """Events of a moving contour, without noise."""
    # Estimate: two contours sweep the area of the path; with turns, more room may be needed, then repeat.
    swept = abs(np.diff(box.x)).sum() * box.height + abs(np.diff(box.y)).sum() * box.width
    keys = np.empty(int(2 * config.contrast_steps * swept), np.int64)
    needed = _fill(config, box, keys)
    if needed > len(keys):
        keys = np.empty(needed, np.int64)
        _fill(config, box, keys)
    return keys[:needed]


def _fill(config: BoxExperiment, box: Box, keys: NDArray[np.int64]) -> int:
    n = 0
    for leg in range(len(box.t_us) - 1):
        from_us, to_us = box.t_us[leg : leg + 2]
        start = box.x[leg], box.y[leg]
        speed = (box.x[leg + 1] - box.x[leg]) / (to_us - from_us), (box.y[leg + 1] - box.y[leg]) / (to_us - from_us)
        if speed != (0.0, 0.0):
            half = box.width / 2, box.height / 2
            sensor = config.width, config.height
            n = leg_events(keys, n, sensor, half, start, speed, from_us, to_us, int(box.brighter), config.contrast_steps)
    return n


def _flicker(config: BoxExperiment, box: Box, random: np.random.Generator) -> NDArray[np.int64]:
    """Noise along the contour while the box moves, on all four sides."""
    moving = (np.diff(box.x) != 0) | (np.diff(box.y) != 0)
    moving_us = float(np.diff(box.t_us)[moving].sum())
    count = random.poisson(config.flicker_hz_per_px * 2 * (box.width + box.height) * moving_us * 1e-6)
    # Uniform over the moving legs: the clock runs only while the box moves.
    clock = np.concatenate(([0.0], np.cumsum(np.diff(box.t_us) * moving)))
    leg = np.searchsorted(clock, elapsed := random.uniform(0, moving_us, count), side="right") - 1
    t_us = (box.t_us[leg] + elapsed - clock[leg]).astype(np.int64)
    centre_x, centre_y = box.centre(t_us)
    along, side = random.uniform(-0.5, 0.5, count), random.choice((-0.5, 0.5), count)
    vertical = random.uniform(0, box.width + box.height, count) < box.height
    x = np.rint(centre_x + box.width * np.where(vertical, side, along)).astype(np.int64)
    y = np.rint(centre_y + box.height * np.where(vertical, along, side)).astype(np.int64)
    seen = (x >= 0) & (x < config.width) & (y >= 0) & (y < config.height)
    return _keys(t_us[seen], x[seen], y[seen], random)
