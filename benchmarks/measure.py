# SPDX-License-Identifier: Apache-2.0
"""Common parts of the benchmarks: results, skips, and timings that are robust on a busy machine.

Runs that are compared take turns (A B A B ...), and the figure is the median over the turns: whatever slows the machine down
for a while hits both. Work on one thread is timed in CPU time, so that others on the machine do not count; work on two
threads, and whatever waits, in wall time.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from enum import IntEnum
from statistics import median
from typing import Any, NamedTuple

__all__ = ["Clock", "Goal", "Result", "Skip", "Timing", "Turns", "heading", "line", "take_turns", "timed"]


class Skip(Exception):
    """This machine cannot run the benchmark; the message says what is missing."""


class Clock(IntEnum):
    """Which entry of a `Timing`."""

    WALL = 0
    CPU = 1


class Timing(NamedTuple):
    """How long one run took, by either `Clock`."""

    wall_s: float
    cpu_s: float


class Goal(NamedTuple):
    """The required ratio of a result."""

    ratio: float
    at_most: bool = False

    def met(self, ratio: float) -> bool:
        """Whether a ratio reaches the goal."""
        return ratio <= self.ratio if self.at_most else ratio >= self.ratio

    def __str__(self) -> str:
        return f"{'<=' if self.at_most else '>='} {self.ratio:g}"


@dataclass(frozen=True)
class Result:
    """One figure.

    Attributes:
        name, value, unit: the figure.
        reference: what it is held against, in the same unit, or None.
        against: description of the reference.
        ratio: value / reference, or None. Of runs that took turns: the median over the turns.
        goal: what the ratio shall be, or None.
        how: how it was measured, where the name does not say it.
    """

    name: str
    value: float
    unit: str
    reference: float | None = None
    against: str = ""
    ratio: float | None = None
    goal: Goal | None = None
    how: str = ""

    def __post_init__(self) -> None:
        if self.ratio is None and self.reference:
            object.__setattr__(self, "ratio", self.value / self.reference)

    @property
    def met(self) -> bool | None:
        """Whether the goal is reached; None without one."""
        return None if self.goal is None or self.ratio is None else self.goal.met(self.ratio)

    def to_dict(self) -> dict[str, Any]:
        """Plain values, as bench.json stores them."""
        entry = asdict(self)
        return entry | {"goal": self.goal and f"ratio {self.goal}", "met": self.met}


def timed(work: Callable[[], object]) -> Timing:
    """Do the work once, in this thread; other threads' CPU time does not count."""
    wall_s, cpu_s = time.perf_counter(), time.thread_time()
    work()
    return Timing(time.perf_counter() - wall_s, time.thread_time() - cpu_s)


@dataclass(frozen=True)
class Turns:
    """Timings of runs that took turns: name -> one per round."""

    timings: Mapping[str, list[Timing]]

    def seconds(self, name: str, clock: Clock = Clock.CPU) -> float:
        """Median duration of one run."""
        return median(timing[clock] for timing in self.timings[name])

    def speed_ratio(self, name: str, other: str, clock: Clock = Clock.CPU) -> float:
        """How many times as fast as `other`, both having the same work: median over the rounds."""
        pairs = zip(self.timings[name], self.timings[other], strict=True)
        return median(theirs[clock] / ours[clock] for ours, theirs in pairs)


def take_turns(runs: Mapping[str, Callable[[], Timing]], rounds: int) -> Turns:
    """Every run once to warm up, then every run in turn, `rounds` times."""
    for run in runs.values():
        run()
    timings: dict[str, list[Timing]] = {name: [] for name in runs}
    for _ in range(rounds):
        for name, run in runs.items():
            timings[name].append(run())
    return Turns(timings)


def heading(*cells: str) -> None:
    """Print the head of a table in Markdown."""
    line(cells)
    line(["---"] * len(cells))


def line(cells: Iterable[str]) -> None:
    """Print a row of a table in Markdown."""
    print(f"| {' | '.join(cells)} |", flush=True)
