# SPDX-License-Identifier: Apache-2.0
"""Event rate of the Rectangular Cluster Tracker, compared with its upper bounds and with other libraries' trackers.

All see the same discs. The others work on windows of 10 ms: eventcv follows connected components from image to image,
dv-processing's mean shift moves its tracks over a time surface.

Run as a program with a number of events, it is the child process: it tracks them and prints its peak in MB.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit

import streams
from evcot.events import Events
from evcot.trackers.rct.config import PRESETS, RctConfig
from evcot.trackers.rct.tracker import RctTracker
from measure import Clock, Goal, Result, Skip, Timing, take_turns, timed
from memory import child_peak_mb, own_peak_mb

__all__ = ["measure"]

_DISCS = 4
_WINDOW_US = 10_000
_PACKET_US = 1_000
_GROWTH = 1.05
# Everything on that costs time per event or per packet.
_FULL = replace(PRESETS["discs"], dynamic_size=True, surround=1.3, vanishing_y_px=-1e4, reference_y_px=130.0)


def measure(folder: Path, quick: bool) -> Iterator[Result]:
    """rct_*."""
    events = streams.joined(500_000 if quick else 2_000_000, discs=_DISCS)
    runs = _ours(events)
    missing = []
    for name, theirs in (("eventcv", _eventcv), ("dv_processing", _dv)):
        try:
            runs |= theirs(importlib.import_module(name), events)
        except ImportError:
            missing.append(name)
    turns = take_turns(runs, 3 if quick else 9)
    rates = {name: len(events) / turns.seconds(name, Clock.CPU) / 1e6 for name in runs}
    for name, goal in (("rct_plain_4", 80.0), ("rct_plain_32", 50.0)):
        yield Result(name, rates[name], "M events/s", goal, "goal", goal=Goal(1), how="clusters at most; CPU time")
    for slots in (4, 32):
        full, plain = f"rct_full_{slots}", f"rct_plain_{slots}"
        ratio = turns.speed_ratio(full, plain, Clock.CPU)
        yield Result(full, rates[full], "M events/s", rates[plain], plain, ratio, Goal(0.5), "all options; CPU time")
    for name, what in (
        ("rct_limit_memory", "reads t, x, y, writes owner"),
        ("rct_limit_chain", "and mixes one cluster's centre"),
    ):
        ratio = turns.speed_ratio("rct_plain_4", name, Clock.CPU)
        yield Result(name, rates[name], "M events/s", rates["rct_plain_4"], "rct_plain_4", 1 / ratio, how=what)
    for rival in (name for name in runs if name.startswith(("eventcv", "dv_"))):
        ratio = turns.speed_ratio("rct_plain_4", rival, Clock.CPU)
        yield Result(f"rct_vs_{rival}", rates["rct_plain_4"], "M events/s", rates[rival], rival, ratio, Goal(1))
    yield from _latencies(events[:100_000])
    yield from _memory(quick)
    if missing:
        raise Skip(f"the rows against {' and '.join(missing)}: not installed")


def _config(slots: int, full: bool) -> RctConfig:
    return replace(_FULL if full else streams.config().rct, max_clusters=slots)


def _ours(events: Events) -> dict[str, Callable[[], Timing]]:
    def track(slots: int, full: bool) -> Timing:
        tracker = RctTracker(_config(slots, full), streams.WIDTH, streams.HEIGHT)
        return timed(lambda: (tracker.feed(events), tracker.finish()))

    owner, centre = np.empty(len(events), np.int16), np.zeros(2)
    columns = events.t_us, events.x, events.y, owner
    return {
        "rct_plain_4": lambda: track(4, False),
        "rct_plain_32": lambda: track(32, False),
        "rct_full_4": lambda: track(4, True),
        "rct_full_32": lambda: track(32, True),
        "rct_limit_memory": lambda: timed(lambda: _touch(*columns)),
        "rct_limit_chain": lambda: timed(lambda: _mix(*columns, centre)),
    }


@njit(cache=True, nogil=True)
def _touch(ts, xs, ys, owner):  # type: ignore[no-untyped-def]
    for e in range(len(ts)):
        owner[e] = np.int16(ts[e] + xs[e] + ys[e])


@njit(cache=True, nogil=True)
def _mix(ts, xs, ys, owner, centre):  # type: ignore[no-untyped-def]
    for e in range(len(ts)):
        centre[0] = 0.99 * centre[0] + 0.01 * xs[e]
        centre[1] = 0.99 * centre[1] + 0.01 * ys[e]
        owner[e] = np.int16(ts[e])


def _eventcv(eventcv: Any, events: Events) -> dict[str, Callable[[], Timing]]:
    columns = (events.x, events.y, events.t_us - events.t_us[0], events.p)
    stream = eventcv.from_numpy(
        np.stack(columns, axis=1, dtype=np.int64, casting="unsafe"), sensor_size=(streams.WIDTH, streams.HEIGHT), time_unit="us"
    )
    begins_us = range(0, int(columns[2][-1]), _WINDOW_US)

    def run() -> Timing:
        tracker = eventcv.Tracker(min_area=20)
        return timed(lambda: [tracker.update(stream.time_window(begin, begin + _WINDOW_US).count()) for begin in begins_us])

    return {"eventcv_components": run}


def _dv(dv: Any, events: Events) -> dict[str, Callable[[], Timing]]:
    stores = []
    for part in _cut(events, _WINDOW_US):
        stores.append(dv.EventStore())
        for event in zip(*(column.tolist() for column in (part.t_us, part.x, part.y, part.p)), strict=True):
            stores[-1].push_back(*event)  # no other way in

    def run() -> Timing:
        radius_px = int(streams.config().rct.radius_px)
        tracker = dv.features.MeanShiftTracker((streams.WIDTH, streams.HEIGHT), radius_px, timedelta(microseconds=_WINDOW_US))
        tracker.setMaxTracks(_DISCS)
        return timed(lambda: [(tracker.accept(store), tracker.runTracking()) for store in stores])

    return {"dv_mean_shift": run}


def _cut(events: Events, step_us: int) -> list[Events]:
    bounds = np.searchsorted(events.t_us, np.arange(events.t_us[0], events.t_us[-1] + step_us, step_us))
    return [events[a:b] for a, b in zip(bounds, [*bounds[1:], len(events)], strict=True) if b > a]


def _latencies(events: Events) -> Iterator[Result]:
    """What a caller in Python waits for."""
    for name, parts in (
        ("rct_latency_event", [events[i : i + 1] for i in range(0, len(events), 10)]),
        ("rct_latency_packet", _cut(events, _PACKET_US)),
    ):

        def work(parts: list[Events] = parts) -> Timing:
            tracker = RctTracker(_config(4, False))
            return timed(lambda: [tracker.feed(part) for part in parts])

        turns = take_turns({name: work}, 5)
        size = float(np.mean([len(part) for part in parts]))
        yield Result(
            name, turns.seconds(name, Clock.CPU) / len(parts) * 1e6, "us", how=f"a call of feed with {size:.0f} events"
        )


def _memory(quick: bool) -> Iterator[Result]:
    long, short = (20_000_000, 2_000_000) if quick else (1_000_000_000, 10_000_000)
    long_mb, short_mb = (child_peak_mb(__file__, events) for events in (long, short))
    yield Result(
        "rct_peak_memory", long_mb, "MB", short_mb, f"{short:,} events", goal=Goal(_GROWTH, at_most=True),
        how=f"resident set over {long:,} events",
    )  # fmt: skip


def _main(n: int) -> None:
    """The same million events again and again, later each time."""
    run = streams.joined(1_000_000, discs=_DISCS)
    tracker = RctTracker(_config(32, False))
    for begin in range(0, n, len(run)):
        tracker.feed(Events(run.t_us + begin, run.x, run.y, run.p))
    tracker.finish()
    print(own_peak_mb())


if __name__ == "__main__":
    _main(int(sys.argv[1]))
