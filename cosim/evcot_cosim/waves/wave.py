# SPDX-License-Identifier: Apache-2.0
"""A VCD file as signals that are looked up by name and sampled on a clock."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from fnmatch import fnmatchcase
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import VcdError
from .expr import Expr
from .vcd import Declared, Signal, declared, left_out, read

__all__ = ["Samples", "Wave"]

_NEAR = 5


class Wave:
    """The waveform in a VCD file.

    Attributes:
        path: the file.
        signals: all signals declared in the header.
        timescale: unit of the times.
        end_time: the last time in the file.
    """

    def __init__(self, path: Path, only: Sequence[str] = ("*",)) -> None:
        self.path = path
        self.signals: tuple[Declared, ...] = declared(path)
        wanted = [entry for entry in self.signals if any(_matches(entry.path, glob) for glob in only)]
        if not wanted:
            raise VcdError(f"{path}: no signal matches {', '.join(only)}")
        self._changes, self.timescale, self.end_time = read(path, wanted)
        self._read: dict[str, Signal] = {}

    @classmethod
    def open(cls, path: Path | str, only: Sequence[str] = ("*",)) -> Wave:
        """Read a VCD.

        Args:
            path: the file.
            only: names or globs of the signals to keep, the clock among them; all by default. Large files read faster and
                take less memory with it.

        Raises:
            VcdError: the file cannot be read, is not a VCD, or nothing matches.
        """
        return cls(Path(path), only)

    def find(self, glob: str) -> list[str]:
        """Paths that match a glob, in whole or from one of their dots on, in the file's order.

        `*` also matches dots; brackets are literal.
        """
        return [entry.path for entry in self.signals if _matches(entry.path, glob)]

    def __getitem__(self, name: str) -> Signal:
        """All changes of one signal, by its path or by a unique end of its path.

        Raises:
            VcdError: no such signal, several, or it was left out by `only`.
        """
        entry = self.declared(name)
        if entry.code not in self._read:
            if entry.code not in self._changes:
                raise VcdError(f"{self.path}: {entry.path} has not been read: add it to `only`")
            self._read[entry.code] = Signal(self.path, entry, self._changes.pop(entry.code))
        return self._read[entry.code]

    def declared(self, name: str) -> Declared:
        """The signal for a name: a path, or the end of one; of several aliases of one wire the shortest.

        Raises:
            VcdError: no such signal, or several.
        """
        found = self._by_path.get(name)
        if found is not None:
            return found
        ends = [entry for entry in self.signals if entry.path.endswith(f".{name}")]
        if len({entry.code for entry in ends}) > 1:
            more = f" and {len(ends) - _NEAR} more" if len(ends) > _NEAR else ""
            raise VcdError(f"{self.path}: {name} is ambiguous: {', '.join(entry.path for entry in ends[:_NEAR])}{more}")
        if ends:
            return min(ends, key=lambda entry: len(entry.path))
        if kind := left_out(self.path).get(name):
            raise VcdError(f"{self.path}: {name} is a {kind}, which is left out: must be a signal of bits")
        raise VcdError(f"{self.path}: no signal {name}; {self._near(name)}")

    def sampled(self, clock: str = "clk", begin: int = 0, end: int | None = None) -> Samples:
        """The signals as sampled by flip-flops on the rising edge of `clock`, at edges with begin <= time < end.

        Raises:
            VcdError: no such clock, or it has more than one bit.
        """
        return Samples(self, clock, begin, self.end_time + 1 if end is None else end)

    @cached_property
    def _by_path(self) -> dict[str, Declared]:
        return {entry.path: entry for entry in self.signals}

    def _near(self, name: str) -> str:
        names = {entry.name: entry.path for entry in reversed(self.signals)}
        near = difflib.get_close_matches(name.rpartition(".")[2], names, _NEAR, 0.5)
        paths = [names[entry] for entry in near] or difflib.get_close_matches(name, self._by_path, _NEAR, 0.5)
        return f"near it: {', '.join(paths)}" if paths else f"nothing is near it among {len(self.signals)} signals"


class Samples:
    """A waveform sampled at the rising edges of one clock: cycle i is its i-th edge.

    The value at an edge is the one before it, as for a flip-flop, so a change caused by an edge shows one cycle later.

    Attributes:
        wave: the waveform.
        clock: path of the clock.
        times: (n,) int64, the edges.
    """

    def __init__(self, wave: Wave, clock: str, begin: int, end: int) -> None:
        ticks = wave[clock]
        if ticks.declared.width != 1:
            raise VcdError(f"{wave.path}: clock {ticks.declared.path} has {ticks.declared.width} bits: must have 1")
        self.wave = wave
        self.clock = wave.declared(clock).path
        low = ~ticks.values & ~ticks.unknown
        rises = np.flatnonzero(low[:-1] & ticks.values[1:] & ~ticks.unknown[1:]) + 1
        times = ticks.times[rises]
        self.times: NDArray[np.int64] = times[(times >= begin) & (times < end)]
        self._exprs: dict[str, Expr] = {}
        self._before: dict[str, NDArray[np.intp]] = {}

    def __len__(self) -> int:
        return len(self.times)

    def __getitem__(self, name: str) -> Expr:
        """One signal as an expression.

        Raises:
            VcdError: no such signal, several, or it was left out when the file was read.
        """
        path = self.wave.declared(name).path
        if path not in self._exprs:
            signal = self.wave[path]
            before = self._before[path] = signal.before(self.times)
            missing = before < 0
            values: NDArray[Any] = signal.values[before] if len(signal.values) else np.zeros(len(self), signal.values.dtype)
            unknown = missing | (signal.unknown[before] if len(signal.unknown) else missing)
            values[unknown] = 0
            self._exprs[path] = Expr(self, values, unknown, name, (path,))
        return self._exprs[path]

    def find(self, glob: str) -> list[str]:
        """Paths that match a glob; see `Wave.find`."""
        return self.wave.find(glob)

    def stream(self, prefix: str) -> list[Expr]:
        """The signals of a ready/valid bundle, in the order of `handshake_stable`: valid, ready, then all other
        `<prefix>_<field>` of the same scope.

        Raises:
            VcdError: no valid, or no ready.
        """
        valid, ready = (self.wave.declared(f"{prefix}_{name}") for name in ("valid", "ready"))
        start = valid.path.removesuffix("valid")
        others = [entry.path for entry in self.wave.signals if entry.scope == valid.scope and entry.path.startswith(start)]
        return [self[path] for path in dict.fromkeys((valid.path, ready.path, *others))]

    def text(self, path: str, cycle: int) -> str:
        """A signal's value at one cycle as text, x and z bit by bit; `path` must have been sampled."""
        return self.wave[path].text(int(self._before[path][cycle]))


def _matches(path: str, glob: str) -> bool:
    glob = glob.replace("[", "[[]")
    return fnmatchcase(path, glob) or fnmatchcase(path, f"*.{glob}")
