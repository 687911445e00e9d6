# SPDX-License-Identifier: Apache-2.0
"""Co-simulation of a recording: hardware, golden model and software tracker, checked and compared."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from evcot.errors import ConfigError, RecordingError
from evcot.events import Events, Recording, check_pixels
from evcot.filters.config import FilterConfig
from evcot.filters.run import filtered
from evcot.hardware.config import CotConfig, HardwareConfig, MotionConfig
from evcot.hardware.contract import RECORD
from evcot.hardware.golden import golden_model, to_track_records
from evcot.recognition.tracker import TrackClassifier
from evcot.recognition.weights import Weights
from evcot.recordings.formats.source import Sensor
from evcot.ticks import TickCounter, TickedEvents
from evcot.trackers.config import RunConfig
from evcot.trackers.engines import ENGINES
from evcot.tracks.compare import Agreement, compare
from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot.tracks.record import NO_NAMES, no_verdicts
from evcot.tracks.tracking import FilteredTracker, Tracker, log_of

from ..devices.base import HardwareError, Stalls, check_silence
from ..devices.device import Device, build_device
from ..rtl.build import BuiltModel
from .lockstep import Lockstep, chunks
from .mismatch import Mismatch
from .run_file import Source

__all__ = [
    "NEAR_PX",
    "CosimRun",
    "Measured",
    "check_addresses",
    "check_addresses_of",
    "compile_kernels",
    "near_px",
    "rerun",
    "run_cosim",
    "software_of",
    "stalls_from",
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


def check_addresses(recording: Recording, config: HardwareConfig) -> None:
    """Check that addresses in hardware, and memories of trackers and filters, reach every pixel of the recording's sensor.

    Raises:
        ConfigError: too few bits of an address.
        RecordingError: too many pixels.
    """
    check_addresses_of((recording.width, recording.height), config, recording.name)


def check_addresses_of(sensor: Sensor, config: HardwareConfig, name: str) -> None:
    """As `check_addresses`, for a sensor (width, height); `name` is what it belongs to."""
    check_pixels(*sensor)
    for field, bits, size in (("x_w", config.shape.x_w, sensor[0]), ("y_w", config.shape.y_w, sensor[1])):
        if size > 1 << bits:
            raise ConfigError(f"shape.{field} = {bits}: too few bits for {size} pixels of {name}")


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
    check_addresses(recording, config.hardware)
    try:
        check_silence(events.t_us, config.hardware)
    except RecordingError as error:
        raise RecordingError(f"{recording.name}: {error}") from error
    device_config = config.device_config(recording.width, recording.height)
    stalls = stalls_from(stall_seed)
    t0_us = int(events.t_us[0])
    sensor = recording.width, recording.height
    hardware, model = _LogParts(device_config, t0_us), _LogParts(device_config, t0_us)
    classifier = None if weights is None else TrackClassifier(device_config, weights)
    with ThreadPoolExecutor(1, "build") as builds:
        built = builds.submit(build_device, device_config, on_miss=building)
        compile_kernels(events[:1], sensor, config)
        build = built.result()
    verdicts = [no_verdicts()]
    with Lockstep(device_config, stalls=stalls, seed=stall_seed, model=build) as lockstep:
        for chunk in chunks(events):
            first = lockstep.events
            step = lockstep.feed(chunk)
            assert step.model is not None
            records = hardware.add(step.hardware.records, step.hardware.owner, chunk.t_us, first)
            model.add(step.model.records, step.model.owner, chunk.t_us, first)
            if classifier is not None:
                verdicts.append(classifier.feed(chunk, first, step.hardware, step.visible, records))
            if progress is not None:
                progress(lockstep.events, int(chunk.t_us[-1]) - t0_us, lockstep.events / lockstep.wall_s)
        cycles, wall_s = lockstep.device.cycle, lockstep.wall_s

    names = NO_NAMES if weights is None else weights.names
    hardware_log, model_log = (
        replace(parts.log(), verdicts=np.concatenate(verdicts), class_names=names) for parts in (hardware, model)
    )
    started = time.perf_counter()
    software = log_of(config.software, software_of(sensor, config), [events])
    software_s = time.perf_counter() - started

    agreement = compare(hardware_log, software, radius_px=near_px(config), span_us=(t0_us, int(events.t_us[-1])))
    return CosimRun(
        recording=recording,
        config=config,
        hardware=hardware_log,
        model=model_log,
        software=software,
        agreement=agreement,
        cycles=cycles,
        latency=lockstep.latency,
        wall_s=wall_s,
        software_s=software_s,
        build=build,
        seed=stall_seed,
        source=source,
    )


def rerun(recording: Recording, config: RunConfig, found: Mismatch) -> tuple[TrackLog, TrackLog]:
    """Logs of hardware and model from a second, unchecked run, up to the end of the chunk with their first difference.

    If the hardware violated its stream protocol in that chunk, its log has no records of it, and -1 for the owners.
    """
    device_config, t0_us = config.device_config(recording.width, recording.height), int(recording.events.t_us[0])
    clock = TickCounter(device_config.tick_us)
    device = Device(device_config, stalls=stalls_from(found.seed))
    golden = golden_model(device_config)
    hardware, model = _LogParts(device_config, t0_us), _LogParts(device_config, t0_us)
    first = 0
    for chunk in chunks(recording.events):
        ticked = clock.count(chunk)
        expected = golden.feed(ticked)
        model.add(expected.records, expected.owner, chunk.t_us, first)
        try:
            decided = device.stream(ticked)
            hardware.add(decided.records, decided.owner, chunk.t_us, first)
        except HardwareError:
            hardware.add(np.empty(0, RECORD), np.full(len(chunk), -1, np.int16), chunk.t_us, first)
            break
        first += len(chunk)
        if first > found.event_index:
            break
    return hardware.log(), model.log()


def stalls_from(seed: int | None) -> Stalls:
    """Random stall patterns on every stream, or none without a seed."""
    return Stalls() if seed is None else Stalls.random(np.random.default_rng(seed))


def compile_kernels(first: Events, sensor: Sensor, config: RunConfig) -> None:
    """Make Numba compile model and tracker before anything is timed."""
    golden_model(config.device_config(*sensor)).feed(TickedEvents.of(first))
    log_of(config.software, software_of(sensor, config), [first])


def software_of(sensor: Sensor, config: RunConfig) -> Tracker:
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


class _LogParts:
    """One engine's decisions, collected chunk by chunk."""

    def __init__(self, config: CotConfig | MotionConfig, t0_us: int) -> None:
        self._config = config
        self._t0_us = t0_us
        self._records: list[NDArray[np.void]] = []
        self._owners: list[NDArray[np.int16]] = []

    def add(self, raw: NDArray[np.void], owner: NDArray[np.int16], t_us: NDArray[np.int64], first_seq: int) -> NDArray[np.void]:
        """Returns the records in the units of a log."""
        self._records.append(to_track_records(raw, self._config, t_us, first_seq, self._t0_us))
        self._owners.append(owner)
        return self._records[-1]

    def log(self) -> TrackLog:
        return TrackLog(self._config.module, np.concatenate([np.empty(0, TRACK), *self._records]), np.concatenate(self._owners))
