# SPDX-License-Identifier: Apache-2.0
"""Event rates of the trackers that need no settings, on one thread, on the synthetic stream of crossing discs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import streams
from evcot.trackers.auto.config import AutoConfig
from evcot.trackers.auto.tracker import AutoTracker
from evcot.trackers.engines import ENGINES
from evcot.trackers.kalman.presets import PRESETS
from evcot.trackers.kalman.tracker import KalmanTracker
from evcot.trackers.presets import FOLLOWING
from evcot.tracks.tracking import Tracker
from measure import Clock, Goal, Result, Timing, take_turns, timed

__all__ = ["measure"]

Trackers = dict[str, Callable[[], Tracker]]

_GOALS_M_EVENTS_S = {4: 50.0, 32: 20.0}


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """For 4 and 32 discs: auto_<discs> in M events/s, and auto_kalman_<discs>, its rate by that of the
    Kalman tracker; following_<discs> and following_auto_<discs>, the same of the default tracker by `auto`.
    """
    for discs, goal in _GOALS_M_EVENTS_S.items():
        events = streams.joined(300_000 if quick else 2_000_000, discs=discs)
        trackers: Trackers = {
            "auto": lambda: AutoTracker(AutoConfig(), streams.WIDTH, streams.HEIGHT),
            "following": lambda: ENGINES["cot"].start(FOLLOWING, FOLLOWING.filters, (streams.WIDTH, streams.HEIGHT)),
            "kalman": lambda: KalmanTracker(PRESETS["discs"], streams.WIDTH, streams.HEIGHT),
        }

        def run(name: str, trackers: Trackers = trackers, events: streams.Events = events) -> Timing:
            tracker = trackers[name]()
            return timed(lambda: tracker.feed(events))

        runs = {name: lambda name=name: run(name) for name in trackers}  # type: ignore[misc]
        turns = take_turns(runs, 3 if quick else 7)
        seconds = {name: turns.seconds(name, Clock.CPU) for name in runs}
        yield Result(f"auto_{discs}", len(events) / seconds["auto"] / 1e6, "M events/s", goal, "goal", goal=Goal(1))
        yield Result(f"auto_kalman_{discs}", seconds["kalman"] / seconds["auto"], "times", 1.0, "kalman, discs")
        rate = len(events) / seconds["following"] / 1e6
        yield Result(f"following_{discs}", rate, "M events/s", goal, "goal", goal=Goal(1))
        yield Result(f"following_auto_{discs}", seconds["auto"] / seconds["following"], "times", 1.0, "auto")
