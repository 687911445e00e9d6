# SPDX-License-Identifier: Apache-2.0
"""Event rates of the golden models and the software trackers, on one thread: the synthetic stream of crossing discs; of the
trackers that need no settings, also real recordings."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

import streams
from evcot.events import Events
from evcot.hardware.config import with_module
from evcot.hardware.golden import golden_model
from evcot.hardware.modules import Module
from evcot.recordings.files import read_recording
from evcot.ticks import TickedEvents
from evcot.trackers.adaptive.config import AdaptiveConfig
from evcot.trackers.adaptive.tracker import AdaptiveTracker
from evcot.trackers.engines import ENGINES
from evcot.trackers.presets import MOTION
from evcot.trackers.rct.tracker import RctTracker
from evcot.tracks.tracking import Tracker
from evcot_cosim.lockstep.lockstep import chunks
from measure import Clock, Goal, Result, Skip, Timing, take_turns, timed
from shared import SHARED

__all__ = ["measure"]

Trackers = dict[str, Callable[[], Tracker]]

_GOAL_M = 20.0
_GOALS_M_EVENTS_S = {4: 50.0, 32: 20.0}
_RECORDINGS = {"traffic": "traffic_outbound.aedat4", "pendulum": "pendulum_dvs128.aedat", "hand": "hand_dvs128.aedat4"}


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """model_rate, model_rate_chain, rct_rate; for 4 and 32 discs: adaptive_<discs> and default_<discs>, the default tracker, in
    M events/s, and default_adaptive_<discs>, the rate of the default divided by that of `adaptive`. For each recording that is
    there: default_<name>, ns per event.
    """
    yield from _with_settings(quick)
    yield from _without_settings(quick)


def _with_settings(quick: bool) -> Iterator[Result]:
    config = streams.config()
    events = streams.joined(500_000 if quick else 2_000_000)
    ticked = TickedEvents.of(events, config.hardware.tick_us)
    live: list[int] = []

    def model(module: Module) -> Timing:
        tracker = golden_model(with_module(config.hardware, module))
        parts = [slice(begin, begin + (1 << 16)) for begin in range(0, len(events), 1 << 16)]
        return timed(lambda: [tracker.feed(ticked[part]) for part in parts])

    def software() -> Timing:
        tracker = RctTracker(replace(config.rct, max_clusters=streams.SLOTS))

        def work() -> None:
            for run in chunks(events):
                tracker.feed(run)
                live.append(int(np.count_nonzero(tracker.clusters()["track_id"] >= 0)))

        return timed(work)

    turns = take_turns(
        {
            "model_rate": lambda: model("cot_array"),
            "model_rate_chain": lambda: model("cot_chain"),
            "rct_rate": software,
        },
        3 if quick else 9,
    )
    notes = {
        "model_rate": f"{streams.SLOTS} slots",
        "model_rate_chain": f"{streams.SLOTS} trackers",
        "rct_rate": f"{np.mean(live):.1f} visible clusters live",
    }
    for name, note in notes.items():
        rate = len(events) / turns.seconds(name, Clock.CPU) / 1e6
        yield Result(name, rate, "M events/s", _GOAL_M, "goal", goal=Goal(1), how=f"{note}; CPU time")


def _without_settings(quick: bool) -> Iterator[Result]:
    for discs, goal in _GOALS_M_EVENTS_S.items():
        events = streams.joined(300_000 if quick else 2_000_000, discs=discs)
        trackers = _trackers(streams.WIDTH, streams.HEIGHT)
        seconds = _seconds(trackers, events, quick)
        yield Result(f"adaptive_{discs}", len(events) / seconds["adaptive"] / 1e6, "M events/s", goal, "goal", goal=Goal(1))
        rate = len(events) / seconds["default"] / 1e6
        yield Result(f"default_{discs}", rate, "M events/s", goal, "goal", goal=Goal(1))
        ratio = seconds["adaptive"] / seconds["default"]
        yield Result(f"default_adaptive_{discs}", ratio, "times", 1.0, "adaptive")
    there = {name: SHARED / file for name, file in _RECORDINGS.items() if (SHARED / file).is_file()}
    for name, path in there.items():
        recording = read_recording(path)
        seconds = _seconds(_trackers(recording.width, recording.height), recording.events, quick)
        default, adaptive = (1e9 * seconds[one] / len(recording.events) for one in ("default", "adaptive"))
        yield Result(f"default_{name}", default, "ns/event", adaptive, "adaptive")
    if missing := [file for name, file in _RECORDINGS.items() if name not in there]:
        raise Skip(f"no {', '.join(missing)} in {SHARED}: recordings are not part of the project")


def _trackers(width: int, height: int) -> Trackers:
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
