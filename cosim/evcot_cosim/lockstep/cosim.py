# SPDX-License-Identifier: Apache-2.0
"""Co-simulation of a recording: hardware, golden model and software tracker, checked and compared.

Every run is one loop over chunks of events: hardware and model are compared, then classifier and software tracker are fed.
`run_cosim` holds recording and logs in memory. `run_long` reads a file of any length; its logs grow in a folder, with
checkpoints, from which a killed run continues.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.compiling import compiled_aside
from evcot.digest import EventsDigest
from evcot.errors import RecordingError
from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.filters.run import filtered
from evcot.hardware.config import MotionConfig
from evcot.hardware.contract import RECORD
from evcot.hardware.golden import golden_model, to_track_records
from evcot.recognition.tracker import TrackClassifier
from evcot.recognition.weights import Weights
from evcot.recordings.formats.source import Sensor
from evcot.ticks import TickCounter, TickedEvents
from evcot.trackers.config import RunConfig
from evcot.trackers.engines import ENGINES
from evcot.tracks.compare import Agreement, compare
from evcot.tracks.log import Kind, TrackLog
from evcot.tracks.record import NO_NAMES, no_verdicts
from evcot.tracks.spool import LogSpool
from evcot.tracks.spooling import rest_of
from evcot.tracks.tracking import FilteredTracker, Tracker, log_of
from evcot.unfinished import CHECKPOINT_EVENTS, Unfinished

from ..devices.base import HardwareError, Stalls, check_addresses, check_silence
from ..devices.device import Device, build_device
from ..memory import keep_little
from ..rtl.build import BuiltModel
from .lockstep import CHUNK, Lockstep, Step, chunks, cut
from .mismatch import Mismatch
from .run_file import Source

__all__ = [
    "NEAR_PX",
    "CosimRun",
    "LongRun",
    "Measured",
    "near_px",
    "rerun",
    "run_cosim",
    "run_long",
]

NEAR_PX = 12.0  # of cot_motion and the adaptive tracker, whose windows have no size of their own


@dataclass(frozen=True, kw_only=True)
class Measured:
    """What is known of every run, whether its recording and logs are held in memory or not.

    Attributes:
        config: configuration of the run.
        cycles: clocks of the hardware, without reset and register writes.
        latency: histogram of records by clocks since their event, see `Lockstep`.
        wall_s: duration of the lock-step alone.
        software_s: duration of the software tracker.
        build: the simulated model.
        seed: seed of the stall patterns, or None.
    """

    config: RunConfig
    cycles: int
    latency: NDArray[np.int64]
    wall_s: float
    software_s: float
    build: BuiltModel
    seed: int | None


@dataclass(frozen=True, kw_only=True)
class CosimRun(Measured):
    """Results of one run.

    Attributes:
        recording: its input.
        hardware, model, software: one TrackLog per engine.
        agreement: hardware against software, by outcome.
        source: where the recording was read from; None for one that was made in memory.
    """

    recording: Recording
    hardware: TrackLog
    model: TrackLog
    software: TrackLog
    agreement: Agreement
    source: Source | None = None

    def __repr__(self) -> str:
        events, tracks = len(self.recording.events), len(self.hardware.of_kind(Kind.BORN))
        module = self.config.hardware.module
        return f"<CosimRun {self.recording.name}: {module}, {events:,} events, {tracks} hardware tracks, exact>"


@dataclass(frozen=True, kw_only=True)
class LongRun(Measured):
    """Results of a run of any length.

    Attributes:
        hardware, software: the logs, in files.
        begin_us, end_us: times of the first and the last event.
        digest: of all events.
    """

    name: str
    sensor: Sensor
    hardware: LogSpool
    software: LogSpool
    begin_us: int
    end_us: int
    digest: str

    @property
    def events(self) -> int:
        """Number of events."""
        return self.hardware.tally.events


def run_cosim(
    recording: Recording,
    config: RunConfig,
    *,
    stall_seed: int | None = None,
    source: Source | None = None,
    weights: Weights | None = None,
    building: Callable[[], None] | None = None,
    progress: Callable[[int, int, float], None] | None = None,
) -> CosimRun:
    """Run all three engines over a recording.

    Args:
        recording: at least one event.
        config: both trackers' configurations.
        stall_seed: seed of random stalls on every stream of the hardware; None never stalls.
        source: where the recording was read from.
        weights: of a classifier in software behind the hardware's owned events; its verdicts are in the logs of hardware and
            model. None: without one.
        building: called before a build that takes seconds.
        progress: called after each run of events with (events done, time of the last event in us, events/s).

    Raises:
        MismatchError: hardware and model differ.
        ConfigError, RecordingError, ToolchainError.
    """
    events = recording.events
    if not len(events):
        raise RecordingError(f"{recording.name}: holds no events")
    sensor = recording.width, recording.height
    check_addresses(sensor, config.hardware, recording.name)
    try:
        check_silence(events.t_us, config.hardware)
    except RecordingError as error:
        raise RecordingError(f"{recording.name}: {error}") from error
    device_config = config.device_config(*sensor)
    with ThreadPoolExecutor(1, "build") as builds:
        built = builds.submit(build_device, device_config, on_miss=building)
        _compile_kernels(sensor, config)
        build = built.result()
    logs = {side: LogSpool(None, side) for side in ("hardware", "model", "software")}
    with _Engines(sensor, config, build, stall_seed, weights, logs) as engines:
        for chunk in chunks(events):
            engines.feed(chunk, progress)
        engines.finish()
    hardware, model, software = (_held(logs[side]) for side in logs)
    return CosimRun(
        recording=recording,
        hardware=hardware,
        model=model,
        software=software,
        agreement=compare(hardware, software, radius_px=near_px(config), span_us=(engines.begin_us, engines.end_us)),
        source=source,
        **engines.measured(),
    )


def run_long(
    source: Source,
    config: RunConfig,
    work: Unfinished,
    *,
    stall_seed: int | None = None,
    every: int = CHECKPOINT_EVENTS,
    weights: Weights | None = None,
    building: Callable[[], None] | None = None,
    progress: Callable[[int, int, float], None] | None = None,
    resumed: Callable[[int], None] | None = None,
) -> LongRun:
    """Run hardware, model and software tracker over a file of any length, in bounded memory.

    The model's log is not kept: every chunk of it was compared with the hardware's.

    Args:
        work: where the logs grow; it continues from its state.
        every: events from one checkpoint to the next, rounded up to whole chunks, and one after the last event; 0 makes none.
        resumed: called with the number of events that an earlier process has driven.
        stall_seed, weights, building, progress: as of `run_cosim`.

    Raises:
        MismatchError: hardware and model differ.
        ConfigError, RecordingError, ToolchainError.
    """
    keep_little()
    with source.opened() as file:
        sensor, name = file.sensor, file.name
        check_addresses(sensor, config.hardware, name)
        device_config = config.device_config(*sensor)
        build = build_device(device_config, savable=True, on_miss=building)
        state: dict[str, Any] = work.state or {}
        logs = {side: LogSpool(work.folder, side, state.get(side)) for side in ("hardware", "software")}
        for log in logs.values():
            work.held.callback(log.close)
        made_of, at = EventsDigest(), logs["hardware"].tally.events
        compiled_aside(_compile_kernels, sensor, config)
        with _Engines(sensor, config, build, stall_seed, weights, logs, made_of) as engines:

            def save() -> None:
                own = engines.state()
                work.save({side: log.state() for side, log in logs.items()} | {"engines": own, "digest": made_of.hex()})

            if at:
                engines.restore(state["engines"])
                if resumed is not None:
                    resumed(at)
            for chunk in cut(rest_of(source.blocks(file), made_of, at, state.get("digest", "")), CHUNK):
                try:
                    events = engines.feed(chunk, progress)
                except RecordingError as error:
                    raise RecordingError(f"{name}: {error}") from error
                if every and events - at >= every and not events % CHUNK:
                    at = events
                    save()
            if every and engines.lockstep.events > at:
                save()  # what follows, logs and pages, takes minutes and may find the disk full
            engines.finish()
    for log in logs.values():
        log.recording = made_of.hex()
    return LongRun(
        name=name,
        sensor=sensor,
        hardware=logs["hardware"],
        software=logs["software"],
        begin_us=engines.begin_us,
        end_us=engines.end_us,
        digest=made_of.hex(),
        **engines.measured(),
    )


def rerun(recording: Recording, config: RunConfig, found: Mismatch) -> tuple[TrackLog, TrackLog]:
    """Logs of hardware and model from a second, unchecked run, up to the end of the chunk with their first difference.

    If the hardware violated its stream protocol in that chunk, its log has no records of it, and -1 for the owners.
    """
    device_config, t0_us = config.device_config(recording.width, recording.height), int(recording.events.t_us[0])
    clock = TickCounter(device_config.tick_us)
    device = Device(device_config, stalls=Stalls.seeded(found.seed))
    golden = golden_model(device_config)
    hardware, model = LogSpool(None, "hardware"), LogSpool(None, "model")
    hardware.engine = model.engine = device_config.module
    first = 0
    for chunk in chunks(recording.events):
        ticked = clock.count(chunk)
        expected = golden.feed(ticked)
        model.add(to_track_records(expected.records, device_config, chunk.t_us, first, t0_us), expected.owner)
        try:
            decided = device.stream(ticked)
            records, owner = decided.records, decided.owner
        except HardwareError:
            records, owner = np.empty(0, RECORD), np.full(len(chunk), -1, np.int16)
        hardware.add(to_track_records(records, device_config, chunk.t_us, first, t0_us), owner)
        first += len(chunk)
        if first > found.event_index:
            break
    return _held(hardware), _held(model)


def _compile_kernels(sensor: Sensor, config: RunConfig) -> None:
    """Make Numba compile model and tracker before anything is timed."""
    corner = np.zeros(1, np.uint16)
    event = Events(np.zeros(1, np.int64), corner, corner, np.zeros(1, np.uint8))
    golden_model(config.device_config(*sensor)).feed(TickedEvents.of(event))
    log_of(config.software, _software_of(sensor, config), [event])


def _software_of(sensor: Sensor, config: RunConfig) -> Tracker:
    """The software tracker, with the same filters in front, in the same ticks."""
    tracker = ENGINES[config.software].start(getattr(config, config.software), FilterConfig(), sensor)
    filters = config.in_front_of_software
    if not filters.enabled:
        return tracker
    return FilteredTracker(filtered((), filters, sensor, config.hardware.tick_us).keep, tracker)


def near_px(config: RunConfig) -> float:
    """How near each other tracks of one object are: a window's reach."""
    if config.software == "rct":
        return config.rct.radius_px
    if isinstance(config.hardware, MotionConfig):
        return NEAR_PX
    slot = config.hardware.slots[0]
    return float(slot.init_radix + slot.radix_th)


def _held(log: LogSpool) -> TrackLog:
    return TrackLog(log.engine, log.records[:], log.owner[:], verdicts=log.verdicts, class_names=log.class_names)


_STATE = ("software", "classifier", "verdicts", "software_s", "begin_us", "end_us")


class _Engines:
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
        self.software = _software_of(sensor, config)
        self.classifier = None if weights is None else TrackClassifier(device_config, weights)
        self.verdicts = [no_verdicts()]
        self.software_s = 0.0
        self.begin_us = self.end_us = 0
        self._config, self._build, self._logs, self._made_of = config, build, logs, made_of
        self._class_names = NO_NAMES if weights is None else weights.names
        self._thread = None if made_of is None else ThreadPoolExecutor(1)
        self._under_way: Future[None] | None = None

    def __enter__(self) -> _Engines:
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
            if side in self._logs and decided is not None:
                records = to_track_records(decided.records, self.lockstep.config, chunk.t_us, first, self.begin_us)
                self._logs[side].add(records, decided.owner)
                if side == "hardware" and self.classifier is not None:
                    self.verdicts.append(self.classifier.feed(chunk, first, step.hardware, step.visible, records))
        started = time.perf_counter()
        self._logs["software"].add(*self.software.feed(chunk))
        self.software_s += time.perf_counter() - started
