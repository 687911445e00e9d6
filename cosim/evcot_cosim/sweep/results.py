# SPDX-License-Identifier: Apache-2.0
"""Results from a store's rows: a mean per configuration, the best of them, the Pareto front, the response to each field."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .execute import DONE, MISMATCH
from .fields import HARDWARE, PRESET
from .task import DRAWN, canonical

__all__ = [
    "Group", "Level", "Suite", "best_first", "families_of", "front", "grouped", "merit", "module_and_shape", "responses",
    "settings_of", "suites_of",
]  # fmt: skip

_BINS = 12
_SURE = 1.96  # standard errors on either side: 95 %


@dataclass(frozen=True)
class Group:
    """All runs of one configuration with one engine.

    Attributes:
        engine, hardware, preset, settings: the configuration.
        rows: its runs.
        means: metric -> mean over the runs that have it; objectives that a run lacks are missing.
    """

    engine: str
    hardware: str
    preset: str | None
    settings: Mapping[str, Any]
    rows: tuple[Mapping[str, Any], ...]
    means: Mapping[str, float]

    @property
    def name(self) -> str:
        """The configuration in words."""
        named = {HARDWARE: self.hardware, PRESET: self.preset}
        settings = (f"{key} = {value}" for key, value in self.settings.items() if key not in named or value != named[key])
        parts = [self.engine, self.hardware, self.preset or "", *settings]
        return ", ".join(part for part in parts if part)


@dataclass
class Suite:
    """Runs of random registers and traffic: how many had which result, with how many events and records."""

    shapes: set[str] = field(default_factory=set)
    runs: int = 0
    exact: int = 0
    mismatches: int = 0
    failed: int = 0
    events: int = 0
    records: int = 0

    def to_dict(self) -> dict[str, int]:
        """Plain values; `shapes` is their number."""
        return {**vars(self), "shapes": len(self.shapes)}


def suites_of(rows: Iterable[Mapping[str, Any]], name: Callable[[Mapping[str, Any]], str]) -> dict[str, Suite]:
    """The runs of each suite, by the name that a row's has."""
    found: dict[str, Suite] = {}
    for row in rows:
        suite = found.setdefault(name(row), Suite())
        suite.shapes.add(canonical(json.loads(row["task"])["tables"]))
        suite.runs += 1
        suite.exact += row["status"] == DONE
        suite.mismatches += row["status"] == MISMATCH
        suite.failed += row["status"] not in (DONE, MISMATCH)
        suite.events += row["events"] or 0
        suite.records += row["records"] or 0
    return found


def module_and_shape(row: Mapping[str, Any]) -> str:
    """The name of a suite: a module with a shape that was given, or with all that were drawn."""
    task = json.loads(row["task"])
    if DRAWN in task["settings"]:
        return f"{row['hardware']}: drawn shapes"
    shape = task["tables"].get("shape", {})
    return f"{row['hardware']}: " + (", ".join(f"{name} = {value}" for name, value in shape.items()) or "default shape")


def settings_of(row: Mapping[str, Any]) -> dict[str, Any]:
    """The fields that the sweep set in a run, by name."""
    settings: dict[str, Any] = json.loads(row["task"])["settings"]
    return settings


def grouped(rows: Sequence[Mapping[str, Any]], metrics: Sequence[str]) -> list[Group]:
    """Runs by configuration, in the order of their first rows. A run that failed makes its group's means unknown."""
    found: dict[str, list[Mapping[str, Any]]] = {}
    settings: dict[str, dict[str, Any]] = {}
    for row in rows:
        own = settings_of(row)
        key = repr((row["engine"], row["hardware"], row["preset"], sorted(own.items())))
        found.setdefault(key, []).append(row)
        settings[key] = own
    groups = []
    for key, own_rows in found.items():
        first = own_rows[0]
        means = {metric: merit(own_rows, metric) for metric in metrics}
        known = {metric: mean for metric, mean in means.items() if mean is not None}
        groups.append(Group(first["engine"], first["hardware"] or "", first["preset"], settings[key], tuple(own_rows), known))
    return groups


def merit(rows: Sequence[Mapping[str, Any]], metric: str) -> float | None:
    """The mean of a metric over runs; None where one of them failed or has no such figure."""
    values = [row[metric] for row in rows if row["status"] == DONE and row[metric] is not None]
    return math.fsum(values) / len(values) if rows and len(values) == len(rows) else None


def best_first(groups: Sequence[Group], objectives: Mapping[str, str]) -> list[Group]:
    """Groups that have all objectives, by the first of them, then by the next."""
    whole = [group for group in groups if all(metric in group.means for metric in objectives)]
    return sorted(whole, key=lambda group: [_cost(group.means[metric], way) for metric, way in objectives.items()])


def front(groups: Sequence[Group], objectives: Mapping[str, str]) -> list[Group]:
    """The Pareto front: groups than which no other is better in one objective and as good in all; best in the first first."""
    ordered = best_first(groups, objectives)
    costs = np.array([[_cost(group.means[metric], way) for metric, way in objectives.items()] for group in ordered])
    if not len(ordered) or not objectives:
        return []
    kept: list[int] = []
    best = np.empty((0, costs.shape[1]))
    for i, cost in enumerate(costs):
        # Whatever dominates comes before, or is equal in all: the order is by these costs.
        if not ((best <= cost).all(axis=1) & (best < cost).any(axis=1)).any():
            kept.append(i)
            best = costs[kept]
    return [ordered[i] for i in kept]


def _cost(value: float, way: str) -> float:
    return -value if way == "max" else value


@dataclass(frozen=True)
class Level:
    """The objective where a field has one value, or lies in one part of its range.

    Attributes:
        title: the value, or the part.
        at: place on the axis, from 0 to 1; None where values have no order.
        count: configurations.
        mean, low, high: mean of the objective, and its 95 % interval; both are the mean with one configuration.
    """

    title: str
    at: float | None
    count: int
    mean: float
    low: float
    high: float


def responses(groups: Sequence[Group], metric: str) -> dict[str, list[Level]]:
    """Field -> levels of the metric: at each number where there are few, else in parts with as many configurations each; of
    names at each, the highest mean first."""
    names = dict.fromkeys(name for group in groups for name in group.settings)
    found = {}
    for name in names:
        pairs = [
            (group.settings[name], group.means[metric]) for group in groups if name in group.settings and metric in group.means
        ]
        if len({repr(value) for value, _ in pairs}) > 1:
            found[name] = _levels(pairs)
    return found


def _levels(pairs: Sequence[tuple[Any, float]]) -> list[Level]:
    distinct = {repr(value): value for value, _ in pairs}
    numbers = all(isinstance(value, int | float) and not isinstance(value, bool) for value in distinct.values())
    y = np.array([mean for _, mean in pairs])
    if not numbers:
        own = np.array([repr(value) for value, _ in pairs])
        named = [_level(_shown(value), None, y[own == text]) for text, value in distinct.items()]
        return sorted(named, key=lambda level: -level.mean)
    x = np.array([float(value) for value, _ in pairs])
    if len(distinct) <= _BINS:
        order = sorted(distinct.values())
        return [_level(_shown(value), i / max(len(order) - 1, 1), y[x == float(value)]) for i, value in enumerate(order)]
    edges = np.unique(np.quantile(x, np.linspace(0, 1, _BINS + 1)))
    of = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, len(edges) - 2)
    low, high = float(x.min()), float(x.max())
    levels = []
    for i in range(len(edges) - 1):
        inside = of == i
        if inside.any():
            title = f"{edges[i]:.4g} to {edges[i + 1]:.4g}"
            levels.append(_level(title, (float(x[inside].mean()) - low) / (high - low), y[inside]))
    return levels


def _shown(value: Any) -> str:
    return value if isinstance(value, str) else canonical(value)


def _level(title: str, at: float | None, values: NDArray[np.float64]) -> Level:
    mean = float(values.mean())
    error = float(values.std(ddof=1)) / math.sqrt(len(values)) if len(values) > 1 else 0.0
    return Level(title, at, len(values), mean, mean - _SURE * error, mean + _SURE * error)


@dataclass(frozen=True)
class LeftOut:
    """A family, scored with what was best on all others.

    Attributes:
        family: that was left out.
        chosen: name of the configuration that was best on the others.
        others, score: its objective on the others, each family counting once, and on the family.
        best, best_score: the configuration that was best on the family itself, and its score there.
    """

    family: str
    chosen: str
    others: float
    score: float
    best: str
    best_score: float


def families_of(groups: Sequence[Group], metric: str, way: str) -> dict[str, list[LeftOut]]:
    """Engine -> every family left out once."""
    result = {}
    for engine in dict.fromkeys(group.engine for group in groups):
        table: dict[int, dict[str, float]] = {}
        own = [group for group in groups if group.engine == engine]
        for i, group in enumerate(own):
            families = dict.fromkeys(row["family"] for row in group.rows)
            means = {family: merit([row for row in group.rows if row["family"] == family], metric) for family in families}
            if means and all(mean is not None for mean in means.values()):
                table[i] = {family: mean for family, mean in means.items() if mean is not None}
        names = {family for means in table.values() for family in means}
        table = {i: means for i, means in table.items() if means.keys() == names}
        if len(names) < 2:
            continue

        def others(i: int, family: str, table: Mapping[int, Mapping[str, float]] = table) -> float:
            return float(np.mean([mean for name, mean in table[i].items() if name != family]))

        left_out = []
        for family in sorted(names):
            chosen = min(table, key=lambda i: _cost(others(i, family), way))
            best = min(table, key=lambda i: _cost(table[i][family], way))
            left_out.append(
                LeftOut(
                    family, own[chosen].name, others(chosen, family), table[chosen][family], own[best].name, table[best][family]
                )
            )
        result[engine] = left_out
    return result
