# SPDX-License-Identifier: Apache-2.0
"""Co-simulation of a recording of any length: as `cosim`, in bounded memory, with checkpoints.

Hardware and model are compared chunk by chunk, as always. While they are at the next chunk, another thread feeds the software
tracker and adds to both logs, which grow in the folder of the work. The model's log is not kept: every chunk of it was compared
with the hardware's.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.compiling import compiled_aside
from evcot.digest import EventsDigest
from evcot.errors import RecordingError
from evcot.events import Events
from evcot.hardware.golden import to_track_records
from evcot.recognition.tracker import TrackClassifier
from evcot.recognition.weights import Weights
from evcot.recordings.formats.source import Sensor
from evcot.trackers.config import RunConfig
from evcot.tracks.record import NO_NAMES, no_verdicts
from evcot.tracks.spool import LogSpool
from evcot.tracks.spooling import rest_of
from evcot.tracks.tally import Tally
from evcot.unfinished import CHECKPOINT_EVENTS, Unfinished

from ..devices.device import build_device
from ..memory import keep_little
from .cosim import Measured, check_addresses_of, compile_kernels, software_of, stalls_from
from .lockstep import CHUNK, Lockstep, Step, cut
from .run_file import Source

__all__ = ["LongRun", "run_long"]


@dataclass(frozen=True, kw_only=True)
class LongRun(Measured):
    """Results of one run.

    Attributes:
        hardware, software: the logs, in files.
        hardware_tally, software_tally: what was counted in them.
        begin_us, end_us: times of the first and the last event.
        digest: of all events.
    """

    name: str
    sensor: Sensor
    hardware: LogSpool
    software: LogSpool
    hardware_tally: Tally
    software_tally: Tally
    begin_us: int
    end_us: int
    digest: str

    @property
    def events(self) -> int:
        """Number of events."""
        return self.hardware_tally.events


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
    """Run hardware, model and software tracker over a file.

    Args:
        work: where the logs grow; it continues from its state.
        every: events from one checkpoint to the next, rounded up to whole chunks, and one after the last event; 0 makes none.
        resumed: called with the number of events that an earlier process has driven.
        stall_seed, weights, building, progress: as of `cosim.run_cosim`.

    Raises:
        MismatchError: hardware and model differ.
        ConfigError, RecordingError, ToolchainError.
    """
    keep_little()
    with source.opened() as file:
        sensor, name = file.sensor, file.name
        check_addresses_of(sensor, config.hardware, name)
        device_config = config.device_config(*sensor)
        build = build_device(device_config, savable=True, on_miss=building)
        state: dict[str, Any] = work.state or {}
        tallies = state.get("tallies") or (Tally(), Tally())
        logs = [LogSpool(work.folder, side, state.get(side, (0, 0))) for side in ("hardware", "software")]
        for log in logs:
            work.held.callback(log.close)
        software = state.get("tracker") or software_of(sensor, config)
        classifier = state.get("classifier") or (None if weights is None else TrackClassifier(device_config, weights))
        verdicts: list[NDArray[np.void]] = state.get("verdicts", [no_verdicts()])
        software_s, end_us = state.get("software_s", 0.0), state.get("end_us", 0)
        made_of, at = EventsDigest(), tallies[0].events
        begin_us: int | None = state.get("begin_us")

        def follow(chunk: Events, step: Step, first: int) -> None:
            nonlocal software_s
            assert begin_us is not None
            made_of.add(chunk)
            records = to_track_records(step.hardware.records, device_config, chunk.t_us, first, begin_us)
            _keep(logs[0], tallies[0], records, step.hardware.owner)
            if classifier is not None:
                verdicts.append(classifier.feed(chunk, first, step.hardware, step.visible, records))
            started = time.perf_counter()
            _keep(logs[1], tallies[1], *software.feed(chunk))
            software_s += time.perf_counter() - started

        def save() -> None:
            beside.wait()
            for log in logs:
                log.flush()
            work.save(
                {
                    "tallies": tallies, "hardware": logs[0].lengths, "software": logs[1].lengths, "tracker": software,
                    "software_s": software_s, "begin_us": begin_us, "end_us": end_us, "digest": made_of.hex(),
                    "lockstep": lockstep.state(), "classifier": classifier, "verdicts": verdicts,
                }
            )  # fmt: skip

        with (
            Lockstep(device_config, stalls=stalls_from(stall_seed), seed=stall_seed, model=build) as lockstep,
            _Beside() as beside,
        ):
            if at:
                lockstep.restore(state["lockstep"])
                if resumed is not None:
                    resumed(at)
            for chunk in cut(rest_of(source.blocks(file), made_of, at, state.get("digest", "")), CHUNK):
                if begin_us is None:
                    begin_us = int(chunk.t_us[0])
                    compiled_aside(compile_kernels, chunk[:1], sensor, config)
                first, end_us = lockstep.events, int(chunk.t_us[-1])
                try:
                    step = lockstep.feed(chunk)
                except RecordingError as error:
                    raise RecordingError(f"{name}: {error}") from error
                beside.do(follow, chunk, step, first)
                if progress is not None:
                    progress(lockstep.events, end_us - begin_us, lockstep.events / lockstep.wall_s)
                if every and lockstep.events - at >= every and not lockstep.events % CHUNK:
                    at = lockstep.events
                    save()
            beside.wait()
            if every and lockstep.events > at:
                save()  # what follows, logs and pages, takes minutes and may find the disk full
            _keep(logs[1], tallies[1], software.finish(), np.empty(0, np.int16))
            cycles, wall_s = lockstep.device.cycle, lockstep.wall_s
    for log, engine in zip(logs, (device_config.module, config.software), strict=True):
        log.engine, log.recording = engine, made_of.hex()
    logs[0].verdicts, logs[0].class_names = np.concatenate(verdicts), NO_NAMES if weights is None else weights.names
    assert begin_us is not None
    return LongRun(
        name=name,
        sensor=sensor,
        config=config,
        hardware=logs[0],
        software=logs[1],
        hardware_tally=tallies[0],
        software_tally=tallies[1],
        begin_us=begin_us,
        end_us=end_us,
        digest=made_of.hex(),
        cycles=cycles,
        latency=lockstep.latency,
        wall_s=wall_s,
        software_s=software_s,
        build=build,
        seed=stall_seed,
    )


class _Beside:
    """A thread that does one thing after the other, at most one of them behind; what is under way ends with the context."""

    def __init__(self) -> None:
        self._thread = ThreadPoolExecutor(1)
        self._under_way: Future[None] | None = None

    def do(self, work: Callable[..., None], *arguments: Any) -> None:
        """Begin it as soon as what is under way has ended."""
        self.wait()
        self._under_way = self._thread.submit(work, *arguments)

    def wait(self) -> None:
        """Until nothing is under way; raises what that has raised."""
        if self._under_way is not None:
            self._under_way.result()
            self._under_way = None

    def __enter__(self) -> _Beside:
        return self

    def __exit__(self, *_: object) -> None:
        self._thread.shutdown()


def _keep(log: LogSpool, tally: Tally, records: NDArray[np.void], owner: NDArray[np.int16]) -> None:
    log.add(records, owner)
    tally.add(records, owner)
