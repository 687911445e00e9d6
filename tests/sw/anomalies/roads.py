# SPDX-License-Identifier: Apache-2.0
"""Track logs of simple roads: cars that drive up the picture in lanes, slower and slower as they get far."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

from evcot.tracks.log import TRACK, Kind, TrackLog

SENSOR = (346, 260)
STEP_US = 10_000
LANES_PX = (100.0, 170.0, 240.0)

Path = Callable[[NDArray[np.float64]], tuple[NDArray[np.float64], NDArray[np.float64]]]


def track(
    track_id: int,
    begin_us: int,
    lasts_us: int,
    path: Path,
    jitter_px: float = 0.0,
    ends: Kind | None = Kind.LOST,
    seed: int = 1,
) -> NDArray[np.void]:
    """One track's records every `STEP_US`; `path` takes seconds since its birth."""
    t_us = np.arange(0, lasts_us, STEP_US)
    records = np.zeros(len(t_us) + (ends is not None), TRACK)
    x, y = path(t_us * 1e-6)
    noise = np.random.default_rng((seed, track_id)).normal(0, jitter_px, (2, len(t_us)))
    records["x"][: len(t_us)], records["y"][: len(t_us)] = x + noise[0], y + noise[1]
    records["t_us"][: len(t_us)] = begin_us + t_us
    records["kind"] = Kind.MOVED
    records["kind"][0] = Kind.BORN
    if ends is not None:
        records[-1] = records[-2]
        records["kind"][-1] = ends
        records["t_us"][-1] += STEP_US
    records["track_id"], records["radius"], records["other_id"] = track_id, 12.0, -1
    records["width"], records["height"] = 24.0, 16.0
    return records


def log(*tracks: NDArray[np.void]) -> TrackLog:
    """All records in time order."""
    records = np.concatenate([np.empty(0, TRACK), *tracks])
    records = records[np.argsort(records["t_us"], kind="stable")]
    records["event_index"] = np.arange(len(records))
    return TrackLog("test", records, np.empty(0, np.int16))


def still(x: float, y: float) -> Path:
    """Stays where it is."""
    return lambda s: (np.full(len(s), x), np.full(len(s), y))


def straight(x: float, y: float, vx: float, vy: float) -> Path:
    """Moves at one velocity, px/s."""
    return lambda s: (x + vx * s, y + vy * s)


def away(lane_px: float, pace: float = 1.0) -> Path:
    """Drives up the picture at pace * y px/s: half as fast where it is half as far from the horizon, y = 0."""
    return lambda s: (np.full(len(s), lane_px), 250.0 * np.exp(-pace * s))


def towards(lane_px: float, pace: float = 1.0) -> Path:
    """The same road the other way."""
    return lambda s: (np.full(len(s), lane_px), 20.0 * np.exp(pace * s))


def traffic(count: int = 40, jitter_px: float = 0.5, first_id: int = 0, begin_us: int = 0) -> Iterable[NDArray[np.void]]:
    """Cars in all lanes, one each 0.8 s, at 0.9 to 1.1 of the usual pace."""
    paces = np.random.default_rng(5).uniform(0.9, 1.1, count)
    for i, pace in enumerate(paces):
        lane = LANES_PX[i % len(LANES_PX)]
        yield track(first_id + i, begin_us + i * 800_000, 2_400_000, away(lane, float(pace)), jitter_px)
