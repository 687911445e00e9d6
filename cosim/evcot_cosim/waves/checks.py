# SPDX-License-Identifier: Apache-2.0
"""Properties of sampled signals: each function returns how many cases it checked, or raises `WaveformError`.

A vacuous property, one without any case, also fails, unless `allow_vacuous` is given. A condition that is unknown (x or z)
in a checked cycle is not fulfilled. `where` limits a check to the cycles in which it is true.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import IntEnum
from typing import TYPE_CHECKING

from .errors import WaveformError

if TYPE_CHECKING:
    from .wave import Samples
from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .errors import PropertyError
from .expr import Expr
from .wave import Samples

__all__ = [
    "After",
    "Names",
    "after",
    "always",
    "failure",
    "handshake_stable",
    "never",
    "one_of",
    "sometime",
    "stable_until",
    "transitions",
]


Names = Mapping[str, type[IntEnum]]
"""Signals, by path, whose values have names."""

_BEFORE, _AFTER = 3, 2
_COLUMNS = 12
_ROWS = 24


def failure(
    samples: Samples,
    property_text: str,
    what: str,
    cycle: int,
    paths: Sequence[str],
    *,
    failures: int,
    cases: int,
    until: int | None = None,
    names: Names | None = None,
) -> WaveformError:
    """The error for a property that first fails at `cycle`; the table extends to cycle `until` as far as there is room."""
    time = int(samples.times[cycle])
    scale = samples.wave.timescale
    head = (
        f"{property_text}: {what} at {scale.text(time)}, cycle {cycle}; "
        f"{failures} of {cases} cases fail ({samples.wave.path}, rising {samples.clock})"
    )
    last = min(max(cycle + _AFTER, until or 0), cycle - _BEFORE + _COLUMNS - 1, len(samples) - 1)
    cycles = range(max(0, cycle - _BEFORE), last + 1)
    table = [["cycle", *(f">{i}" if i == cycle else str(i) for i in cycles)]]
    table.append([scale.unit, *(str(int(samples.times[i]) * scale.magnitude) for i in cycles)])
    table += [[path, *(value_text(samples.text(path, i), (names or {}).get(path)) for i in cycles)] for path in paths[:_ROWS]]
    lines = [head, *_aligned(table)]
    if len(paths) > _ROWS:
        lines.append(f"  and {len(paths) - _ROWS} more signals")
    return WaveformError("\n".join(lines), str(samples.wave.path), cycle, time)


def untested(samples: Samples, property_text: str, why: str) -> WaveformError:
    """The error for a property that is vacuous in the waveform."""
    if not len(samples):
        why = f"no samples: {samples.clock} never rises"
        span = ""
    else:
        text = samples.wave.timescale.text
        span = f" in {len(samples)} cycles, {text(int(samples.times[0]))} to {text(int(samples.times[-1]))}"
    return WaveformError(f"{property_text}: vacuous: {why}{span} ({samples.wave.path})", str(samples.wave.path))


def value_text(text: str, names: type[IntEnum] | None) -> str:
    """The name of a value, if it has one, else the value."""
    return {str(int(member)): member.name for member in names or ()}.get(text, text)


def _aligned(table: list[list[str]]) -> list[str]:
    widths = [max(len(row[i]) for row in table) for i in range(len(table[0]))]
    return [
        "  "
        + "  ".join([row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))])
        for row in table
    ]


def always(condition: Expr, *, where: Expr | None = None, allow_vacuous: bool = False) -> int:
    """The condition is true in every cycle (of those in which `where` is true)."""
    text = f"always({condition.text}{_where(where)})"
    return _each(condition, condition.true, text, "not true", where, allow_vacuous)


def never(condition: Expr, *, where: Expr | None = None, allow_vacuous: bool = False) -> int:
    """The condition is false in every cycle (of those in which `where` is true)."""
    text = f"never({condition.text}{_where(where)})"
    return _each(condition, condition.false, text, "not false", where, allow_vacuous)


def sometime(condition: Expr) -> int:
    """The condition is true in at least one cycle; returns the number of such cycles."""
    count = int(np.count_nonzero(condition.true))
    if not count:
        raise untested(condition.samples, f"sometime({condition.text})", "it is true nowhere")
    return count


def one_of(signal: Expr, values: Collection[int], *, where: Expr | None = None, allow_vacuous: bool = False) -> int:
    """The number is one of these values in every cycle (of those in which `where` is true)."""
    allowed = np.isin(signal.values.astype(np.object_), [int(value) for value in values]) & ~signal.unknown
    shown = ", ".join(value.name if isinstance(value, IntEnum) else str(value) for value in values)
    text = f"one_of({signal.text}, {{{shown}}}{_where(where)})"
    return _each(signal, allowed, text, "another value", where, allow_vacuous, _names(signal, values))


def transitions(
    signal: Expr, allowed: Mapping[int, Collection[int]], *, where: Expr | None = None, allow_vacuous: bool = False
) -> int:
    """Every change of the number is allowed, that is from a key to one of its values; it may also stay unchanged.

    With `where`, only changes that begin in a cycle in which it is true are checked. Values given as an IntEnum are named in
    messages. Returns the number of changes.
    """
    text = f"transitions({signal.text}{_where(where)})"
    samples, values, unknown = signal.samples, signal.values, signal.unknown
    moves = _differs(signal)
    if where is not None:
        _together(signal, where)
        _known(where, text, "where")
        moves &= where.true[:-1]
    good = np.zeros_like(moves)
    for start, ends in allowed.items():
        good |= (values[:-1] == int(start)) & np.isin(values[1:].astype(np.object_), [int(end) for end in ends])
    good &= ~unknown[:-1] & ~unknown[1:]
    cases = int(np.count_nonzero(moves))
    bad = np.flatnonzero(moves & ~good) + 1
    if len(bad):
        cycle = int(bad[0])
        names = _names(signal, allowed)
        was, now = ("x" if unknown[i] else value_text(str(values[i]), names.get(signal.paths[0])) for i in (cycle - 1, cycle))
        what = f"{was} to {now}"
        raise failure(samples, text, what, cycle, _paths(signal, where), failures=len(bad), cases=cases, names=names)
    return _counted(samples, cases, text, "the value never changes", allow_vacuous)


@dataclass(frozen=True)
class After:
    """`after(trigger).within(n).expect(condition)`: see `after`."""

    trigger: Expr
    cycles: int = 1

    def within(self, cycles: int) -> After:
        """Allow this many cycles after the trigger's.

        Raises:
            PropertyError: less than 1.
        """
        if cycles < 1:
            raise PropertyError(f"after({self.trigger.text}).within({cycles}): must allow at least 1 cycle")
        return replace(self, cycles=cycles)

    def expect(self, condition: Expr, *, allow_vacuous: bool = False) -> int:
        """The condition is true in at least one of the allowed cycles after every trigger.

        A trigger so late that the waveform ends before its last allowed cycle counts only if it is fulfilled.
        """
        trigger, samples = self.trigger, self.trigger.samples
        text = f"after({trigger.text}).within({self.cycles}).expect({condition.text})"
        _together(trigger, condition)
        _known(trigger, text, "the trigger")
        starts = np.flatnonzero(trigger.true)
        fulfilled = np.append(np.flatnonzero(condition.true), len(samples) + self.cycles + 1)
        following = fulfilled[np.searchsorted(fulfilled, starts, side="right")]
        met = following <= starts + self.cycles
        whole = starts + self.cycles < len(samples)
        bad = starts[~met & whole]
        cases = int(np.count_nonzero(met | whole))
        if len(bad):
            cycle = int(bad[0])
            last = cycle + self.cycles
            what = f"triggered, and nothing by cycle {last},"
            paths = _paths(trigger, condition)
            raise failure(samples, text, what, cycle, paths, failures=len(bad), cases=cases, until=last)
        why = "the waveform ends too soon after every trigger" if len(starts) else "the trigger never happens"
        return _counted(samples, cases, text, why, allow_vacuous)


def after(trigger: Expr) -> After:
    """Start a property about the cycles after a trigger: the next cycle, or `within` several cycles.

    `after(s["req"]).within(3).expect(s["ack"])`: after every cycle with req, ack in one of the 3 cycles that follow. For
    a condition in the same cycle write `always(s["ack"], where=s["req"])`.
    """
    return After(trigger)


def stable_until(signals: Expr | tuple[Expr, ...], start: Expr, until: Expr, *, allow_vacuous: bool = False) -> int:
    """The signals keep their values from a cycle in which `start` is true up to and including one in which `until` is true.

    A cycle in which both are true requires nothing. Returns the number of cycles over which values had to be kept.
    """
    held = (signals,) if isinstance(signals, Expr) else signals
    text = f"stable_until({', '.join(signal.text for signal in held)}, start={start.text}, until={until.text})"
    return _held(held, start, until, text, "the start never happens, or is always over at once", allow_vacuous)


def handshake_stable(valid: Expr, ready: Expr, *payload: Expr, where: Expr | None = None, allow_vacuous: bool = False) -> int:
    """A ready/valid stream keeps valid high and its payload unchanged until ready is high.

    With `where`, cycles in which it is false end every transfer: `where=~s["rst"]`. Returns the number of wait cycles.
    """
    text = f"handshake_stable({', '.join(signal.text for signal in (valid, ready, *payload))}{_where(where)})"
    over = ready if where is None else ready | ~where
    start = valid if where is None else valid & where
    return _held((valid, *payload), start, over, text, "what is offered never has to wait", allow_vacuous, also=(ready,))


def _held(
    held: tuple[Expr, ...], start: Expr, until: Expr, text: str, why: str, allow_vacuous: bool, also: tuple[Expr, ...] = ()
) -> int:
    _together(start, until, *held)
    samples = start.samples
    _known(start, text, "the start")
    cycles = np.arange(len(samples))
    begun = np.maximum.accumulate(np.where(start.true, cycles, -1))
    over = np.maximum.accumulate(np.where(until.true, cycles, -1))
    holding = (begun > over)[:-1]
    cases = int(np.count_nonzero(holding))
    broken = [(np.flatnonzero(holding & _differs(signal)), signal) for signal in held]
    first = min(((int(bad[0]) + 1, i) for i, (bad, _) in enumerate(broken) if len(bad)), default=None)
    if first is not None:
        cycle, index = first
        failures = len(np.unique(np.concatenate([bad for bad, _ in broken])))
        starts = np.flatnonzero(start.true)
        since = int(starts[np.searchsorted(starts, over[cycle - 1], side="right")])
        what = f"{held[index].text} changes, having been held since cycle {since},"
        paths = tuple(dict.fromkeys(_paths(start, until, *also) + _paths(*held)))
        raise failure(samples, text, what, cycle, paths, failures=failures, cases=cases)
    return _counted(samples, cases, text, why, allow_vacuous)


def _differs(signal: Expr) -> NDArray[np.bool_]:
    """(n - 1,) bool: the next cycle's value differs, or one of the two is unknown."""
    different: NDArray[np.bool_] = np.asarray(signal.values[1:] != signal.values[:-1], np.bool_)
    return different | signal.unknown[1:] | signal.unknown[:-1]


def _each(
    subject: Expr,
    good: NDArray[np.bool_],
    text: str,
    what: str,
    where: Expr | None,
    allow_vacuous: bool,
    names: Names | None = None,
) -> int:
    samples = subject.samples
    asked = np.arange(len(samples)) >= subject.since
    if where is not None:
        _together(subject, where)
        _known(where, text, "where")
        asked &= where.true
    cases = int(np.count_nonzero(asked))
    bad = np.flatnonzero(asked & ~good)
    if len(bad):
        cycle = int(bad[0])
        if subject.unknown[cycle]:
            what = "unknown"
        raise failure(samples, text, what, cycle, _paths(subject, where), failures=len(bad), cases=cases, names=names)
    why = "`where` is never true" if where is not None else "no cycle has all the past that it asks for"
    return _counted(samples, cases, text, why, allow_vacuous)


def _counted(samples: Samples, cases: int, text: str, why: str, allow_vacuous: bool) -> int:
    if not len(samples) or (not cases and not allow_vacuous):
        raise untested(samples, text, why)
    return cases


def _known(condition: Expr, text: str, role: str) -> None:
    unknown = np.flatnonzero(condition.unknown & (np.arange(len(condition.unknown)) >= condition.since))
    if len(unknown):
        n, cases, what = len(unknown), len(condition.unknown), f"{role} is unknown"
        raise failure(condition.samples, text, what, int(unknown[0]), condition.paths, failures=n, cases=cases)


def _together(first: Expr, *others: Expr) -> None:
    for other in others:
        if other.samples is not first.samples:
            raise PropertyError(f"{first.text} and {other.text}: must be sampled together, on one clock of one waveform")


def _paths(*exprs: Expr | None) -> tuple[str, ...]:
    return tuple(dict.fromkeys(path for expr in exprs if expr is not None for path in expr.paths))


def _where(where: Expr | None) -> str:
    return "" if where is None else f", where={where.text}"


def _names(signal: Expr, values: Collection[int]) -> dict[str, type[IntEnum]]:
    kinds = {type(value) for value in values if isinstance(value, IntEnum)}
    bare = len(signal.paths) == 1 and signal is signal.samples[signal.paths[0]]
    return {signal.paths[0]: kinds.pop()} if bare and len(kinds) == 1 else {}
