# SPDX-License-Identifier: Apache-2.0
"""The compiled tracker as a Python object, driven interactively cycle by cycle, or by streams of events."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pyverilator import PyVerilator

from evcot.errors import OutputError
from evcot.events import Events
from evcot.filters.contract import FILTER_REGISTERS, FILTER_SHAPE_RANGES, mask_word
from evcot.filters.registers import FilterRegisters
from evcot.hardware.config import CotConfig, HardwareConfig, MotionConfig, SlotConfig
from evcot.hardware.contract import RECORD, REGISTERS, Shape
from evcot.hardware.model import Decisions
from evcot.hardware.motion.contract import MOTION_RECORD, MotionRegisters
from evcot.hardware.registers import motion_addresses, register_map
from evcot.outputs import path_written_aside
from evcot.ticks import TickCounter, TickedEvents
from evcot.tracks.log import Kind

from ..rtl.build import PORTS_ONLY_FLAGS, BuiltModel, build
from .base import HardwareError, Stalls, check_waits, pointer, reset
from .driver import DRIVE, MOTION_DRIVE, PARAMETERS, UNDECIDED, Status, saving_source, source

__all__ = ["Device", "DeviceState", "StreamTimes", "build_device", "order_of", "step_clocks"]

_FILTERED = "cot_filtered"  # the module with filters in front of a tracker
# The fields of a shape that cot_motion.v has as parameters.
_MOTION_PARAMETERS = frozenset({"n_slots", "x_w", "y_w", "tick_w", "radix_w", "sup_w", "id_w", "seq_w", "time_w"})
_SETTLE_CLOCKS = 1 << 24  # more than any filter's memory needs to become empty
_FOREVER = (1 << 63) - 1
_NO_EVENTS = TickedEvents(np.empty(0, np.int64), np.empty(0, np.uint16), np.empty(0, np.uint16), np.empty(0, np.uint8))
# More than a motion step takes: docs/motion.md.
_SLOT_CLOCKS = 300  # of each slot that lives, with a merge
_PAIR_CLOCKS = 60  # and each other one that it is compared with


class StreamTimes(NamedTuple):
    """Clocks at which events were accepted, (n,) int64, and records were sent, (m,) int64."""

    accepted: NDArray[np.int64]
    recorded: NDArray[np.int64]


class DeviceState(NamedTuple):
    """What `Device.state` returns: ticks, events and clocks so far, the counter of ticks, and the simulation's own state."""

    now: int
    seq: int
    cycle: int
    clock: TickCounter
    model: bytes


def build_device(
    config: CotConfig | MotionConfig,
    *,
    waves: bool = True,
    savable: bool = False,
    verilog: Path | None = None,
    gates: bool = False,
    on_miss: Callable[[], None] | None = None,
) -> BuiltModel:
    """Build the module of a configuration in its shape, with its streaming drive, or find it in the cache.

    Without `waves` a waveform shows the ports of the module alone. Verilator then optimises the signals below it away, and
    the model is built sooner.

    Args:
        waves: whether waveforms show what lies below the ports.
        savable: whether the state of a simulation can be saved and restored.
        verilog: the folder of the RTL; None: that of this checkout or package.
        gates: there is a netlist in it, whose cells change at other signals than the clock.
        on_miss: called before a build that takes seconds.

    Raises:
        ConfigError: `config` is no configuration of hardware.
        ToolchainError: a tool is missing or too old, or the build fails.
    """
    HardwareConfig.check_type(config)
    shape, motion = config.shape, isinstance(config, MotionConfig)
    parameters = {
        verilog_name: getattr(shape, name)
        for name, verilog_name in PARAMETERS.items()
        if not motion or name in _MOTION_PARAMETERS
    }
    module: str = config.module
    if motion:
        parameters["OWNERS"] = 1
    if module == "cot":
        del parameters["N"]
    elif config.filtered:
        parameters |= {name.upper(): getattr(config.filter_shape, name) for name in FILTER_SHAPE_RANGES}
        parameters["HAS"] = config.filters.enable
        parameters["TRACKER"] = register_map().trackers.index(module.removeprefix("cot_"))
        module = _FILTERED
    drive = {"stream.cpp": source(module, shape, motion, gates)}
    flags: tuple[str, ...] = ("--trace-max-array", "64") if waves else PORTS_ONLY_FLAGS
    if savable:
        drive |= {"save.cpp": saving_source(module)}
        flags += ("--savable",)
    return build(module, parameters, drive, extra_flags=flags, verilog=verilog, on_miss=on_miss)


class Device:
    """One simulated tracker: the module of its configuration.

    Interactive: `device.sim.io.<port>` reads and writes ports, `device.sim.clock.tick()` runs one clock, about 10^4 per second.
    Streaming: `stream` passes NumPy arrays through a C++ loop with the GIL released. Both drive the same hardware and give
    the same decisions.

    Args:
        config: module, shape and registers; written to the hardware on construction.
        stalls: patterns for the streaming drive.
        model: a model that `build_device` returned for the same config, to avoid the look-up.
        waves: see `build_device`; without a `model`.

    Attributes:
        visible: as of the golden model: whether a visible slot of cot_motion owns each event that was streamed last.

    Raises:
        ConfigError, ToolchainError.
    """

    def __init__(
        self,
        config: CotConfig | MotionConfig,
        *,
        stalls: Stalls | None = None,
        model: BuiltModel | None = None,
        waves: bool = True,
        verilog: Path | None = None,
    ) -> None:
        HardwareConfig.check_type(config)
        self.config = config
        self.stalls = stalls or Stalls()
        self.model = model or build_device(config, waves=waves, verilog=verilog)
        self.sim: PyVerilator = self.model.load()
        library = self.sim.lib
        library.evcot_settle.argtypes = (ctypes.c_void_p, ctypes.c_int64)
        library.evcot_open_vcd.argtypes = (ctypes.c_void_p, ctypes.c_char_p, ctypes.POINTER(ctypes.c_void_p))
        library.evcot_close_vcd.argtypes = (ctypes.c_void_p,)
        self._vcd: int | None = None
        self._vcd_window = (0, _FOREVER)
        self.reset()

    @property
    def shape(self) -> Shape:
        """Elaboration parameters of the hardware."""
        return self.config.shape

    def reset(self) -> None:
        """Reset the hardware and write all registers: tick 0, event 0, no track born."""
        reset(self.sim)
        self.now = 0
        self.seq = 0
        self.cycle = 0
        self.visible = np.zeros(0, np.bool_)
        self._clock = TickCounter(self.config.tick_us)
        if isinstance(self.config, MotionConfig):
            self._write_motion(self.config.registers)
            for slot, mode in enumerate(self.config.modes):
                self._write_mode(slot, mode)
        else:
            for slot, registers in enumerate(self.config.slots):
                self._write_slot(slot, registers)
        self._unfinished = False
        self._early: list[tuple[NDArray[np.void], NDArray[np.int64]]] = []  # records before the next stream's, and their clocks
        if self.config.filtered:
            self._settle()
            self.write_filters(self.config.filters)
        self._settle()

    def write_registers(self, slot: int, registers: SlotConfig) -> None:
        """Write one slot's registers through the register port, `mode` last: that restarts the slot.

        A restart goes on for some clocks after the write. The next write waits for its end; the records of tracks that end by
        it are among those that the next `stream` returns. Not for cot_motion, see `write_mode`.
        """
        self._finish_write()
        self._write_slot(slot, registers)

    def write_mode(self, slot: int, mode: int) -> None:
        """Write the mode of a slot of cot_motion, which restarts the slot; see `write_registers`."""
        self._finish_write()
        self._write_mode(slot, mode)

    def _finish_write(self) -> None:
        if self._unfinished:
            decisions, times = self._stream(_NO_EVENTS, np.empty(0, np.int64))
            self._early = [(decisions.records, times)]
        self._unfinished = True

    def _write_slot(self, slot: int, registers: SlotConfig) -> None:
        if self.config.module != "cot":
            self.sim.io.cfg_slot = slot
        names = sorted(REGISTERS, key="mode".__eq__)
        self._write([(REGISTERS[name].address, int(getattr(registers, name))) for name in names])

    def _write_mode(self, slot: int, mode: int) -> None:
        self.sim.io.cfg_slot = slot
        self._write([(motion_addresses()["mode"], int(mode))])

    def _write_motion(self, registers: MotionRegisters) -> None:
        addresses = motion_addresses().items()
        self._write([(address, int(getattr(registers, name))) for name, address in addresses if name != "mode"])

    def _write(self, writes: list[tuple[int, int]], port: str = "cfg") -> None:
        io = self.sim.io
        io[f"{port}_valid"] = 1
        for address, value in writes:
            io[f"{port}_addr"], io[f"{port}_data"] = address, value
            self.sim.clock.tick()
        io[f"{port}_valid"] = 0

    def write_filters(self, registers: FilterRegisters) -> None:
        """Write the registers of the filters in front, `enable` last."""
        writes = [(FILTER_REGISTERS["mask"].address, mask_word(x, y)) for x, y in registers.hot_pixels]
        for name in sorted(FILTER_REGISTERS.keys() - {"mask"}, key="enable".__eq__):
            writes.append((FILTER_REGISTERS[name].address, int(getattr(registers, name))))
        self._write(writes, "filter_cfg")

    def _settle(self) -> None:
        if not self.sim.lib.evcot_settle(self.sim.model, _SETTLE_CLOCKS):
            raise HardwareError(f"{self.config.module} is not idle {_SETTLE_CLOCKS} clocks after reset", self.seq)

    @contextmanager
    def dumping(self, path: Path, first_event: int = 0, last_event: int = _FOREVER, *, force: bool = False) -> Iterator[None]:
        """Context in which the streaming drive dumps the clocks around events `first_event` to `last_event` to a VCD.

        A clock is 10 time units, with the rising edge at 5. The file appears under its name when it is complete; an existing
        file is replaced only with `force`.
        """
        library, handle = self.sim.lib, ctypes.c_void_p()
        with path_written_aside(path, force=force) as aside:
            error = library.evcot_open_vcd(self.sim.model, os.fsencode(aside), ctypes.byref(handle))
            try:
                self._vcd, self._vcd_window = handle.value, (first_event, last_event)
                if not error:
                    yield
            finally:
                self._vcd = None
                error = library.evcot_close_vcd(handle) or error
            if error:
                raise OutputError(f"{path}: cannot be written: {os.strerror(error)}") from OSError(error, os.strerror(error))

    def state(self) -> DeviceState:
        """Everything that a run of events leaves behind; the model must have been built with `savable`, and be idle."""
        save = self.sim.lib.evcot_save
        save.argtypes, save.restype = (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64), ctypes.c_int64
        saved = np.empty(save(self.sim.model, None, 0), np.uint8)
        save(self.sim.model, pointer(saved), len(saved))
        return DeviceState(self.now, self.seq, self.cycle, self._clock, saved.tobytes())

    def restore(self, state: DeviceState) -> None:
        """Continue from a state of a device with the same model and stalls."""
        restore = self.sim.lib.evcot_restore
        restore.argtypes, restore.restype = (ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int64), None
        restore(self.sim.model, state.model, len(state.model))
        self.now, self.seq, self.cycle, self._clock = state.now, state.seq, state.cycle, state.clock

    def stream(self, events: Events | TickedEvents, keep: NDArray[np.bool_] | None = None) -> Decisions:
        """Drive a run of events through the hardware and wait until it is idle again.

        Args:
            events: with addresses below 2^x_w and 2^y_w. Times in microseconds become ticks of the configuration's `tick_us`,
                the first such event since reset being at tick 0; a device takes either microseconds or ticks until its reset.
            keep: (n,) bool, for a chain or an array: the events that a filter in front let pass. None: all.

        Raises:
            HardwareError: an event was lost, repeated, reordered or changed, or there was no progress.
            RecordingError: a wait between two events would take too many clocks: see `silence`. Nothing was driven.
        """
        return self._stream(events, None, keep)[0]

    def stream_timed(self, events: Events | TickedEvents) -> tuple[Decisions, StreamTimes]:
        """As `stream`; also returns the clocks at which events were accepted and records sent."""
        accepted = np.zeros(len(events), np.int64)
        decisions, recorded = self._stream(events, accepted)
        return decisions, StreamTimes(accepted, recorded)

    def _stream(
        self, events: Events | TickedEvents, accepted: NDArray[np.int64] | None, keep: NDArray[np.bool_] | None = None
    ) -> tuple[Decisions, NDArray[np.int64]]:
        n = len(events)
        ticked = self._clock.count(events) if isinstance(events, Events) else events
        check_waits(ticked.ticks, self.now, (1 << self.shape.tick_w) - 1, self.seq)
        keep = None if keep is None else ticked.mask(keep)
        owner = np.full(n, UNDECIDED, np.int16)
        rel_x, rel_y = np.zeros(n, np.uint16), np.zeros(n, np.uint16)  # stay 0 for events dropped by a filter
        self.visible = np.zeros(n, np.bool_)
        patterns = self.stalls
        motion = isinstance(self.config, MotionConfig)
        drive, record = (MOTION_DRIVE, MOTION_RECORD) if motion else (DRIVE, RECORD)
        job = drive.job(
            n=n, ticks=pointer(ticked.ticks), x=pointer(ticked.x), y=pointer(ticked.y), p=pointer(ticked.p), keep=pointer(keep),
            first_seq=self.seq,
            in_pattern=pointer(patterns.source), in_length=len(patterns.source),
            cm_pattern=pointer(patterns.cm), cm_length=len(patterns.cm),
            own_pattern=pointer(patterns.own), own_length=len(patterns.own),
            pass_pattern=pointer(patterns.passed), pass_length=len(patterns.passed),
            owner=pointer(owner), rel_x=pointer(rel_x), rel_y=pointer(rel_y),
            visible=pointer(self.visible.view(np.uint8)), accept_cycle=pointer(accepted),
            now=self.now, began=self.now, cycle=self.cycle, step_clocks=self._step_clocks(ticked.ticks),
            vcd=self._vcd, vcd_from=self._vcd_window[0], vcd_to=self._vcd_window[1],
        )  # fmt: skip
        self._unfinished = False
        records: list[NDArray[np.void]] = []
        recorded: list[NDArray[np.int64]] = []
        status = Status.RECORDS_FULL
        # An event starts or moves one track; a track ends once, by a merge (two records) or by its lifetime (one).
        # With motion each step moves every slot, so that there is no such limit.
        most = _FOREVER if motion else 3 * n + 2 * self.shape.n_slots
        while status == Status.RECORDS_FULL:
            if sum(map(len, records)) > most:
                raise HardwareError(f"{self.config.module} sends more records than {n} events can cause", self.seq + job.next)
            room = np.zeros(max(1024, n // 4), record)
            clocks = None if accepted is None else np.zeros(len(room), np.int64)
            job.records, job.record_capacity, job.n_records = pointer(room), len(room), 0
            job.record_cycle = pointer(clocks)
            status = drive.call(self.sim, job)
            records.append(room[: job.n_records])
            if clocks is not None:
                recorded.append(clocks[: job.n_records])
        self.now, self.cycle, self.seq = job.now, job.cycle, self.seq + job.next
        if status != Status.DONE:
            raise HardwareError(f"{self.config.module} {status.fault} {job.fault_seq} (clock {job.cycle})", job.fault_seq)
        joined = records[0] if len(records) == 1 else np.concatenate(records)
        order = order_of(joined) if self.config.module == "cot_chain" else slice(None)
        joined, times = joined[order], np.concatenate(recorded)[order] if recorded else np.empty(0, np.int64)
        if self._early:
            early, self._early = [*self._early, (joined, times)], []
            joined = np.concatenate([found for found, _ in early])
            times = np.concatenate([clocks for _, clocks in early]) if recorded else times
        return Decisions(joined, owner, rel_x, rel_y), times

    def _step_clocks(self, ticks: NDArray[np.int64]) -> int:
        """The most clocks that motion steps take in the longest wait: in each, every slot may be compared with all others."""
        if not isinstance(self.config, MotionConfig):
            return 0
        wait = int(np.diff(ticks, prepend=self.now).max(initial=0))
        return step_clocks(self.shape.n_slots, wait, self.config.registers.step_log2)


def step_clocks(slots: int, wait: int, step_log2: int) -> int:
    """The most clocks that cot_motion may take for the motion steps within so many ticks: see docs/motion.md."""
    return min((1 + (wait >> step_log2)) * slots * (_SLOT_CLOCKS + _PAIR_CLOCKS * slots), _FOREVER >> 1)


def order_of(records: NDArray[np.void]) -> NDArray[np.intp]:
    """Indices that sort records chronologically, however a chain's trackers are interleaved.

    LOST records come before the record of the event that follows them, sorted by time, then by slot.
    """
    return np.lexsort((records["slot"], records["time"], records["kind"] != Kind.LOST, records["seq"]))
