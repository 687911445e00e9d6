# SPDX-License-Identifier: Apache-2.0
"""Random events through hardware and golden model, with all options of motion; registers are rewritten while events flow.

python benchmarks/soak.py                                   # a million events
python benchmarks/soak.py --events 20000000 --jobs 2        # twenty million
python benchmarks/soak.py --events 20000000 --output soak.json  # and seed, shapes and results in a file
python benchmarks/soak.py --seed 3 --run 9 --length 89188   # one run again, of so many events

A run has a shape of 1 to 64 slots; in some shapes, numbers of tracks, events and support wrap. A run draws registers over their
whole legal ranges, stalls, and traffic: outlines of boxes that meet and hide each other, or bursts and noise. In every fourth
run, events of a period all come at one tick. Every second run is of `evcot_top`, with a change of registers every 400 events or
so; the others are of the array alone, which is faster. A run has as many events as take about --seconds, and says how many. The
first difference ends the program with exit code 1.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import NamedTuple

import numpy as np

from evcot.filters.contract import FilterShape
from evcot.hardware.contract import Shape
from evcot.outputs import written_aside
from evcot_cosim.devices.base import HardwareError
from evcot_cosim.devices.device import build_device
from evcot_cosim.devices.top_device import Pace, TopDevice
from evcot_cosim.lockstep.mismatch import MismatchError
from evcot_cosim.lockstep.random_runs import (
    ALONE,
    Rewritten,
    random_motion,
    random_motion_run,
    random_motion_traffic,
    rewritten,
)

_SHAPES = (
    Shape(n_slots=8), Shape(n_slots=1, x_w=7, y_w=7, tc_w=12), Shape(n_slots=2, x_w=5, y_w=9), Shape(n_slots=16),
    Shape(n_slots=3, x_w=8, y_w=8, id_w=3, seq_w=16, sup_w=4, radix_w=4), Shape(n_slots=32), Shape(n_slots=64),
    Shape(n_slots=4, x_w=6, y_w=6, tick_w=4, radix_w=4, tc_w=12, sup_w=6, id_w=4, seq_w=16, time_w=32),
)  # fmt: skip
_FIRST, _MOST = 4_000, 400_000  # events of a run: to see how fast it goes, and at most
_EVENTS_A_CHANGE = 400
_WAIT_LOG2 = 14  # of half the longest silence in bursts and noise, in ticks: there may be a motion step in each


class _Task(NamedTuple):
    seed: int
    run: int
    seconds: float


class _Done(NamedTuple):
    """One run; `difference` is empty where both are the same."""

    run: int
    shape: Shape
    events: int
    records: int
    changes: int
    difference: str


def main() -> int:
    """Run until there are enough events; 1 at a difference."""
    options = _options()
    if options.run is not None:
        done, _ = _of(options.run)(_Task(options.seed, options.run, 0.0), options.length)
        print(f"run {done.run}, {done.shape.n_slots} slots, {done.events:,} events: {done.difference or 'the same'}")
        return 1 if done.difference else 0
    print(f"seed {options.seed}", flush=True)
    began, events, records, changes, through_top = time.monotonic(), 0, 0, 0, 0
    slots: Counter[int] = Counter()
    for done in _runs(options):
        name = f"{done.shape.n_slots} slots"
        if done.difference:
            print(f"run {done.run}, {name}, {done.events:,} events: {done.difference}")
            return 1
        events, records, changes = events + done.events, records + done.records, changes + done.changes
        slots[done.shape.n_slots] += done.events
        through_top += done.events if done.run % 2 == 0 else 0
        print(f"run {done.run}, {name}: {done.events:,} events; {events:,} in all, {records:,} records", flush=True)
    print(f"the same: {events:,} events, {records:,} records, {changes:,} changes, {time.monotonic() - began:.0f} s")
    for number, of_slots in sorted(slots.items()):
        print(f"  {number} slots: {of_slots:,} events")
    if options.output:
        found = {"seed": options.seed, "events": events, "through_top": through_top, "records": records, "changes": changes}
        with written_aside(options.output) as file:
            file.write(json.dumps(found | {"slots": dict(sorted(slots.items()))}, indent=1).encode() + b"\n")
    return 0


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0] if __doc__ else None)
    parser.add_argument("--events", type=int, default=1_000_000, help="how many at least (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of everything that is drawn (default: %(default)s)")
    parser.add_argument("--seconds", type=float, default=20.0, help="how long a run takes, about (default: %(default)s)")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default: %(default)s)")
    parser.add_argument("--run", type=int, help="only this run, of --length events")
    parser.add_argument("--length", type=int, default=_FIRST, help="events of --run (default: %(default)s)")
    parser.add_argument("--output", type=Path, metavar="FILE", help="write seed, numbers and events of each number of slots")
    options = parser.parse_args()
    for name, least in (("events", 1), ("seed", 0), ("jobs", 1), ("run", 0)):
        value = getattr(options, name)
        if value is not None and value < least:
            parser.error(f"--{name} {value}: must be at least {least}")
    if not 0 < options.seconds <= 86_400:
        parser.error(f"--seconds {options.seconds:g}: must be more than 0, at most 86,400")
    if options.length <= ALONE:
        parser.error(f"--length {options.length}: must be more than {ALONE}")
    if options.output and options.output.exists():
        parser.error(f"--output {options.output}: exists already")
    return options


def _runs(options: argparse.Namespace) -> Iterator[_Done]:
    """Runs, as they end, until there are enough events or one has a difference."""
    events, number = 0, count()
    with ProcessPoolExecutor(options.jobs, multiprocessing.get_context("spawn")) as pool:
        going: set[Future[_Done]] = set()
        while events < options.events:
            while len(going) < options.jobs:
                going.add(pool.submit(_run, _Task(options.seed, next(number), options.seconds)))
            ended, going = wait(going, return_when=FIRST_COMPLETED)
            for done in (future.result() for future in ended):
                events += done.events
                yield done
                if done.difference:
                    return


def _run(task: _Task) -> _Done:
    done, took_s = _of(task.run)(task, _FIRST)
    events = int(_FIRST * task.seconds / took_s)
    return done if done.difference or events < 2 * _FIRST else _of(task.run)(task, min(events, _MOST))[0]


def _of(run: int) -> Callable[[_Task, int], tuple[_Done, float]]:
    return _alone if run % 2 else _in_top


def _shape(task: _Task) -> Shape:
    return _SHAPES[task.run // 2 % len(_SHAPES)]


def _in_top(task: _Task, events: int) -> tuple[_Done, float]:
    """`evcot_top` and the model on so many events; and how many seconds that took, once the hardware was there."""
    shape, rng = _shape(task), np.random.default_rng([task.seed, task.run])
    sensor = FilterShape(1 << shape.x_w, 1 << shape.y_w)  # of filters that are not there
    config = replace(random_motion(rng, shape), filter_shape=sensor)
    waits = replace(shape, tc_w=min(shape.tc_w, _WAIT_LOG2))
    traffic = random_motion_traffic(rng, waits, events)
    device = TopDevice(config, {"FIFO_DEPTH": 16, "RECORD_DEPTH": 3}, pace=Pace.random(rng) if rng.random() < 0.75 else None)
    began = time.monotonic()
    try:
        both = rewritten(device, config, traffic, rng, events // _EVENTS_A_CHANGE)
    except HardwareError as error:
        return _Done(task.run, shape, events, 0, 0, str(error)), time.monotonic() - began
    done = _Done(task.run, shape, events, len(both.model.records), len(both.at), _difference(both))
    return done, time.monotonic() - began


def _alone(task: _Task, events: int) -> tuple[_Done, float]:
    """The same for the array alone, whose registers stay."""
    shape, seed = _shape(task), int(np.random.SeedSequence([task.seed, task.run]).generate_state(1)[0])
    model = build_device(random_motion(np.random.default_rng(seed), shape), waves=False)
    waits = replace(shape, tc_w=min(shape.tc_w, _WAIT_LOG2 + 2))  # longer silences than in evcot_top, as clocks are faster here
    began = time.monotonic()
    try:
        run = random_motion_run(waits, seed, events, model)
    except (MismatchError, HardwareError) as error:
        return _Done(task.run, shape, events, 0, 0, str(error)), time.monotonic() - began
    return _Done(task.run, shape, run.events, run.records, 0, ""), time.monotonic() - began


def _difference(both: Rewritten) -> str:
    """Which columns differ, and where first."""
    found = []
    for name in both.model._fields:
        mine, theirs = getattr(both.hardware, name), getattr(both.model, name)
        if not np.array_equal(mine, theirs):
            shared = min(len(mine), len(theirs))
            first = int(np.append(np.flatnonzero(mine[:shared] != theirs[:shared]), shared)[0])
            found.append(f"{name} from {first} of {len(mine)} and {len(theirs)}")
    return "; ".join(found)


if __name__ == "__main__":
    sys.exit(main())
