# SPDX-License-Identifier: Apache-2.0
"""A synthetic event stream of any length: discs that move, cross and bounce, one event a microsecond."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events
from evcot.trackers.config import RunConfig
from evcot.trackers.presets import fit, for_sensor

__all__ = ["HEIGHT", "SLOTS", "WIDTH", "config", "joined", "runs"]

WIDTH, HEIGHT = 346, 260
SLOTS = 8

_RADIUS_PX = 10.0
_SPEED_PX_S = 150.0
_NOISE = 0.05  # share of events that belong to no disc


def config(slots: int = SLOTS) -> RunConfig:
    """The preset for the stream's sensor, with this many slots."""
    return fit(for_sensor(WIDTH), WIDTH, HEIGHT, slots)


def runs(events: int, size: int, discs: int = SLOTS, seed: int = 1) -> Iterator[Events]:
    """The stream's first `events` events, in runs of `size`, each made when it is asked for."""
    for begin in range(0, events, size):
        yield _run(begin, min(size, events - begin), discs, seed)


def joined(events: int, discs: int = SLOTS, seed: int = 1) -> Events:
    """The same in one piece."""
    parts = list(runs(events, 1 << 16, discs, seed))
    return Events(*(np.concatenate([getattr(part, name) for part in parts]) for name in ("t_us", "x", "y", "p")))


def _run(begin: int, n: int, discs: int, seed: int) -> Events:
    paths = np.random.default_rng(seed)  # the same discs in every run
    heading = paths.uniform(0, 2 * np.pi, discs)
    start_x, start_y = paths.uniform(0, WIDTH, discs), paths.uniform(0, HEIGHT, discs)

    rng = np.random.default_rng([seed, begin])
    t_us = np.sort(rng.integers(begin, begin + n, n))
    disc = rng.integers(0, discs, n)
    angle = rng.uniform(0, 2 * np.pi, n)
    way_px = _SPEED_PX_S * 1e-6 * t_us
    x = _bounce(start_x[disc] + way_px * np.cos(heading[disc]), WIDTH) + _RADIUS_PX * np.cos(angle)
    y = _bounce(start_y[disc] + way_px * np.sin(heading[disc]), HEIGHT) + _RADIUS_PX * np.sin(angle)
    noise = rng.random(n) < _NOISE
    x[noise] = rng.uniform(0, WIDTH - 1, np.count_nonzero(noise))
    y[noise] = rng.uniform(0, HEIGHT - 1, np.count_nonzero(noise))
    return Events(t_us, _pixel(x, WIDTH), _pixel(y, HEIGHT), rng.integers(0, 2, n, dtype=np.uint8))


def _bounce(position: NDArray[np.float64], size: int) -> NDArray[np.float64]:
    """Reflect a straight path at both walls, so that a whole disc stays inside."""
    room = size - 1 - 2 * _RADIUS_PX
    folded: NDArray[np.float64] = _RADIUS_PX + room - np.abs(position % (2 * room) - room)
    return folded


def _pixel(position: NDArray[np.float64], size: int) -> NDArray[np.uint16]:
    return np.clip(np.rint(position), 0, size - 1).astype(np.uint16)
