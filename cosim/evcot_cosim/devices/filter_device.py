# SPDX-License-Identifier: Apache-2.0
"""A compiled filter, or a chain of filters, as a Python object: streams tokens through it and returns the kept events."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pyverilator import PyVerilator

from evcot.ticks import TickedEvents

from ..rtl.build import PORTS_ONLY_FLAGS, build
from .base import Drive, Ending, HardwareError, Stalls, check_waits, pattern_fields, pointer

__all__ = ["FilterDevice", "FilterTimes"]

_SETTLED_WITHIN = 1 << 33  # clocks: more than the memory of the largest sensor takes to clear


class _Status(Ending):
    """Return codes of a streaming call."""

    DONE = ""
    STUCK = "stands still: no handshake for a million clocks, waiting at event"
    INVENTED = "gave a token that never went in, before event"
    TICKS_CHANGED = "changed the ticks at event"
    EVENT_CHANGED = "changed more than whether it stays, at event"
    WITHDRAWN = "withdrew or changed a token that waited to be taken, at event"


_DRIVE = Drive(
    "evcot_filter_stream",
    "filter.cpp.j2",
    {
        # events in
        "n": "int64_t",
        "ticks": "const int64_t*",
        "x": "const uint16_t*",
        "y": "const uint16_t*",
        "p": "const uint8_t*",
        "skip": "const uint8_t*",
        **pattern_fields("in", "out"),
        # decisions out
        "keep": "uint8_t*",
        # clocks of handshakes, or null
        "accept_cycle": "int64_t*",
        "give_cycle": "int64_t*",
        # state of the drive
        "tick_max": "int64_t",
        "now": "int64_t",
        "cycle": "int64_t",
        "fault": "int64_t",
    },
    _Status,
)


class FilterTimes(NamedTuple):
    """Clocks at which events were accepted and sent on, (n,) int64 each."""

    accepted: NDArray[np.int64]
    given: NDArray[np.int64]


class FilterDevice:
    """One simulated module with the token ports of a filter.

    Every output token is checked against the input: the same number of tokens in the same order with the same ticks, an
    event unchanged or dropped, a skipped event still skipped, and each token held until accepted.

    Args:
        top: name of the module.
        parameters: values for its Verilog parameters; the rest keep their defaults.
        ports: values of its configuration inputs, such as `enable`; `set` changes them.
        stalls: patterns of the streaming drive: `source` for the input, `passed` for the output.
        verilog: folder of the sources (default: evcot's own).

    Raises:
        ToolchainError: the module cannot be built.
        HardwareError: it does not become idle after reset.
    """

    def __init__(
        self,
        top: str,
        parameters: Mapping[str, int] | None = None,
        ports: Mapping[str, int] | None = None,
        *,
        stalls: Stalls | None = None,
        verilog: Path | None = None,
    ) -> None:
        self.top = top
        self.stalls = stalls or Stalls()
        self.model = build(top, parameters, {"filter.cpp": _DRIVE.source(top)}, extra_flags=PORTS_ONLY_FLAGS, verilog=verilog)
        self.sim: PyVerilator = self.model.load()
        library = self.sim.lib
        library.evcot_filter_settle.argtypes = (ctypes.c_void_p, ctypes.c_int64)
        library.evcot_filter_settle.restype = ctypes.c_int64
        self.set(**(ports or {}))
        self.reset()

    def set(self, **ports: int) -> None:
        """Set configuration inputs; the values stay."""
        for port, value in ports.items():
            self.sim.io[port] = value

    def reset(self) -> None:
        """Reset the hardware to tick 0 and wait until it is idle; `settled_after` is the number of clocks that took."""
        io = self.sim.io
        io.rst = 1
        self.sim.clock.tick()
        self.sim.clock.tick()
        io.rst = 0
        self.now = 0
        self.cycle = 0
        self.settled_after = self.settle()

    def settle(self) -> int:
        """Clock without input until the hardware is idle; returns how many clocks that took.

        Raises:
            HardwareError: it does not become idle.
        """
        clocks = int(self.sim.lib.evcot_filter_settle(self.sim.model, _SETTLED_WITHIN))
        if clocks < 0:
            raise HardwareError(f"{self.top} does not become idle", 0)
        return clocks

    def write(self, address: int, data: int) -> None:
        """Write one register through the port `cfg_valid`, `cfg_addr`, `cfg_data`."""
        io = self.sim.io
        io.cfg_valid, io.cfg_addr, io.cfg_data = 1, address, data
        self.sim.clock.tick()
        io.cfg_valid = 0

    def stream(self, events: TickedEvents, keep: NDArray[np.bool_] | None = None) -> NDArray[np.bool_]:
        """Drive a run of events through the hardware, wait until it is idle again, and return which of them stay, (n,).

        Args:
            events: with addresses below 2^X_W and 2^Y_W; long waits become tokens of ticks alone.
            keep: (n,) bool, what filters in front let stay; the others go in as skipped events. None: all.

        Raises:
            HardwareError: a token was lost, invented, changed or withdrawn, or there was no progress.
            RecordingError: a wait between two events would take too many clocks: see `silence`. Nothing was driven.
        """
        return self._stream(events, keep, None)

    def stream_timed(
        self, events: TickedEvents, keep: NDArray[np.bool_] | None = None
    ) -> tuple[NDArray[np.bool_], FilterTimes]:
        """As `stream`, with the clocks at which events were taken and handed on."""
        times = FilterTimes(np.zeros(len(events), np.int64), np.zeros(len(events), np.int64))
        return self._stream(events, keep, times), times

    def _stream(self, events: TickedEvents, keep: NDArray[np.bool_] | None, times: FilterTimes | None) -> NDArray[np.bool_]:
        n = len(events)
        tick_max = (1 << int(self.sim.io["s_tick"].signal.width)) - 1
        check_waits(events.ticks, self.now, tick_max)
        skip = np.zeros(n, np.bool_) if keep is None else ~events.mask(keep)
        stays = np.zeros(n, np.bool_)
        job = _DRIVE.job(
            n=n, ticks=pointer(events.ticks), x=pointer(events.x), y=pointer(events.y), p=pointer(events.p), skip=pointer(skip),
            in_pattern=pointer(self.stalls.source), in_length=len(self.stalls.source),
            out_pattern=pointer(self.stalls.passed), out_length=len(self.stalls.passed),
            keep=pointer(stays), accept_cycle=pointer(times and times.accepted), give_cycle=pointer(times and times.given),
            tick_max=tick_max, now=self.now, cycle=self.cycle,
        )  # fmt: skip
        status = _DRIVE.call(self.sim, job)
        self.now, self.cycle = job.now, job.cycle
        if status != _Status.DONE:
            raise HardwareError(f"{self.top} {status.fault} {job.fault} (clock {job.cycle})", job.fault)
        return stays
