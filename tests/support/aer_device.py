# SPDX-License-Identifier: Apache-2.0
"""A compiled AER port and an asynchronous chip on it: delays below a clock, skewed wires, metastable flip-flops."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pyverilator import PyVerilator

from evcot_cosim.devices.base import Drive, Ending, HardwareError, pattern_fields, pointer, reset
from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, build

__all__ = ["STEPS_PER_CLOCK", "AerDevice", "AerRun", "Chip"]

STEPS_PER_CLOCK = 1000


class _Status(Ending):
    """How a run ended."""

    DONE = ""
    STUCK = "stands still"
    INVENTED = "gave more than it got"
    WITHDRAWN = "withdrew or changed what it showed, before it was taken"
    ACKNOWLEDGED_NOTHING = "acknowledged where there was no request"
    TAKEN_BACK = "took its signal back before the other side had answered"
    REQUESTED_EARLY = "requested while the acknowledge before was still there"
    TOO_SOON = "requested before its word had stood long enough"


_DRIVE = Drive(
    "evcot_aer",
    "aer.cpp.j2",
    {
        "words": "const uint64_t*",
        "n": "int64_t",
        "next": "int64_t",
        # the chip: maximum delays in steps
        "gap": "int64_t",
        "react": "int64_t",
        "skew": "int64_t",
        "setup": "int64_t",  # for a receiver in clocks: how long the word must be stable before the request
        "window": "int64_t",
        "active_low": "int64_t",
        **pattern_fields("go"),  # for the stream on the clocked side
        # results
        "events": "uint64_t*",
        "n_out": "int64_t",
        "request_at": "int64_t*",
        "accepted": "int64_t*",
        "cycle": "int64_t",
        "noise": "uint64_t",
    },
    _Status,
    package="support",
)


@dataclass(frozen=True)
class Chip:
    """Timing of the other side of the port: maximum random delays, in steps of a thousandth of a clock.

    Attributes:
        gap: from the end of a handshake to the next word.
        react: from a signal's edge to the response.
        skew: between the wires of a word.
        setup: for a sender, from the last wire of a word to the request; for a receiver, the clocks a word must be stable.
        window: a flip-flop that samples a wire closer than this to its change gets either value.
    """

    gap: int = 0
    react: int = 0
    skew: int = 0
    setup: int = 0
    window: int = 0


class AerRun(NamedTuple):
    """Results of a run.

    Attributes:
        out: with a sender, the events (t, x, y, p), (n, 4) uint64, t in clocks; with a receiver, the words it received, (n,).
        request_at: (n,) int64, the step of each request of a sender, or the clock at which each word to send was accepted.
        clocks: duration of the run.
    """

    out: NDArray[np.uint64]
    request_at: NDArray[np.int64]
    clocks: int


class AerDevice:
    """`aer_in` with a sender, or `aer_out` with a receiver; `device.sim.io` has its other ports.

    Raises:
        ToolchainError: the module cannot be built.
    """

    def __init__(
        self,
        top: Literal["aer_in", "aer_out"],
        parameters: Mapping[str, int],
        *,
        ports: Mapping[str, int] | None = None,
        verilog: Path | None = None,
    ) -> None:
        self.top = top
        self.sends = top == "aer_in"
        drive = {"aer.cpp": _source(top, parameters)}
        self.model = build(top, parameters, drive, extra_flags=PORTS_ONLY_FLAGS, verilog=verilog)
        self.sim: PyVerilator = self.model.load()
        self._words_are = 2 if self.sends else 5
        for port, value in (ports or {}).items():
            self.sim.io[port] = value
        self._rest()
        reset(self.sim)
        self.cycle = 0

    def _rest(self) -> None:
        """Put the chip's signal to its idle level."""
        self.sim.io["aer_req" if self.sends else "aer_ack"] = int(self.sim.io.active_low)

    def reset(self, **ports: int) -> None:
        """Reset the hardware with these settings."""
        for port, value in ports.items():
            self.sim.io[port] = value
        self._rest()
        reset(self.sim)

    def run(self, words: ArrayLike, chip: Chip, seed: int, pattern: NDArray[np.uint8] | None = None) -> AerRun:
        """Transfer all words and wait until there is no more activity.

        Args:
            words: for a sender (data, row), (n, 2); for a receiver (kind, slot, x, y, p), (n, 5).
            pattern: stalls of the stream on the clocked side, one byte per clock: 1 goes, 0 stalls.

        Raises:
            HardwareError: it broke the protocol, or made no progress.
        """
        table = np.ascontiguousarray(np.asarray(words, np.uint64).reshape(-1, self._words_are))
        n = len(table)
        out = np.zeros((n + 1, 4) if self.sends else n + 1, np.uint64)
        moments = np.zeros(n, np.int64)
        job = _DRIVE.job(
            words=pointer(table), n=n, gap=chip.gap, react=chip.react, skew=chip.skew, setup=chip.setup, window=chip.window,
            active_low=int(self.sim.io.active_low),
            go_pattern=pointer(pattern), go_length=0 if pattern is None else len(pattern),
            events=pointer(out), request_at=pointer(moments), accepted=pointer(moments), cycle=self.cycle,
            noise=(0x9E3779B97F4A7C15 * (2 * seed + 1)) & ((1 << 64) - 1),
        )  # fmt: skip
        status = _DRIVE.call(self.sim, job)
        lasted, self.cycle = job.cycle - self.cycle, job.cycle
        if status != _Status.DONE:
            raise HardwareError(f"{self.top} {status.fault}, at word {job.next} (clock {job.cycle})", job.next)
        return AerRun(out[: job.n_out], moments, lasted)


def _source(top: str, parameters: Mapping[str, int]) -> str:
    """C++ text of the drive."""
    return _DRIVE.source(
        top,
        sends=top == "aer_in",
        data_bits=parameters["X_W"] + parameters["Y_W"] + 1,
        time_mask=(1 << parameters.get("T_W", 48)) - 1,
        steps_per_clock=STEPS_PER_CLOCK,
    )
