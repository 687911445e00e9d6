# SPDX-License-Identifier: Apache-2.0
"""Lock-step simulation: hardware and golden model on the same events, compared chunk by chunk during the run."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events
from evcot.hardware.config import CotConfig, MotionConfig
from evcot.hardware.contract import RECORD
from evcot.hardware.golden import golden_model
from evcot.hardware.model import Decisions
from evcot.ticks import TickCounter
from evcot.tracks.log import Kind

from ..devices.base import HardwareError, Stalls, check_silence
from ..devices.device import Device, DeviceState, StreamTimes
from ..rtl.build import BuiltModel
from .mismatch import Mismatch, MismatchError

__all__ = ["CHUNK", "Clocks", "FirstDifference", "Lockstep", "Step", "chunks", "cut", "difference_of", "dump_window"]

_STATE = ("events", "records", "wall_s", "latency", "_clock", "_last_us", "_golden")
LATENCY_MAX = 4_095  # clocks; longer latencies share the last bin
CHUNK = 1 << 16  # events driven at once: bounds memory, and long enough to make the cost of a call negligible


@dataclass(frozen=True)
class Step:
    """What hardware and model decided about one chunk of events.

    Attributes:
        hardware, model: each with `records`, `owner`, `rel_x` and `rel_y`; `model` is None if the hardware ran alone.
        visible: (n,) bool, whether the owner of each event is visible, of cot_motion's model; all False without it.
    """

    hardware: Decisions
    model: Decisions | None
    visible: NDArray[np.bool_]


def chunks(events: Events, size: int = CHUNK) -> Iterator[Events]:
    """Split events into chunks of `size`; views, no copies."""
    for begin in range(0, len(events), size):
        yield events[begin : begin + size]


def cut(blocks: Iterable[Events], size: int) -> Iterator[Events]:
    """Chunks of exactly `size` events, and a last one: the clocks of a run depend on how it is cut."""
    waiting: list[Events] = []
    have = 0
    for block in blocks:
        waiting.append(block.kept())
        have += len(block)
        if have >= size:
            joined = Events.joined(waiting)
            whole = have - have % size
            yield from (joined[begin : begin + size].packed() for begin in range(0, whole, size))
            waiting, have = [joined[whole:]], have - whole
    if have:
        yield Events.joined(waiting).packed()


class Lockstep:
    """Feeds events to hardware and model in parallel, the model in a second thread, and compares the results of each chunk.

    Args:
        config: configuration of both.
        stalls: stall patterns; decisions must not depend on them.
        seed: seed of the patterns, for the mismatch record.
        check: False runs the hardware alone.
        model: a built model, to avoid the look-up.

    Attributes:
        device: the hardware.
        events, records, wall_s: totals so far.
        latency: (k,) int64, number of records sent 0, 1, 2, … clocks after their event was accepted; the last bin includes all
            longer latencies. Records caused by time, not by an event, are left out.
    """

    def __init__(
        self,
        config: CotConfig | MotionConfig,
        *,
        stalls: Stalls | None = None,
        seed: int | None = None,
        check: bool = True,
        model: BuiltModel | None = None,
    ) -> None:
        self.device = Device(config, stalls=stalls, model=model)
        self.config = config
        self.seed = seed
        self.events = 0
        self.records = 0
        self.wall_s = 0.0
        self.latency = np.zeros(LATENCY_MAX + 1, np.int64)
        self._clock = TickCounter(config.tick_us)
        self._last_us: int | None = None
        self._golden = golden_model(config) if check else None
        self._second = ThreadPoolExecutor(1) if check else None

    def feed(self, events: Events) -> Step:
        """Drive one chunk of at least one event and return the decisions.

        Raises:
            MismatchError: hardware and model differ, or the hardware violated its stream protocol.
            RecordingError: the events have a gap that would take too many clocks: see `silence`. Nothing was driven.
        """
        check_silence(events.t_us, self.config, self.events, self._last_us)
        self._last_us = int(events.t_us[-1])
        started = time.perf_counter()
        ticked = self._clock.count(events)
        if self._golden is None or self._second is None:
            hardware, times = self.device.stream_timed(ticked)
            step = Step(hardware, None, np.zeros(len(events), np.bool_))
        else:
            expected = self._second.submit(self._golden.feed, ticked)
            try:
                hardware, times = self.device.stream_timed(ticked)
            except HardwareError as error:
                index = min(max(error.seq - self.events, 0), len(ticked) - 1)
                raise MismatchError(
                    self._mismatch(self.events + index, int(ticked.ticks[index]), "stream", str(error), "in order")
                ) from error
            step = Step(hardware, expected.result(), self._golden.visible)
            self._compare(hardware, expected.result(), ticked.ticks)
        self._count_clocks(hardware.records, times, ticked.ticks)
        self.wall_s += time.perf_counter() - started
        self.events += len(events)
        self.records += len(step.hardware.records)
        return step

    def state(self) -> dict[str, Any]:
        """Everything that the events so far leave behind, on both sides; see `Device.state`."""
        own = {name: getattr(self, name) for name in _STATE}
        return {**own, "device": tuple(self.device.state())}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from the state of a `Lockstep` with the same arguments."""
        for name in _STATE:
            setattr(self, name, state[name])
        self.device.restore(DeviceState(*state["device"]))

    def close(self) -> None:
        """End the model's thread."""
        if self._second is not None:
            self._second.shutdown()

    def __enter__(self) -> Lockstep:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _count_clocks(self, records: NDArray[np.void], times: StreamTimes, ticks: NDArray[np.int64]) -> None:
        event = np.minimum(records["seq"].astype(np.int64) - self.events, len(ticks) - 1)
        # Of records with a motion step's time, some are sent before the event that they count as.
        caused = (records["kind"] != Kind.LOST) & (records["time"].astype(np.int64) == ticks[event])
        taken = times.accepted[event[caused]]
        clocks = np.minimum(times.recorded[caused] - taken, LATENCY_MAX)
        self.latency += np.bincount(clocks, minlength=LATENCY_MAX + 1)

    def _mismatch(self, index: int, tick: int, field: str, hardware: Any, model: Any) -> Mismatch:
        return Mismatch(index, tick, field, hardware, model, self.seed, self.config)

    def _compare(self, hardware: Decisions, model: Decisions, ticks: NDArray[np.int64]) -> None:
        assert self._golden is not None
        found = difference_of(hardware, model, self.events, {"visible": (self.device.visible, self._golden.visible)})
        if found:
            tick = int(ticks[min(max(found.event_index - self.events, 0), len(ticks) - 1)])
            raise MismatchError(self._mismatch(found.event_index, tick, found.field, found.hardware, found.model))


class FirstDifference(NamedTuple):
    """The first event at which two differ, in which field, and both values."""

    event_index: int
    field: str
    hardware: int | str | None
    model: int | str | None


def difference_of(
    hardware: Decisions,
    model: Decisions,
    first: int = 0,
    columns: Mapping[str, tuple[NDArray[Any], NDArray[Any]]] = MappingProxyType({}),
) -> FirstDifference | None:
    """The first difference between decisions on events `first`, `first + 1`, …, and between more columns, (n,) each."""
    found: list[FirstDifference] = []
    own = {field: (getattr(hardware, field), getattr(model, field)) for field in ("owner", "rel_x", "rel_y")}
    for field, (theirs, ours) in {**own, **columns}.items():
        if not np.array_equal(theirs, ours):
            i = int(np.flatnonzero(theirs != ours)[0])
            found.append(FirstDifference(first + i, field, int(theirs[i]), int(ours[i])))
    of_records = _record_difference(hardware.records, model.records)
    found += [] if of_records is None else [of_records]
    return min(found, key=lambda entry: entry.event_index) if found else None


def _record_difference(hardware: NDArray[np.void], model: NDArray[np.void]) -> FirstDifference | None:
    words = hardware.dtype.itemsize // 8
    both = min(len(hardware), len(model))
    theirs = hardware.view("<u8").reshape(-1, words)[:both]
    ours = model.view("<u8").reshape(-1, words)[:both]
    if not np.array_equal(theirs, ours):
        i = int(np.flatnonzero((theirs != ours).any(axis=1))[0])
        field = next(name for name in hardware.dtype.names or () if hardware[i][name] != model[i][name])
        index = int(min(hardware[i]["seq"], model[i]["seq"]))
        return FirstDifference(index, f"record.{field}", int(hardware[i][field]), int(model[i][field]))
    if len(hardware) != len(model):
        extra = (hardware if len(hardware) > both else model)[both]
        return FirstDifference(int(extra["seq"]), "records", f"{len(hardware)} records", f"{len(model)} records")
    return None


def dump_window(
    events: Events,
    config: CotConfig | MotionConfig,
    path: Path,
    first_event: int,
    last_event: int,
    *,
    stalls: Stalls | None = None,
    model: BuiltModel | None = None,
    progress: Callable[[int], None] | None = None,
    force: bool = False,
) -> Clocks:
    """Run the hardware again on the same chunks of events and dump the clocks around a window of events to a VCD.

    Every clock is as it was in a `Lockstep` with the same arguments, up to the end of the window. Returns the clocks at which
    events were accepted and records sent.

    Args:
        path: of the VCD; `force` replaces one that exists.
        first_event, last_event: numbers of the events around which clocks are dumped.
        model: a model with all signals that `build_device` returned for the same config, to avoid the look-up.
        progress: called with the number of events driven so far.

    Raises:
        OutputError: the file exists, or cannot be written.
        ToolchainError: a tool is missing or too old, or the build fails.
    """
    device = Device(config, stalls=stalls, model=model)
    parts = []
    with device.dumping(path, first_event, last_event, force=force):
        for chunk in chunks(events):
            if device.seq > last_event:
                break
            try:
                decided, times = device.stream_timed(chunk)
            except HardwareError:
                break  # the waveform up to the fault is kept
            parts.append(Clocks(times.accepted, decided.records, times.recorded))
            if progress is not None:
                progress(device.seq)
    return Clocks(*(np.concatenate(column) for column in zip(*parts, strict=True))) if parts else Clocks.none()


class Clocks(NamedTuple):
    """Clocks of handshakes: (n,) clocks at which events 0, 1, … were accepted; (m,) records of dtype `contract.RECORD` and
    the clocks at which they were sent."""

    accepted: NDArray[np.int64]
    records: NDArray[np.void]
    recorded: NDArray[np.int64]

    @classmethod
    def none(cls) -> Clocks:
        """Empty, for no events."""
        return cls(np.empty(0, np.int64), np.empty(0, RECORD), np.empty(0, np.int64))
