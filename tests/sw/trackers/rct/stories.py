# SPDX-License-Identifier: Apache-2.0
"""Streams with known truth, and helpers to run the tracker on them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events, Recording
from evcot.trackers.rct.config import RctConfig
from evcot.trackers.rct.tracker import RctTracker, track
from evcot.tracks.log import Kind

WIDTH, HEIGHT = 1000, 1000

Rows = Sequence[tuple[int, int, int]]


def events_of(rows: Rows, polarities: Sequence[int] | None = None) -> Events:
    """Events from (t_us, x, y) rows, ON unless said otherwise."""
    t_us, x, y = zip(*rows, strict=True) if rows else ((), (), ())
    p = np.ones(len(rows), np.uint8) if polarities is None else np.array(polarities, np.uint8)
    return Events(np.array(t_us, np.int64), np.array(x, np.uint16), np.array(y, np.uint16), p)


def still(x: int, y: int, n: int = 10, begin_us: int = 0, step_us: int = 1) -> list[tuple[int, int, int]]:
    """The same pixel n times."""
    return [(begin_us + i * step_us, x, y) for i in range(n)]


def object_at(
    start: tuple[float, float], velocity: tuple[float, float] = (0.0, 0.0), half: tuple[float, float] = (8.0, 8.0),
    us: tuple[int, int] = (0, 1_000_000), rate_hz: float = 20_000.0, seed: int = 1, hollow: bool = False,
) -> Events:  # fmt: skip
    """A box that is evenly full of events, or only its left and right edge, on a straight way."""
    rng = np.random.default_rng(seed)
    n = int(rate_hz * 1e-6 * (us[1] - us[0]))
    t_us = np.sort(rng.integers(us[0], us[1], n))
    u = rng.uniform(-1, 1, n)
    if hollow:
        u = np.sign(u)
    x = start[0] + velocity[0] * 1e-6 * t_us + half[0] * u
    y = start[1] + velocity[1] * 1e-6 * t_us + half[1] * rng.uniform(-1, 1, n)
    return Events(t_us, np.rint(x).astype(np.uint16), np.rint(y).astype(np.uint16), rng.integers(0, 2, n, dtype=np.uint8))


def together(*parts: Events) -> Events:
    """Several streams as one, in time order."""
    t_us, x, y, p = (np.concatenate([getattr(part, name) for part in parts]) for name in ("t_us", "x", "y", "p"))
    order = np.argsort(t_us, kind="stable")
    return Events(t_us[order], x[order], y[order], p[order])


def tracked(events: Events, config: RctConfig) -> tuple[NDArray[np.void], NDArray[np.int16], NDArray[np.void]]:
    """Records, owners, and the clusters that are left."""
    log = track(Recording(events, WIDTH, HEIGHT), config)
    tracker = RctTracker(config, WIDTH, HEIGHT)
    tracker.feed(events)
    tracker.finish()
    return log.records, log.owner, tracker.clusters()


def of_kind(records: NDArray[np.void], kind: Kind) -> NDArray[np.void]:
    """The records of one kind."""
    chosen: NDArray[np.void] = records[records["kind"] == kind]
    return chosen


def kinds(records: NDArray[np.void]) -> list[Kind]:
    """Which kinds, in order."""
    return [Kind(kind) for kind in records["kind"]]
