# SPDX-License-Identifier: Apache-2.0
"""Base of the streaming drives: C++ loops in the shared object of a model, each called with one structure of pointers.

A drive defines the fields of that structure and the return codes of a call; the C++ side is rendered from the same tables.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, Generic, Self, TypeVar

import numpy as np
from numpy.typing import NDArray
from pyverilator import PyVerilator

from evcot.errors import ConfigError, EvcotError, RecordingError
from evcot.events import check_pixels
from evcot.hardware.config import HardwareConfig
from evcot.recordings.formats.source import Sensor
from evcot.templating import templates

__all__ = [
    "SILENT_CLOCKS_MAX",
    "Drive",
    "Ending",
    "HardwareError",
    "Layout",
    "Pattern",
    "Stalls",
    "check_addresses",
    "check_silence",
    "check_waits",
    "pattern_fields",
    "pointer",
    "reset",
    "structure",
]


Pattern = NDArray[np.uint8]
"""A stall pattern, repeated periodically: one byte per clock, 1 lets the stream go, 0 stalls it; empty never stalls."""

Layout = Mapping[str, str]
"""The fields of a structure that Python and C++ share, in order: name -> C type."""

_PACKAGE = "evcot_cosim.devices"
_INTEGERS = {"int64_t": ctypes.c_int64, "uint64_t": ctypes.c_uint64}
_NO_STALL = np.zeros(0, np.uint8)


class HardwareError(EvcotError, RuntimeError):
    """The hardware violated its stream protocol: it lost, repeated, reordered or changed an event, or made no progress.

    Attributes:
        seq: sequence number of the event or word.
    """

    def __init__(self, message: str, seq: int) -> None:
        super().__init__(message)
        self.seq = seq


class Ending(IntEnum):
    """Return codes of a drive, numbered in order; `fault` describes the fault in messages.

    The first member means success.
    """

    fault: str

    def __new__(cls, fault: str = "") -> Self:
        member = int.__new__(cls, len(cls.__members__))
        member._value_ = len(cls.__members__)
        member.fault = fault
        return member


def structure(layout: Layout) -> type[ctypes.Structure]:
    """The ctypes structure of a layout."""

    class Shared(ctypes.Structure):
        _fields_ = [(name, ctypes.c_void_p if ctype.endswith("*") else _INTEGERS[ctype]) for name, ctype in layout.items()]

    return Shared


def pattern_fields(*streams: str) -> dict[str, str]:
    """The fields for stall patterns: for each stream the pattern and its length in clocks."""
    return {
        f"{stream}_{name}": ctype
        for stream in streams
        for name, ctype in (("pattern", "const uint8_t*"), ("length", "int64_t"))
    }


def pointer(array: NDArray[Any] | None) -> int | None:
    """Address of an array's data, for a field that is a pointer."""
    return None if array is None else array.ctypes.data


E = TypeVar("E", bound=Ending)


class Drive(Generic[E]):
    """One streaming drive: its C++ function and the structure passed to it.

    Args:
        function: name of the C++ function, which takes the model and the structure `Job` and returns one of `endings`.
        template: the template in `templates/` from which it is rendered.
        job: fields of `Job`, the arguments and results of a call.
        endings: return codes.
        structures: further structures shared by C++ and Python, by their names in C++.
        package: the package whose `templates/` holds the template.
    """

    def __init__(
        self,
        function: str,
        template: str,
        job: Layout,
        endings: type[E],
        *,
        structures: Mapping[str, Layout] | None = None,
        package: str = _PACKAGE,
    ) -> None:
        self._function = function
        self._template = template
        self._structures = {**(structures or {}), "Job": job}
        self._endings = endings
        self._package = package
        self.job = structure(job)

    def source(self, top: str, **values: Any) -> str:
        """C++ text of the drive for one top module; `values` are further variables of its template."""
        template = templates(self._package, _PACKAGE).get_template(self._template)
        return template.render(top=top, structures=self._structures, endings=list(self._endings), **values)

    def call(self, sim: PyVerilator, job: ctypes.Structure) -> E:
        """Call the drive with the GIL released; returns its return code."""
        function = sim.lib[self._function]
        function.argtypes = (ctypes.c_void_p, ctypes.c_void_p)
        function.restype = ctypes.c_int
        return self._endings(function(sim.model, ctypes.addressof(job)))


@dataclass(frozen=True)
class Stalls:
    """Stall patterns, one per stream; each is empty or holds at least one 1."""

    source: Pattern = field(default_factory=lambda: _NO_STALL)
    cm: Pattern = field(default_factory=lambda: _NO_STALL)
    own: Pattern = field(default_factory=lambda: _NO_STALL)
    passed: Pattern = field(default_factory=lambda: _NO_STALL)

    def __post_init__(self) -> None:
        for name in ("source", "cm", "own", "passed"):
            pattern = np.ascontiguousarray(getattr(self, name), np.uint8)
            if len(pattern) and not pattern.any():
                raise ConfigError(f"stalls.{name}: never goes: a pattern must hold at least one 1")
            object.__setattr__(self, name, pattern)

    @classmethod
    def random(cls, rng: np.random.Generator, go: tuple[float, float, float, float] | None = None) -> Stalls:
        """Independent patterns of different lengths; `go` is each stream's probability of a 1 (default: random, 0.15 to 1)."""
        chances = rng.uniform(0.15, 1.0, 4) if go is None else go
        patterns = []
        for chance, length in zip(chances, (4093, 4091, 4079, 4073), strict=True):
            pattern = (rng.random(length) < chance).astype(np.uint8)
            pattern[rng.integers(length)] = 1
            patterns.append(pattern)
        return cls(*patterns)

    @classmethod
    def seeded(cls, seed: int | None) -> Stalls:
        """Random patterns on every stream, or none without a seed."""
        return cls() if seed is None else cls.random(np.random.default_rng(seed))


def reset(sim: PyVerilator, clocks: int = 2) -> None:
    """Hold rst high for a number of clocks."""
    sim.io.rst = 1
    for _ in range(clocks):
        sim.clock.tick()
    sim.io.rst = 0


def check_addresses(sensor: Sensor, config: HardwareConfig, name: str) -> None:
    """Check that addresses in hardware, and memories of trackers and filters, reach every pixel of a sensor (width, height).

    Args:
        name: of what has this sensor, for the message.

    Raises:
        ConfigError: too few bits of an address.
        RecordingError: too many pixels.
    """
    check_pixels(*sensor)
    for name_w, bits, size in (("x_w", config.shape.x_w, sensor[0]), ("y_w", config.shape.y_w, sensor[1])):
        if size > 1 << bits:
            raise ConfigError(f"shape.{name_w} = {bits}: too few bits for {size} pixels of {name}")


# Limit on gaps between events for hardware: ticks without events cost clocks, and none of them may be left out.
#
# A token holds up to 2^TICK_W - 1 ticks, and a longer wait is driven as several tokens of one clock each. The results depend on
# every tick, and records carry the tick count, so a wait cannot be shortened without changing them: a wait of more than
# `SILENT_CLOCKS_MAX` clocks is refused before anything is driven.

SILENT_CLOCKS_MAX = 1 << 24  # seconds of simulation; 203 days of silence where a tick is a microsecond and TICK_W is 20


def _longest(times: NDArray[np.int64], before: int) -> tuple[int, int, int]:
    """The longest gap before one of at least one time: the index of the time after it, the time before it, its length."""
    steps = np.diff(times)
    at = int(steps.argmax()) + 1 if len(steps) else 0
    if not at or int(times[0]) - before >= int(steps[at - 1]):
        at, last = 0, before
    else:
        last = int(times[at - 1])
    return at, last, int(times[at]) - last


def check_silence(t_us: NDArray[np.int64], config: HardwareConfig, first_index: int = 0, before_us: int | None = None) -> None:
    """Raise RecordingError where a run of a recording's events, in time order, has a gap too long for hardware.

    Args:
        t_us: (n,) their times.
        config: gives the length of a tick and the number of ticks per token.
        first_index: number of the first event.
        before_us: time of the event before the first, if there is one.
    """
    if not len(t_us):
        return
    at, last_us, gap_us = _longest(t_us, int(t_us[0]) if before_us is None else before_us)
    clocks = gap_us // config.tick_us // ((1 << config.shape.tick_w) - 1)
    if clocks > SILENT_CLOCKS_MAX:
        raise RecordingError(
            f"event {first_index + at}: t = {t_us[at]} us follows t = {last_us} us: a gap of {gap_us / 1e6:g} s costs {clocks} "
            f"clocks: must be at most {SILENT_CLOCKS_MAX}; take a part without it (--from, --to), or a longer tick_us"
        )


def check_waits(ticks: NDArray[np.int64], now: int, tick_max: int, first_index: int = 0) -> None:
    """The same of ticks since reset, of which `now` have passed, where a token holds up to `tick_max`; none may run back."""
    if not len(ticks):
        return
    if int(ticks[0]) < now or bool((ticks[1:] < ticks[:-1]).any()):
        at = 0 if int(ticks[0]) < now else int(np.argmax(ticks[1:] < ticks[:-1])) + 1
        last = int(ticks[at - 1]) if at else now
        raise RecordingError(f"event {first_index + at}: tick {ticks[at]} follows tick {last}: time must not run back")
    at, last, gap = _longest(ticks, now)
    if gap // tick_max > SILENT_CLOCKS_MAX:
        raise RecordingError(
            f"event {first_index + at}: tick {ticks[at]} follows tick {last}: {gap // tick_max} clocks of silence: "
            f"must be at most {SILENT_CLOCKS_MAX}"
        )
