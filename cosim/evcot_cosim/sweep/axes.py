# SPDX-License-Identifier: Apache-2.0
"""The values of one field in a sweep: choices, or a range; and points of all fields: a grid, random, a Latin hypercube."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from evcot.errors import ConfigError
from evcot.ranges import span

from .fields import check_field, limits

__all__ = ["METHODS", "RUNS_MAX", "Axis", "Point", "axis_from", "grid", "latin", "uniform"]

METHODS = ("grid", "random", "latin", "optuna")
RUNS_MAX = 200_000  # of a sweep: all are planned in memory, 1.6 kB each
STEPS_MAX = 100_000  # of a range: its values are held in memory
_DIGITS = 9  # of a sampled number: one that a person can copy
_KEYS = {"from", "to", "steps", "log"}

Point = Mapping[str, Any]
"""Field -> value."""


@dataclass(frozen=True)
class Axis:
    """The values of a field.

    Attributes:
        name: of the field.
        choices: its values; empty for a range.
        low, high: limits of a range, inclusive; whole numbers if both are.
        log: whether a range is divided by ratio instead of difference.
        steps: number of values that a grid takes from a range.
    """

    name: str
    choices: tuple[Any, ...] = ()
    low: float = 0
    high: float = 0
    log: bool = False
    steps: int | None = None

    @property
    def whole(self) -> bool:
        """Whether a range is one of whole numbers."""
        return isinstance(self.low, int) and isinstance(self.high, int)

    def at(self, share: float) -> Any:
        """The value at a share of the way, from 0 up to but not including 1."""
        if self.choices:
            return self.choices[int(share * len(self.choices))]
        if self.whole and not self.log:
            return int(self.low) + int(share * (int(self.high) - int(self.low) + 1))
        value = self.low * (self.high / self.low) ** share if self.log else self.low + share * (self.high - self.low)
        return min(max(round(value), int(self.low)), int(self.high)) if self.whole else self.rounded(value)

    def grid(self) -> tuple[Any, ...]:
        """The values of a grid, each once."""
        if self.choices:
            return self.choices
        if self.steps is None:
            raise ConfigError(f"fields.{self.name}: a range without steps: must have steps for a grid, or be a list of values")
        divide = np.geomspace if self.log else np.linspace
        values = [float(value) for value in divide(self.low, self.high, self.steps)]
        if self.whole:
            return tuple(dict.fromkeys(round(value) for value in values))
        return tuple(self.rounded(value) for value in values)

    def rounded(self, value: float) -> float:
        """A number of a range with so few digits that a person can copy it."""
        return min(max(float(f"{value:.{_DIGITS}g}"), self.low), self.high)


def axis_from(name: str, values: Any) -> Axis:
    """The axis that a specification has for a field: a list of values, `{from, to, steps, log}`, or one value.

    Raises:
        ConfigError: no such field, no value, or a value outside the field's range.
    """
    check_field(name)
    if isinstance(values, Mapping) and values.keys() == {"values"} and isinstance(values["values"], list):
        values = values["values"]  # as `spec_toml` writes it: tables keep their order among tables
    if not isinstance(values, Mapping):
        axis = Axis(name, tuple(values) if isinstance(values, list) else (values,))
        if not axis.choices:
            raise ConfigError(f"fields.{name} = []: must have one value at least")
        _check_limits(name, axis.choices)
        return axis
    for key in values:
        if key not in _KEYS:
            raise ConfigError(f"fields.{name}: unknown key {key!r}: must be one of {', '.join(sorted(_KEYS))}")
    low: Any = values.get("from")
    high: Any = values.get("to")
    for key, limit in (("from", low), ("to", high)):
        if isinstance(limit, bool) or not isinstance(limit, int | float) or not math.isfinite(limit):
            raise ConfigError(f"fields.{name}.{key} = {limit!r}: must be a number")
    if low >= high:
        raise ConfigError(f"fields.{name}: from {low} to {high}: is empty: must have from below to")
    log, steps = values.get("log", False), values.get("steps")
    if not isinstance(log, bool):
        raise ConfigError(f"fields.{name}.log = {log!r}: must be true or false")
    if log and low <= 0:
        raise ConfigError(f"fields.{name}: from {low}: must be above 0 with log")
    if steps is not None and (isinstance(steps, bool) or not isinstance(steps, int) or not 2 <= steps <= STEPS_MAX):
        raise ConfigError(f"fields.{name}.steps = {steps!r}: must be a whole number from 2 to {STEPS_MAX:,}")
    _check_limits(name, (low, high))
    return Axis(name, (), low, high, log, steps)


def _check_limits(name: str, values: Sequence[Any]) -> None:
    """Raise ConfigError for a value that no configuration can have."""
    allowed = limits(name)
    if allowed is None:
        return
    low, high, meaning = allowed
    for value in values:
        wanted = int if isinstance(low, int) else (int, float)
        if isinstance(value, bool) or not isinstance(value, wanted) or not low <= value <= high:
            raise ConfigError(f"fields.{name}: {value!r}: must be from {span(low, high)} ({meaning})")


def grid(axes: Sequence[Axis]) -> Iterator[Point]:
    """Every combination, the last axis fastest.

    Raises:
        ConfigError: more than `RUNS_MAX`, or a range without steps.
    """
    values = [axis.grid() for axis in axes]
    count = math.prod(len(own) for own in values)
    if count > RUNS_MAX:
        raise ConfigError(f"method = 'grid': {count:,} points: must be at most {RUNS_MAX:,}")
    return (dict(zip((axis.name for axis in axes), point, strict=True)) for point in itertools.product(*values))


def uniform(axes: Sequence[Axis], samples: int, seed: int) -> Iterator[Point]:
    """Independent points; the first ones are the same for any number of samples."""
    rng = np.random.default_rng(seed)
    for _ in range(samples):
        shares = rng.random(len(axes))
        yield {axis.name: axis.at(float(share)) for axis, share in zip(axes, shares, strict=True)}


def latin(axes: Sequence[Axis], samples: int, seed: int) -> Iterator[Point]:
    """A Latin hypercube: of each axis, one point in each of `samples` parts."""
    rng = np.random.default_rng(seed)
    shares = np.stack([(rng.permutation(samples) + rng.random(samples)) / samples for _ in axes], axis=-1)
    for row in np.minimum(shares, 1 - 1e-12):
        yield {axis.name: axis.at(float(share)) for axis, share in zip(axes, row, strict=True)}
