# SPDX-License-Identifier: Apache-2.0
"""Event rate of the Kalman tracker on one thread, on the synthetic stream of crossing discs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import streams
from evcot.trackers.kalman.config import KalmanConfig
from evcot.trackers.kalman.presets import PRESETS
from evcot.trackers.kalman.tracker import KalmanTracker
from measure import Clock, Goal, Result, Timing, take_turns, timed

__all__ = ["measure"]

_GOAL_M_EVENTS_S = 20.0


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """kalman_<preset>_<discs> in M events/s, for 4 and 32 discs."""
    for discs in (4, 32):
        events = streams.joined(300_000 if quick else 2_000_000, discs=discs)

        def run(config: KalmanConfig, events: streams.Events = events) -> Timing:
            tracker = KalmanTracker(replace(config, max_objects=64), streams.WIDTH, streams.HEIGHT)
            return timed(lambda: tracker.feed(events))

        runs = {name: lambda config=config: run(config) for name, config in PRESETS.items()}  # type: ignore[misc]
        turns = take_turns(runs, 3 if quick else 7)
        for name in runs:
            rate = len(events) / turns.seconds(name, Clock.CPU) / 1e6
            yield Result(f"kalman_{name}_{discs}", rate, "M events/s", _GOAL_M_EVENTS_S, "goal", goal=Goal(1))
