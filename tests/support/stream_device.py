# SPDX-License-Identifier: Apache-2.0
"""A compiled module with ready/valid streams as a Python object: arrays of words in and out, with optional stalls."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pyverilator import PyVerilator

from evcot_cosim.devices.base import Drive, Ending, HardwareError, Layout, Pattern, pattern_fields, pointer, reset, structure
from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, build

__all__ = ["Bundle", "StreamDevice", "StreamRun", "check_reset", "random_pattern", "random_stalls"]


class Bundle(NamedTuple):
    """The ports of one stream: `<prefix>valid`, `<prefix>ready` and `<prefix><field>`, each field up to 64 bits wide.

    AXI4-Stream: Bundle("s_axis_t", ("data", "keep", "last")).
    """

    prefix: str
    fields: tuple[str, ...]


class _Status(Ending):
    """How a streaming call ended."""

    DONE = ""
    FULL = ""  # call again with room for more words
    STUCK = "stands still"
    WITHDRAWN = "withdrew or changed word"


_INPUT: Layout = {
    "words": "const uint64_t*",
    "masks": "const uint64_t*",  # the bits of each field
    "n": "int64_t",
    "next": "int64_t",
    "holding": "int64_t",
    "clock": "int64_t*",  # at which each word was accepted
    **pattern_fields("go"),
}
_OUTPUT: Layout = {
    "words": "uint64_t*",
    "capacity": "int64_t",
    "n": "int64_t",
    "waits": "int64_t",
    "clock": "int64_t*",  # at which each word was sent
    **pattern_fields("go"),
}
_DRIVE = Drive(
    "evcot_words",
    "words.cpp.j2",
    {
        "inputs": "Input*",
        "outputs": "Output*",
        "clocks": "int64_t",  # length of the run; -1: until all words have been processed
        "clocks_done": "int64_t",
        "quiet_clocks": "int64_t",
        "cycle": "int64_t",
        "noise": "uint64_t",
        "fault_stream": "int64_t",
    },
    _Status,
    structures={"Input": _INPUT, "Output": _OUTPUT},
    package="support",
)
_Input, _Output = structure(_INPUT), structure(_OUTPUT)


@dataclass(frozen=True)
class StreamRun:
    """Results of one run, by stream.

    Attributes:
        words: output prefix -> (n, fields) uint64.
        given: output prefix -> (n,) int64, the clock at which the module sent each word.
        accepted: input prefix -> (n,) int64, the clock at which the module accepted each word.
        clocks: duration of the run.
    """

    words: Mapping[str, NDArray[np.uint64]]
    given: Mapping[str, NDArray[np.int64]]
    accepted: Mapping[str, NDArray[np.int64]]
    clocks: int


def random_pattern(rng: np.random.Generator, chance: float | None = None) -> Pattern:
    """A stall pattern that is 1 with this probability at every clock (default: a random one from 0.15 to 1)."""
    goes = rng.random(rng.integers(4000, 4100)) < (rng.uniform(0.15, 1) if chance is None else chance)
    pattern = goes.astype(np.uint8)
    pattern[rng.integers(len(pattern))] = 1
    return pattern


def random_stalls(rng: np.random.Generator, prefixes: Iterable[str]) -> dict[str, Pattern]:
    """A random pattern for each stream; about every fourth stream never stalls."""
    return {prefix: random_pattern(rng) for prefix in prefixes if rng.random() < 0.75}


class StreamDevice:
    """One simulated module with ready/valid streams, a `clk` and a synchronous `rst`.

    A valid word at an output must stay unchanged until it is accepted. While no word is valid at an input, its fields are
    random. `device.sim.io.<port>` reads and writes all other ports; written values stay.

    Args:
        top: name of the module.
        parameters: values for its Verilog parameters; the rest keep their defaults.
        inputs, outputs: its streams; either may be empty.
        ports: values of its other inputs.
        has_idle: whether a run ends when the output `idle` is high, or after `quiet_clocks` clocks without a handshake.
        verilog: folder of the sources (default: evcot's own).

    Attributes:
        stalls: prefix of a stream -> its pattern, one byte per clock, from the start again at the end: 1 goes, 0 stalls.
            Streams without one never stall.

    Raises:
        ToolchainError: the module cannot be built.
    """

    def __init__(
        self,
        top: str,
        parameters: Mapping[str, int] | None = None,
        *,
        inputs: Sequence[Bundle],
        outputs: Sequence[Bundle],
        ports: Mapping[str, int] | None = None,
        has_idle: bool = False,
        quiet_clocks: int = 64,
        verilog: Path | None = None,
    ) -> None:
        self.top, self.inputs, self.outputs = top, inputs, outputs
        self.stalls: Mapping[str, Pattern] = {}
        self._quiet_clocks = quiet_clocks
        drive = {"words.cpp": _DRIVE.source(top, inputs=inputs, outputs=outputs, has_idle=has_idle)}
        self.model = build(top, parameters, drive, extra_flags=PORTS_ONLY_FLAGS, verilog=verilog)
        self.sim: PyVerilator = self.model.load()
        self._masks = {bundle.prefix: self._field_masks(bundle) for bundle in inputs}
        self.set(**(ports or {}))
        self.reset()

    def set(self, **ports: int) -> None:
        """Set inputs that belong to no stream; the values stay."""
        for port, value in ports.items():
            self.sim.io[port] = value

    def reset(self) -> None:
        """Reset the hardware and the clock count."""
        reset(self.sim)
        self.cycle = 0

    def run(self, words: Mapping[str, ArrayLike] | None = None, *, clocks: int | None = None) -> StreamRun:
        """Drive words through the hardware until all have been processed, or for a number of clocks.

        Args:
            words: input prefix -> (n, fields) or, for one field, (n,) unsigned integers. Other inputs offer nothing.
            clocks: length of the run; None: until the inputs are exhausted and the module is empty. A word that is valid at
                an output when the clocks end stays valid; one at an input is withdrawn.

        Raises:
            HardwareError: a waiting word was withdrawn or changed, or there was no progress.
        """
        tables = {b.prefix: self._table(b, (words or {}).get(b.prefix, [])) for b in self.inputs}
        accepted = {prefix: np.full(len(table), -1, np.int64) for prefix, table in tables.items()}
        ins = (_Input * len(self.inputs))()
        for each, bundle in zip(ins, self.inputs, strict=True):
            table = tables[bundle.prefix]
            each.words, each.n = pointer(table), len(table)
            each.masks, each.clock = pointer(self._masks[bundle.prefix]), pointer(accepted[bundle.prefix])
            self._set_pattern(each, bundle)
        outs = (_Output * len(self.outputs))()
        for each, bundle in zip(outs, self.outputs, strict=True):
            self._set_pattern(each, bundle)
        made: dict[str, NDArray[np.uint64]] = {b.prefix: np.zeros((0, len(b.fields)), np.uint64) for b in self.outputs}
        given: dict[str, NDArray[np.int64]] = {b.prefix: np.zeros(0, np.int64) for b in self.outputs}
        job = _DRIVE.job(
            inputs=ctypes.addressof(ins), outputs=ctypes.addressof(outs), clocks=-1 if clocks is None else clocks,
            quiet_clocks=self._quiet_clocks, cycle=self.cycle, noise=0x9E3779B97F4A7C15 ^ self.cycle,
        )  # fmt: skip
        status = _Status.FULL
        while status == _Status.FULL:
            for out, bundle in zip(outs, self.outputs, strict=True):
                if out.n == out.capacity:
                    out.capacity = max(4096, 2 * out.capacity)
                    made[bundle.prefix] = _grown(made[bundle.prefix], out.capacity)
                    given[bundle.prefix] = _grown(given[bundle.prefix], out.capacity)
                    out.words, out.clock = pointer(made[bundle.prefix]), pointer(given[bundle.prefix])
            status = _DRIVE.call(self.sim, job)
        lasted, self.cycle = job.cycle - self.cycle, job.cycle
        taken = {bundle.prefix: each.next for each, bundle in zip(ins, self.inputs, strict=True)}
        if status == _Status.WITHDRAWN:
            out, bundle = outs[job.fault_stream], self.outputs[job.fault_stream]
            raise HardwareError(f"{self.top} {status.fault} {out.n} of {bundle.prefix} (clock {job.cycle})", out.n)
        if status == _Status.STUCK:
            raise HardwareError(f"{self.top} {status.fault} (clock {job.cycle}); words taken: {taken}", 0)
        n_made = {bundle.prefix: out.n for out, bundle in zip(outs, self.outputs, strict=True)}
        return StreamRun(
            {prefix: table[: n_made[prefix]] for prefix, table in made.items()},
            {prefix: clock[: n_made[prefix]] for prefix, clock in given.items()},
            {prefix: clock[: taken[prefix]] for prefix, clock in accepted.items()},
            lasted,
        )

    def _field_masks(self, bundle: Bundle) -> NDArray[np.uint64]:
        widths = [int(self.sim.io[bundle.prefix + field].signal.width) for field in bundle.fields]
        assert max(widths) <= 64, f"{bundle}: fields must have at most 64 bits"
        return np.array([(1 << width) - 1 for width in widths], np.uint64)

    def _table(self, bundle: Bundle, words: ArrayLike) -> NDArray[np.uint64]:
        table = np.ascontiguousarray(np.asarray(words, np.uint64).reshape(-1, len(bundle.fields)))
        assert not (table & ~self._masks[bundle.prefix]).any(), f"{bundle.prefix}: a value has more bits than its port"
        return table

    def _set_pattern(self, stream: Any, bundle: Bundle) -> None:
        pattern = self.stalls.get(bundle.prefix)
        if pattern is not None and len(pattern):
            assert pattern.any(), f"{bundle.prefix}: never goes: a pattern must hold at least one 1"
            stream.go_pattern, stream.go_length = pointer(pattern), len(pattern)


def check_reset(device: StreamDevice, words: Mapping[str, ArrayLike], clocks: int = 100) -> None:
    """A reset of one clock, at any moment of traffic and of stalls, leaves nothing of what was inside to come out.

    Args:
        words: traffic, as of `StreamDevice.run`.
        clocks: the latest moment of the reset.

    Raises:
        AssertionError: a word came out after the reset.
    """
    rng, sim = np.random.default_rng(1), device.sim
    for _ in range(60):
        device.reset()
        device.stalls = {bundle.prefix: random_pattern(rng) for bundle in (*device.inputs, *device.outputs)}
        device.run(words, clocks=int(rng.integers(1, clocks)))
        for bundle in device.outputs:
            sim.io[f"{bundle.prefix}ready"] = int(rng.integers(2))
        sim.io.rst = 1
        sim.clock.tick()
        sim.io.rst = 0
        left = {prefix: len(rest) for prefix, rest in device.run().words.items()}
        assert not any(left.values()), left


def _grown(array: NDArray[Any], length: int) -> NDArray[Any]:
    larger = np.zeros((length, *array.shape[1:]), array.dtype)
    larger[: len(array)] = array
    return larger
