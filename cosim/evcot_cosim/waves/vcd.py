# SPDX-License-Identifier: Apache-2.0
"""VCD reader, based on vcdvcd: declarations and value changes."""

from __future__ import annotations

import re
import signal
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.errors import OutputError, reason_of

from .errors import VcdError
from .vcd_lines import DOLLAR, vcd_lines

__all__ = ["INT64_BITS", "Declared", "Signal", "declared", "initial_values", "left_out", "parse", "read"]

_FIRST_TIME = re.compile(rb"^#([0-9]+)", re.MULTILINE)
_RANGE = re.compile(r"\[\d+:\d+\]$")
INT64_BITS = 62  # the widest signal kept in int64: a sum of two fits too
_TYPES_WITHOUT_BITS = ("real", "realtime", "event", "string")


@dataclass(frozen=True)
class Declared:
    """The declaration of one signal.

    Attributes:
        path: scopes and name joined by dots, without the range of bits: `TOP.cot.state`, `TOP.cot_array.cm_x[3]`.
        reference: the same with the range of bits, as in the file and in GTKWave: `TOP.cot.state[2:0]`.
        code: the file's short code; signals that share one are the same wire.
        width: bits.
    """

    path: str
    reference: str
    code: str
    width: int

    @property
    def scope(self) -> str:
        """The path without its last part."""
        return self.path.rpartition(".")[0]

    @property
    def name(self) -> str:
        """The path's last part."""
        return self.path.rpartition(".")[2]


@dataclass(frozen=True)
class Timescale:
    """The unit of a VCD's times."""

    magnitude: int
    unit: str

    def text(self, time: int) -> str:
        """A time as text, such as "125 ps"."""
        return f"{time * self.magnitude} {self.unit}"


class Signal:
    """All changes of one signal of a file.

    Attributes:
        declared: its declaration.
        times: (k,) int64, non-decreasing.
        values: (k,) bool for one bit, int64 up to 62 bits, Python integers above; 0 where unknown.
        unknown: (k,) bool, true where any bit is x or z.
    """

    def __init__(self, file: Path, declared: Declared, changes: list[tuple[int, str]]) -> None:
        self.declared = declared
        self.times: NDArray[np.int64] = np.fromiter((time for time, _ in changes), np.int64, len(changes))
        if np.any(np.diff(self.times) < 0):
            raise VcdError(f"{file}: {declared.path}: time runs backwards: must never decrease")
        texts = [text for _, text in changes]
        self.unknown: NDArray[np.bool_] = np.zeros(len(texts), np.bool_)
        self._texts: dict[int, str] = {}
        try:
            numbers = [int(text, 2) for text in texts]
        except ValueError:
            numbers = [self._number(i, text) for i, text in enumerate(texts)]
        dtype = np.bool_ if declared.width == 1 else np.int64 if declared.width <= INT64_BITS else np.object_
        self.values: NDArray[Any] = np.array(numbers, dtype)

    def _number(self, i: int, text: str) -> int:
        if set(text.lower()) <= {"0", "1"}:
            return int(text, 2)
        self.unknown[i] = True
        self._texts[i] = text.lower()
        return 0

    def before(self, times: NDArray[np.int64]) -> NDArray[np.intp]:
        """Index of the last change before each time, -1 if there is none: the value a flip-flop clocked then would sample."""
        return np.searchsorted(self.times, times, side="left") - 1

    def text(self, change: int) -> str:
        """The value after one change as text: a number, or the bits if some are x or z."""
        if change < 0:
            return "x"
        if change in self._texts:
            return self._texts[change]
        value = int(self.values[change])
        return str(value) if value < 1 << 16 else hex(value)


def declared(path: Path) -> tuple[Declared, ...]:
    """The signals that a VCD's header declares, in order; reals and other non-vector types are left out.

    Raises:
        VcdError: not a VCD, or it cannot be read.
    """
    with _readable(path):
        vcd = parse(path, only_sigs=True)
        return _declared(path, vcd)


def left_out(path: Path) -> dict[str, str]:
    """The types of the signals that `declared` leaves out, by their paths and by the last parts of these.

    Raises:
        VcdError: as for `declared`.
    """
    with _readable(path):
        vcd = parse(path, only_sigs=True)
        kinds = {name: vcd.data[code].var_type for name, code in vcd.references_to_ids.items()}
        others = {name: kind for name, kind in kinds.items() if kind in _TYPES_WITHOUT_BITS}
        return {name.rpartition(".")[2]: kind for name, kind in others.items()} | others


def initial_values(path: Path, signals: Sequence[Declared]) -> dict[str, int]:
    """First values of signals, by path; those that are x or z are left out.

    Raises:
        VcdError: not a VCD, or it cannot be read.
    """
    if not signals:
        return {}
    # The first time of a window need not be 0: it is the time of the first change of any signal.
    with _readable(path):
        begin = next((int(first[1]) for block in vcd_lines(path) if (first := _FIRST_TIME.search(block))), 0)
        vcd = parse(path, signals=[entry.reference for entry in signals], to_time=begin)
        found = {entry.path: vcd.data[entry.code].tv for entry in signals}
        return {path: int(tv[0][1], 2) for path, tv in found.items() if tv and set(tv[0][1]) <= {"0", "1"}}


def read(path: Path, signals: Sequence[Declared]) -> tuple[dict[str, list[tuple[int, str]]], Timescale, int]:
    """Changes of signals by code, the timescale, and the last time in the file.

    Raises:
        VcdError: not a VCD, or it cannot be read.
    """
    with _readable(path):
        vcd = parse(path, signals=[entry.reference for entry in signals])
        scale = Timescale(int(vcd.timescale["magnitude"]), vcd.timescale["unit"]) if vcd.timescale else Timescale(1, "steps")
        return {code: entry.tv for code, entry in vcd.data.items()}, scale, int(vcd.endtime)


def _declared(path: Path, vcd: Any) -> tuple[Declared, ...]:
    entries = [
        (reference, code, vcd.data[code])
        for reference, code in vcd.references_to_ids.items()
        if vcd.data[code].var_type not in _TYPES_WITHOUT_BITS
    ]
    if not entries:
        raise VcdError(f"{path}: not a VCD: must declare at least one signal")
    # Parts of one vector that are declared separately need their ranges to be distinguished.
    count = Counter(_RANGE.sub("", reference) for reference, _, _ in entries)
    return tuple(
        Declared(bare if count[bare := _RANGE.sub("", reference)] == 1 else reference, reference, code, int(entry.size))
        for reference, code, entry in entries
    )


def parse(path: Path, *, signals: Sequence[str] = (), only_sigs: bool = False, to_time: int | None = None) -> Any:
    """Parse a VCD with vcdvcd, from a temporary file with a change per line.

    Importing vcdvcd makes SIGPIPE silently kill the process; the previous handler is restored.

    Args:
        signals: references of the signals whose changes are kept; none: all.
        only_sigs: read the declarations only.
        to_time: end with the changes at this time.

    Raises:
        OutputError: the temporary file cannot be written.
    """
    handler = signal.getsignal(signal.SIGPIPE)
    from vcdvcd import VCDVCD

    if signal.getsignal(signal.SIGPIPE) != handler:
        signal.signal(signal.SIGPIPE, handler)
    with tempfile.TemporaryDirectory() as folder:
        lines = Path(folder) / "lines.vcd"
        lines.touch()
        for block in vcd_lines(path, header_only=only_sigs):
            _append(lines, block)
        wanted = [name.replace("$", DOLLAR) for name in signals]
        vcd = VCDVCD(str(lines), signals=wanted, only_sigs=only_sigs, to_time=to_time)
    vcd.references_to_ids = {name.replace(DOLLAR, "$"): code for name, code in vcd.references_to_ids.items()}
    vcd.signals = [name.replace(DOLLAR, "$") for name in vcd.signals]
    return vcd


def _append(path: Path, block: bytes) -> None:
    try:
        with path.open("ab") as file:
            file.write(block)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {reason_of(error, path)}") from error


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    """Convert any error of the parser on an invalid or truncated VCD to a one-line VcdError."""
    try:
        yield
    except (VcdError, OutputError):
        raise
    except OSError as error:
        raise VcdError(f"{path}: cannot be read: {error.strerror or error}") from error
    except Exception as error:  # the parser raises whatever its indexing and conversions raise, and leaves the file open
        with warnings.catch_warnings(action="ignore", category=ResourceWarning):
            traceback.clear_frames(error.__traceback__)
        raise VcdError(f"{path}: not a whole VCD: {error}") from error
