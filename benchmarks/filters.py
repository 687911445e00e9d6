# SPDX-License-Identifier: Apache-2.0
"""Event rates of the filters on one thread, compared with those of eventcv and dv-processing if installed.

All get the same events in the form that each likes best, made beforehand, and a window of 2 ms; ours give a mask, theirs a
stream of the events that stay. A fresh filter in every turn.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import streams
from evcot.events import Events
from evcot.filters.chain import FilterChain
from evcot.filters.config import FilterConfig
from evcot.filters.contract import Filter
from evcot.ticks import TickedEvents
from measure import Clock, Goal, Result, Skip, Timing, take_turns, timed

__all__ = ["measure"]

_WINDOW_US = 2_000
_SILENCE_US = 200
_HOT = (100, 100)
_RUN_EVENTS = 1 << 16

_CONFIG = FilterConfig(
    region=(0, 0, streams.WIDTH - 1, streams.HEIGHT - 1),
    hot_pixels=(_HOT,),
    refractory_us=_SILENCE_US,
    activity_us=_WINDOW_US,
    recent_us=_WINDOW_US,
    decay_tau_us=float(_WINDOW_US),
)

# What is held against what: our row, theirs, and whether being faster is a goal.
_RIVALS = {
    "filter_activity": ("eventcv_activity", "dv_activity"),
    "filter_refractory": ("eventcv_refractory",),
    "filter_mask": ("dv_mask",),
    "filter_decay": ("dv_fast_decay",),
}


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """filter_* for each filter and the chain, then filter_*_vs_* for each rival at hand."""
    events = streams.joined(500_000 if quick else 2_000_000)
    kept: dict[str, int] = {}
    runs = _ours(events, kept)
    missing = []
    for name, theirs in (("eventcv", _eventcv), ("dv_processing", _dv)):
        try:
            runs |= theirs(importlib.import_module(name), events, kept)
        except ImportError:
            missing.append(name)

    turns = take_turns(runs, 3 if quick else 9)
    rates = {name: len(events) / turns.seconds(name, Clock.CPU) / 1e6 for name in runs}
    shares = {name: f"keeps {kept[name] / len(events):.1%}; CPU time" for name in runs}
    for name in (name for name in runs if name.startswith("filter_")):
        yield Result(name, rates[name], "M events/s", how=shares[name])
    for ours, rivals in _RIVALS.items():
        for rival in (rival for rival in rivals if rival in runs):
            yield Result(
                f"{ours}_vs_{rival.partition('_')[0]}", rates[ours], "M events/s", rates[rival], rival,
                turns.speed_ratio(ours, rival, Clock.CPU), Goal(1), shares[rival],
            )  # fmt: skip
    if missing:
        raise Skip(f"the rows against {' and '.join(missing)}: not installed")


def _ours(events: Events, kept: dict[str, int]) -> dict[str, Callable[[], Timing]]:
    ticked = TickedEvents.of(events)
    registers, shape = _CONFIG.registers(1), _CONFIG.shape(streams.WIDTH, streams.HEIGHT)
    parts = [slice(begin, begin + _RUN_EVENTS) for begin in range(0, len(events), _RUN_EVENTS)]

    def run(name: str, enable: int) -> Timing:
        chain = FilterChain(replace(registers, enable=enable), shape)
        keep: list[NDArray[np.bool_]] = []
        work = timed(lambda: keep.extend(chain.feed(ticked[part]) for part in parts))
        kept[name] = sum(int(np.count_nonzero(part)) for part in keep)
        return work

    enables = {f"filter_{which.name.lower()}": 1 << which for which in Filter} | {"filter_chain": registers.enable}
    return {name: lambda name=name, enable=enable: run(name, enable) for name, enable in enables.items()}  # type: ignore[misc]


def _eventcv(eventcv: Any, events: Events, kept: dict[str, int]) -> dict[str, Callable[[], Timing]]:
    columns = (events.x, events.y, events.t_us - events.t_us[0], events.p)
    stream = eventcv.from_numpy(
        np.stack(columns, axis=1, dtype=np.int64, casting="unsafe"), sensor_size=(streams.WIDTH, streams.HEIGHT), time_unit="us"
    )

    def run(name: str, work: Callable[[], Any]) -> Timing:
        return timed(lambda: kept.update({name: len(work())}))

    return {
        "eventcv_activity": lambda: run("eventcv_activity", lambda: stream.background_activity_filter(_WINDOW_US)),
        "eventcv_refractory": lambda: run("eventcv_refractory", lambda: stream.refractory_filter(_SILENCE_US)),
    }


def _dv(dv: Any, events: Events, kept: dict[str, int]) -> dict[str, Callable[[], Timing]]:
    store = dv.EventStore()
    for event in zip(*(column.tolist() for column in (events.t_us, events.x, events.y, events.p)), strict=True):
        store.push_back(*event)  # no other way in
    size = streams.WIDTH, streams.HEIGHT
    quiet = np.ones((streams.HEIGHT, streams.WIDTH), np.uint8)
    quiet[_HOT[::-1]] = 0
    window = timedelta(microseconds=_WINDOW_US)
    makes: dict[str, Callable[[], Any]] = {
        "dv_activity": lambda: dv.noise.BackgroundActivityNoiseFilter(size, window),
        "dv_fast_decay": lambda: dv.noise.FastDecayNoiseFilter(size, window * float(np.log(2))),
        "dv_mask": lambda: dv.EventMaskFilter(quiet),
    }

    def run(name: str, stage: Any) -> Timing:
        def work() -> None:
            stage.accept(store)
            kept[name] = stage.generateEvents().size()

        return timed(work)

    return {name: lambda name=name, make=make: run(name, make()) for name, make in makes.items()}  # type: ignore[misc]
