# SPDX-License-Identifier: Apache-2.0
"""`evcot bench`: how fast everything runs on this machine, on any recording. Comparison with references: benchmarks/run.py."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from evcot.events import Events
from evcot.filters.config import FilterConfig
from evcot.filters.run import filtered
from evcot.hardware.modules import MODULES
from evcot.recordings.files import open_recording
from evcot.trackers.engines import ENGINES, usable_engines
from evcot.tracks.tracking import log_of

from ...devices.device import build_device
from ...lockstep.lockstep import Lockstep, chunks
from ...tables import print_table
from ..options import window_from
from .job import Job, job_from
from .progress import Progress

__all__ = ["run"]

_REPEATS = 3  # the best counts
_FILTERS = {"activity filter": FilterConfig(activity_us=5000), "refractory filter": FilterConfig(refractory_us=1000)}


class _Rate(NamedTuple):
    what: str
    seconds: float
    events: int


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Measure and print the rates; 0."""
    job = job_from(options, window_from(options))
    rates = []
    with Progress(job.recording.name, None, enabled=not (options.quiet or options.json)) as progress:
        for what, run in _jobs(job, progress):
            progress.note(what)
            rates.append(_Rate(what, _best_s(run), len(job.recording.events)))
    job.filters.save_learned()
    recording_s = job.recording.duration_us / 1e6
    if options.json:
        print(json.dumps([{**rate._asdict(), "events_per_s": rate.events / rate.seconds} for rate in rates], indent=2))
    elif not options.quiet:
        rows = [(r.what, f"{r.events / r.seconds / 1e6:.1f} M events/s", f"{recording_s / r.seconds:.0f} x") for r in rates]
        print_table([(f"{len(job.recording.events):,} events, {recording_s:.3f} s", "", "real time"), *rows])
    return 0


def _best_s(run: Callable[[], Any]) -> float:
    """Wall time of the best of some runs, after one that compiles what has to be."""
    run()
    times = []
    for _ in range(_REPEATS):
        begin = time.perf_counter()
        run()
        times.append(time.perf_counter() - begin)
    return min(times)


def _jobs(job: Job, progress: Progress) -> Iterator[tuple[str, Callable[[], Any]]]:
    """What is measured: (name, a run of it)."""
    recording = job.recording
    events, sensor = recording.events, (recording.width, recording.height)
    if not job.source.is_scene:
        yield "reading", partial(_read, job.source.path)
    for name, config in _FILTERS.items():
        yield name, partial(_filter, config, events, sensor)
    for name, engine in usable_engines().items():
        if name in MODULES and name != job.config.hardware.module:
            continue
        preset, settings = next(iter(engine.presets.items()))
        settings = job.config if name in MODULES else settings
        title = "golden model" if name in MODULES else f"{name}, {preset}"
        yield title, partial(_track, name, settings, events, sensor)
    hardware = job.config.device_config(*sensor)
    model = build_device(hardware, waves=False, on_miss=progress.building)
    for check, title in ((False, hardware.module), (True, f"{hardware.module}, checked against the model")):

        def simulate(check: bool = check) -> None:
            with Lockstep(hardware, stalls=job.stalls, seed=job.seed, check=check, model=model) as lockstep:
                for chunk in chunks(events):
                    lockstep.feed(chunk)

        yield title, simulate


def _read(path: Path) -> int:
    with open_recording(path) as file:
        return sum(len(block) for block in file.blocks())


def _filter(config: FilterConfig, events: Events, sensor: tuple[int, int]) -> Any:
    return filtered((), config, sensor).keep(events)


def _track(name: str, settings: Any, events: Events, sensor: tuple[int, int]) -> Any:
    return log_of(name, ENGINES[name].start(settings, FilterConfig(), sensor), [events])
