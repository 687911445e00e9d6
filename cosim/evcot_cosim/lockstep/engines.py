# SPDX-License-Identifier: Apache-2.0
"""All engines of a run, fed chunk by chunk: hardware and golden model in lock-step, classifier, and software tracker."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import numpy as np

from evcot.digest import EventsDigest
from evcot.events import Events
from evcot.filters.config import FilterConfig
from evcot.filters.run import filtered
from evcot.hardware.golden import golden_model, to_track_records
from evcot.recognition.tracker import TrackClassifier
from evcot.recognition.weights import Weights
from evcot.recordings.formats.source import Sensor
from evcot.ticks import TickedEvents
from evcot.trackers.config import RunConfig
from evcot.trackers.engines import ENGINES
from evcot.tracks.record import NO_NAMES, no_verdicts
from evcot.tracks.spool import LogSpool
from evcot.tracks.tracking import FilteredTracker, Tracker, log_of

from ..devices.base import Stalls
from ..rtl.build import BuiltModel
from .lockstep import Lockstep, Step

__all__ = ["Engines", "compile_kernels"]

_STATE = ("software", "classifier", "verdicts", "software_s", "begin_us", "end_us")


class Engines:
    """All engines of a run, as a context: hardware and model in lock-step, then classifier and software tracker.

    Args:
        logs: of hardware and software, and of the model where it is kept.
        made_of: of a recording that is read while it is driven; every event is added to it. Then another thread does all that
            follows the lock-step of a chunk while the next one is read and driven. Without it everything is done in turn, so
            that the time of each engine is its own.

    Attributes:
        verdicts: of the classifier.
        software_s: duration of the software tracker so far.
        begin_us, end_us: times of the first and of the newest event.
    """

    def __init__(
        self, sensor: Sensor, config: RunConfig, build: BuiltModel, seed: int | None, weights: Weights | None,
        logs: Mapping[str, LogSpool], made_of: EventsDigest | None = None,
    ) -> None:  # fmt: skip
        device_config = config.device_config(*sensor)
        self.lockstep = Lockstep(device_config, stalls=Stalls.seeded(seed), seed=seed, model=build)
        self.software = software_of(sensor, config)
        self.classifier = None if weights is None else TrackClassifier(device_config, weights)
        self.verdicts = [no_verdicts()]
        self.software_s = 0.0
        self.begin_us = self.end_us = 0
        self._config, self._build, self._logs, self._made_of = config, build, logs, made_of
        self._class_names = NO_NAMES if weights is None else weights.names
        self._thread = None if made_of is None else ThreadPoolExecutor(1)
        self._under_way: Future[None] | None = None

    def __enter__(self) -> Engines:
        return self

    def __exit__(self, *_: object) -> None:
        if self._thread is not None:
            self._thread.shutdown()
        self.lockstep.close()

    def feed(self, chunk: Events, progress: Callable[[int, int, float], None] | None = None) -> int:
        """Drive a chunk, and have it followed by the other engines; returns the number of events so far.

        Raises:
            MismatchError, RecordingError: as `Lockstep.feed`.
        """
        first = self.lockstep.events
        if not first:
            self.begin_us = int(chunk.t_us[0])
        step = self.lockstep.feed(chunk)
        self.end_us = int(chunk.t_us[-1])
        if self._thread is None:
            self._follow(chunk, step, first)
        else:
            self._settle()
            self._under_way = self._thread.submit(self._follow, chunk, step, first)
        events = self.lockstep.events
        if progress is not None:
            progress(events, self.end_us - self.begin_us, events / self.lockstep.wall_s)
        return events

    def finish(self) -> None:
        """End the software tracker, and complete the logs."""
        self._settle()
        self._logs["software"].add(self.software.finish(), np.empty(0, np.int16))
        for side, log in self._logs.items():
            log.engine = self._config.software if side == "software" else self.lockstep.config.module
            if side != "software":
                log.verdicts, log.class_names = np.concatenate(self.verdicts), self._class_names

    def state(self) -> dict[str, Any]:
        """Everything that the events so far leave behind, without the logs."""
        self._settle()
        return {name: getattr(self, name) for name in _STATE} | {"lockstep": self.lockstep.state()}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from the state of engines with the same arguments."""
        for name in _STATE:
            setattr(self, name, state[name])
        self.lockstep.restore(state["lockstep"])

    def measured(self) -> dict[str, Any]:
        """The fields of `Measured`."""
        lockstep = self.lockstep
        return {
            "config": self._config, "cycles": lockstep.device.cycle, "latency": lockstep.latency, "wall_s": lockstep.wall_s,
            "software_s": self.software_s, "build": self._build, "seed": lockstep.seed,
        }  # fmt: skip

    def _settle(self) -> None:
        """Wait until nothing is under way; raises what that has raised."""
        if self._under_way is not None:
            self._under_way.result()
            self._under_way = None

    def _follow(self, chunk: Events, step: Step, first: int) -> None:
        if self._made_of is not None:
            self._made_of.add(chunk)
        for side, decided in (("hardware", step.hardware), ("model", step.model)):
            if side in self._logs:
                assert decided is not None
                records = to_track_records(decided.records, self.lockstep.config, chunk.t_us, first, self.begin_us)
                self._logs[side].add(records, decided.owner)
                if side == "hardware" and self.classifier is not None:
                    self.verdicts.append(self.classifier.feed(chunk, first, step.hardware, step.visible, records))
        started = time.perf_counter()
        self._logs["software"].add(*self.software.feed(chunk))
        self.software_s += time.perf_counter() - started


def compile_kernels(sensor: Sensor, config: RunConfig) -> None:
    """Make Numba compile model and tracker before anything is timed."""
    corner = np.zeros(1, np.uint16)
    event = Events(np.zeros(1, np.int64), corner, corner, np.zeros(1, np.uint8))
    golden_model(config.device_config(*sensor)).feed(TickedEvents.of(event))
    log_of(config.software, software_of(sensor, config), [event])


def software_of(sensor: Sensor, config: RunConfig) -> Tracker:
    """The software tracker, with the same filters in front, in the same ticks."""
    tracker = ENGINES[config.software].start(getattr(config, config.software), FilterConfig(), sensor)
    filters = config.in_front_of_software
    if not filters.enabled:
        return tracker
    return FilteredTracker(filtered((), filters, sensor, config.hardware.tick_us).keep, tracker)
