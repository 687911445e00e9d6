# SPDX-License-Identifier: Apache-2.0
"""Event rates of the trackers that need no settings, on one thread: the synthetic stream of crossing discs, real recordings."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import streams
from evcot.events import Events
from evcot.recordings.files import read_recording
from evcot.trackers.adaptive.config import AdaptiveConfig
from evcot.trackers.adaptive.tracker import AdaptiveTracker
from evcot.trackers.engines import ENGINES
from evcot.trackers.presets import MOTION
from evcot.tracks.tracking import Tracker
from measure import Clock, Goal, Result, Skip, Timing, take_turns, timed
from shared import SHARED

__all__ = ["measure"]

Trackers = dict[str, Callable[[], Tracker]]

_RECORDINGS = {"traffic": "traffic_outbound.aedat4", "pendulum": "pendulum_dvs128.aedat", "hand": "hand_dvs128.aedat4"}

_GOALS_M_EVENTS_S = {4: 50.0, 32: 20.0}


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """For 4 and 32 discs: adaptive_<discs> and default_<discs>, the default tracker, in M events/s, and
    default_adaptive_<discs>, the rate of the default divided by that of `adaptive`. For each recording that is there:
    default_<name>, ns per event.
    """
    for discs, goal in _GOALS_M_EVENTS_S.items():
        events = streams.joined(300_000 if quick else 2_000_000, discs=discs)
        trackers = _without_settings(streams.WIDTH, streams.HEIGHT)
        seconds = _seconds(trackers, events, quick)
        yield Result(f"adaptive_{discs}", len(events) / seconds["adaptive"] / 1e6, "M events/s", goal, "goal", goal=Goal(1))
        rate = len(events) / seconds["default"] / 1e6
        yield Result(f"default_{discs}", rate, "M events/s", goal, "goal", goal=Goal(1))
        ratio = seconds["adaptive"] / seconds["default"]
        yield Result(f"default_adaptive_{discs}", ratio, "times", 1.0, "adaptive")
    there = {name: SHARED / file for name, file in _RECORDINGS.items() if (SHARED / file).is_file()}
    for name, path in there.items():
        recording = read_recording(path)
        seconds = _seconds(_without_settings(recording.width, recording.height), recording.events, quick)
        default, adaptive = (1e9 * seconds[one] / len(recording.events) for one in ("default", "adaptive"))
        yield Result(f"default_{name}", default, "ns/event", adaptive, "adaptive")
    if missing := [file for name, file in _RECORDINGS.items() if name not in there]:
        raise Skip(f"no {', '.join(missing)} in {SHARED}: recordings are not part of the project")


def _without_settings(width: int, height: int) -> Trackers:
    """Both, for a sensor of that size."""
    return {
        "adaptive": lambda: AdaptiveTracker(AdaptiveConfig(), width, height),
        "default": lambda: ENGINES["cot_motion"].start(MOTION, MOTION.filters, (width, height)),
    }


def _seconds(trackers: Trackers, events: Events, quick: bool) -> dict[str, float]:
    """CPU time of each over all events."""

    def run(name: str) -> Timing:
        tracker = trackers[name]()
        return timed(lambda: tracker.feed(events))

    runs = {name: lambda name=name: run(name) for name in trackers}  # type: ignore[misc]
    turns = take_turns(runs, 3 if quick else 7)
    return {name: turns.seconds(name, Clock.CPU) for name in runs}
