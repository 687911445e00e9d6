# SPDX-License-Identifier: Apache-2.0
"""Event rates of the golden model and the software tracker, on one thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

import streams
from evcot.hardware.config import with_module
from evcot.hardware.golden import golden_model
from evcot.hardware.modules import Module
from evcot.ticks import TickedEvents
from evcot.trackers.rct.tracker import RctTracker
from evcot_cosim.lockstep.lockstep import chunks
from measure import Clock, Goal, Result, Timing, take_turns, timed

__all__ = ["measure"]

_GOAL_M = 20.0


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """model_rate, model_rate_chain, rct_rate."""
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
