# SPDX-License-Identifier: Apache-2.0
"""Toggles of every bit in a VCD, counted in one pass over the file: how often it changed, and for how long it was 1."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import evcot
from evcot._numba_private import njit
from evcot.outputs import written_aside

from .errors import VcdError
from .vcd import Declared, declared

__all__ = ["Activity", "count_toggles", "write_saif"]


_END_OF_HEADER = b"$enddefinitions"
_DIGITS, _LOWEST = 94, 33  # a code is a number of printable characters
_LONGEST_CODE = 9  # characters: more than int64 can represent

# Why `_count` stopped.
_WHOLE, _BROKEN, _BACKWARDS = 0, 1, 2


@dataclass(frozen=True)
class Activity:
    """What the bits of a VCD did; bits of a signal are adjacent, the lowest first.

    Attributes:
        signals: all that the file declares; those with one code are one net and have the same bits.
        duration: of the file, in its unit of time.
        unit: of time, such as "1 ns".
        toggles: (bits,) int64, changes from 0 to 1 and from 1 to 0.
        high: (bits,) int64, time at 1.
        unknown: (bits,) int64, time at x or z, and the time before the first value.
    """

    signals: tuple[Declared, ...]
    duration: int
    unit: str
    toggles: NDArray[np.int64]
    high: NDArray[np.int64]
    unknown: NDArray[np.int64]
    _first: dict[str, int]

    def bits(self, signal: Declared) -> slice:
        """The bits of a signal in the arrays."""
        first = self._first[signal.code]
        return slice(first, first + signal.width)

    def toggles_of(self, signal: Declared) -> int:
        """Toggles of all bits of a signal."""
        return int(self.toggles[self.bits(signal)].sum())


def count_toggles(path: Path) -> Activity:
    """Count the toggles in a VCD.

    Raises:
        VcdError: not a VCD, a damaged one, or it cannot be read.
    """
    signals = declared(path)
    widths = {signal.code: signal.width for signal in signals}
    numbers = np.array([_number(path, code) for code in widths], np.int64)
    width = np.array(list(widths.values()), np.int64)
    first = np.cumsum(width) - width
    order = np.argsort(numbers)
    try:
        text = np.memmap(path, np.uint8, "r")
    except (OSError, ValueError) as error:  # an empty file cannot be mapped
        raise VcdError(f"{path}: cannot be read: {error}") from error
    begin, unit = _header(path)
    bits = int(width.sum())
    toggles, high, unknown = (np.zeros(bits, np.int64) for _ in range(3))
    why, at, duration = _count(text, begin, numbers[order], first[order], width[order], toggles, high, unknown)
    if why == _BACKWARDS:
        raise VcdError(f"{path}: byte {at}: time runs backwards: must never decrease")
    if why == _BROKEN:
        raise VcdError(f"{path}: byte {at}: not a value change of a declared signal: the file is damaged, or was cut")
    return Activity(
        signals, int(duration), unit, toggles, high, unknown, dict(zip(widths, (int(one) for one in first), strict=True))
    )


def _number(path: Path, code: str) -> int:
    """A code as a number."""
    if len(code) > _LONGEST_CODE or any(not _LOWEST <= ord(one) < _LOWEST + _DIGITS for one in code):
        raise VcdError(f"{path}: code {code!r}: must be 1 to {_LONGEST_CODE} printable characters")
    number = 0
    for one in code:
        number = number * (_DIGITS + 1) + ord(one) - _LOWEST + 1
    return number


def _header(path: Path) -> tuple[int, str]:
    """Where the value changes begin, in bytes, and the unit of time."""
    words: list[bytes] = []
    with path.open("rb") as file:
        for line in file:
            words += line.split()
            if _END_OF_HEADER in words[-4:]:
                unit = b" ".join(_within(words, b"$timescale")).decode(errors="replace")
                return file.tell(), unit or "1 ns"
    raise VcdError(f"{path}: not a whole VCD: the declarations do not end")


def _within(words: list[bytes], keyword: bytes) -> Iterator[bytes]:
    """The words between a keyword and its $end."""
    if keyword in words:
        for word in words[words.index(keyword) + 1 :]:
            if word == b"$end":
                return
            yield word


@njit(cache=True, nogil=True)
def _count(  # type: ignore[no-untyped-def]  # pragma: no cover, compiled
    text, begin, numbers, firsts, widths, toggles, high, unknown
):
    """One pass over the value changes; returns why it ended, the byte where, and the time that passed."""
    bits = len(toggles)
    value = np.full(bits, 2, np.uint8)  # 0, 1, else unknown
    since = np.zeros(bits, np.int64)
    now = origin = np.int64(-1)
    i, end = begin, len(text)
    while i < end:
        kind = text[i]
        if kind <= 32:
            i += 1
            continue
        start = i
        if kind == 35:  # '#'
            i += 1
            time = np.int64(0)
            if i >= end or text[i] <= 32:
                return _BROKEN, start, 0
            while i < end and text[i] > 32:
                if not 48 <= text[i] <= 57:
                    return _BROKEN, start, 0
                time = time * 10 + (text[i] - 48)
                i += 1
            if time < now:
                return _BACKWARDS, start, 0
            if origin < 0:
                origin = time
                since[:] = time
            now = time
            continue
        if kind == 36:  # '$dumpvars', '$end' and the like
            comment = end - i > 8 and text[i + 1] == 99 and text[i + 2] == 111 and text[i + 3] == 109
            while i < end and text[i] > 32:
                i += 1
            while comment and i < end and not (text[i - 4] == 36 and text[i - 1] == 100):  # up to its $end
                i += 1
            continue
        if kind in (114, 82, 115, 83):  # a real or a text: passed over, with its code
            for _ in range(2):
                while i < end and text[i] > 32:
                    i += 1
                while i < end and text[i] <= 32:
                    i += 1
            continue
        if kind in (98, 66):  # 'b'
            i += 1
            from_, to = i, i
            while to < end and text[to] > 32:
                to += 1
            i = to
            while i < end and text[i] <= 32:
                i += 1
        else:
            from_, to = i, i + 1
            i += 1
        number, letters = np.int64(0), 0
        while i < end and text[i] > 32:
            number = number * (_DIGITS + 1) + (text[i] - _LOWEST + 1)
            letters += 1
            i += 1
        place = np.searchsorted(numbers, number)
        width = to - from_
        if (
            letters == 0
            or letters > _LONGEST_CODE
            or width == 0
            or place == len(numbers)
            or numbers[place] != number
            or width > widths[place]
            or i >= end
        ):
            return _BROKEN, start, 0
        first = firsts[place]
        for bit in range(widths[place]):
            # What is not written is as the highest bit that is, but for a 1: then it is 0.
            letter = text[to - 1 - min(bit, width - 1)]
            if bit >= width and letter == 49:
                letter = 48
            new = 0 if letter == 48 else 1 if letter == 49 else 2
            if new == 2 and letter not in (120, 88, 122, 90):
                return _BROKEN, start, 0
            at = first + bit
            old = value[at]
            if new != old:
                if now > since[at]:
                    if old == 1:
                        high[at] += now - since[at]
                    elif old == 2:
                        unknown[at] += now - since[at]
                if old + new == 1:
                    toggles[at] += 1
                value[at] = new
                since[at] = now
    for at in range(bits):
        if value[at] == 1:
            high[at] += now - since[at]
        elif value[at] == 2:
            unknown[at] += now - since[at]
    return _WHOLE, end, now - origin


_RANGE = re.compile(r"\[(\d+):(\d+)\]$")
_ESCAPED = re.compile(r"([^A-Za-z0-9_])")


@dataclass
class _Scope:
    signals: list[Declared] = field(default_factory=list)
    scopes: dict[str, _Scope] = field(default_factory=dict)


def write_saif(activity: Activity, path: Path, top: str, signals: Iterable[Declared], *, force: bool = False) -> None:
    """Write the toggles of those of some signals that are in and below one scope.

    Args:
        top: the scope, as in `TOP.cot_array`; its last part is the design's name in the file.

    Raises:
        OutputError: the file exists (without `force`), or cannot be written.
    """
    root = _Scope()
    for signal in signals:
        if signal.scope == top or signal.scope.startswith(f"{top}."):
            scope = root
            for part in signal.scope[len(top) + 1 :].split("."):
                scope = scope.scopes.setdefault(part, _Scope()) if part else scope
            scope.signals.append(signal)
    design = top.rpartition(".")[2]
    with written_aside(path, force=force) as file:
        for line in _lines(activity, root, design):
            file.write(f"{line}\n".encode())


def _lines(activity: Activity, root: _Scope, design: str) -> Iterator[str]:
    yield "(SAIFILE"
    yield '(SAIFVERSION "2.0")'
    yield '(DIRECTION "backward")'
    yield f'(DESIGN "{design}")'
    yield f'(PROGRAM_NAME "evcot") (VERSION "{evcot.__version__}")'
    yield "(DIVIDER / )"
    yield f"(TIMESCALE {' '.join(_unit(activity.unit))})"
    yield f"(DURATION {activity.duration})"
    yield from _instance(activity, root, design)
    yield ")"


def _unit(text: str) -> tuple[str, str]:
    """Number and unit of "1ns" or "1 ns"."""
    found = re.fullmatch(r"(\d+)\s*(\w+)", text)
    return (found[1], found[2]) if found else ("1", "ns")


def _instance(activity: Activity, scope: _Scope, name: str) -> Iterator[str]:
    yield f"(INSTANCE {_name(name)}"
    if scope.signals:
        yield "(NET"
        for signal in scope.signals:
            yield from _nets(activity, signal)
        yield ")"
    for below, inner in scope.scopes.items():
        yield from _instance(activity, inner, below)
    yield ")"


def _nets(activity: Activity, signal: Declared) -> Iterator[str]:
    """One line a bit, with the bit's index in the declaration."""
    bits = activity.bits(signal)
    span = _RANGE.search(signal.reference)
    low, step = (int(span[2]), 1 if int(span[1]) >= int(span[2]) else -1) if span else (0, 1)
    name = _name(signal.name)
    for i in range(signal.width):
        at = bits.start + i
        high, unknown = int(activity.high[at]), int(activity.unknown[at])
        index = f"\\[{low + step * i}\\]" if span else ""
        zero = activity.duration - high - unknown
        yield f"({name}{index} (T0 {zero}) (T1 {high}) (TX {unknown}) (TC {int(activity.toggles[at])}) (IG 0))"


def _name(text: str) -> str:
    return _ESCAPED.sub(r"\\\1", text)
