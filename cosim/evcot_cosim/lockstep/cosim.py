# SPDX-License-Identifier: Apache-2.0
"""Co-simulation of a recording: hardware, golden model and software tracker, checked and compared.

Every run is one loop over chunks of events: hardware and model are compared, then classifier and software tracker are fed.
`run_cosim` holds recording and logs in memory. `run_long` reads a file of any length; its logs grow in a folder, with
checkpoints, from which a killed run continues.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.compiling import compiled_aside
from evcot.digest import EventsDigest
from evcot.errors import RecordingError
from evcot.events import Recording
from evcot.hardware.config import MotionConfig
from evcot.hardware.contract import RECORD
from evcot.hardware.golden import golden_model, to_track_records
from evcot.page import EVENTS_MAX, HEIGHT_PX, Page
from evcot.recognition.weights import Weights
from evcot.recordings.formats.source import Sensor
from evcot.ticks import TickCounter
from evcot.trackers.config import RunConfig
from evcot.tracks.compare import Agreement, compare
from evcot.tracks.log import Kind, TrackLog
from evcot.tracks.spool import LogSpool
from evcot.tracks.spooling import rest_of
from evcot.unfinished import CHECKPOINT_EVENTS, Unfinished

from ..devices.base import HardwareError, Stalls, check_addresses, check_silence
from ..devices.device import Device, build_device
from ..memory import keep_little
from ..rtl.build import BuiltModel
from .engines import Engines, compile_kernels
from .lockstep import CHUNK, chunks, cut
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

    def show(self, *, events_max: int = EVENTS_MAX, height_px: int = HEIGHT_PX) -> Page:
        """The page of `evcot report` for a notebook, without the waveform.

        Args:
            events_max: most events in the page, which are spread evenly over the recording.
            height_px: height of the frame in the notebook.

        Raises:
            ConfigError: a value outside its range.
        """
        page: Page = resolve_name("evcot_cosim.notebook:run_page")(self, events_max, height_px)
        return page

    def _repr_html_(self) -> str:
        """The run in a notebook: the page that `show` makes."""
        return self.show()._repr_html_()

    def save(self, folder: Path | str, *, waves: bool = True) -> dict[str, Any]:
        """Write what `evcot cosim -o FOLDER` writes, and return the summary; a recording made in memory is written, too.

        Files of an older run in the folder are replaced; other files are kept.

        Args:
            waves: whether to write a waveform, around the first merge, else around the first birth.

        Raises:
            OutputError: the folder is another command's, or a file cannot be written.
        """
        summary: dict[str, Any] = resolve_name("evcot_cosim.report.artifacts:save_run")(self, Path(folder), waves=waves)
        return summary

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
        compile_kernels(sensor, config)
        build = built.result()
    logs = {side: LogSpool(None, side) for side in ("hardware", "model", "software")}
    with Engines(sensor, config, build, stall_seed, weights, logs) as engines:
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
        compiled_aside(compile_kernels, sensor, config)
        with Engines(sensor, config, build, stall_seed, weights, logs, made_of) as engines:

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
        broken = False
        try:
            decided = device.stream(ticked)
            records, owner = decided.records, decided.owner
        except HardwareError:
            broken, records, owner = True, np.empty(0, RECORD), np.full(len(chunk), -1, np.int16)
        hardware.add(to_track_records(records, device_config, chunk.t_us, first, t0_us), owner)
        first += len(chunk)
        if broken or first > found.event_index:
            break
    return _held(hardware), _held(model)


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
