# SPDX-License-Identifier: Apache-2.0
"""Points that Optuna chooses from the results of earlier ones, in batches (its interface "ask and tell").

A batch has a fixed number of points, whose results are told in the order in which the points were asked for. So the points
depend on specification and results alone, not on the number of workers, and a sweep that resumes asks for the same ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from evcot.errors import ConfigError

from .axes import Axis, Point
from .spec import Spec
from .task import canonical

__all__ = ["Asker"]


class Asker:
    """The study of one engine.

    Args:
        spec: axes, objectives, seed.

    Raises:
        ConfigError: Optuna is not installed.
    """

    def __init__(self, spec: Spec) -> None:
        try:
            import optuna
        except ImportError as error:
            raise ConfigError("method = 'optuna': is not installed: must be: pip install 'evcot[sweep]'") from error
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        self._optuna = optuna
        self._axes = {axis.name: axis for axis in spec.axes}
        directions = ["maximize" if direction == "max" else "minimize" for direction in spec.objectives.values()]
        sampler = optuna.samplers.TPESampler(seed=spec.sampling_seed)
        self._study = optuna.create_study(directions=directions, sampler=sampler)
        self._space = {name: self._distribution(axis) for name, axis in self._axes.items()}
        self._asked: list[Any] = []

    def ask(self, count: int) -> list[Point]:
        """The next points."""
        self._asked = [self._study.ask(self._space) for _ in range(count)]
        return [{name: self._value(name, trial.params[name]) for name in self._space} for trial in self._asked]

    def tell(self, results: Sequence[Sequence[float] | None]) -> None:
        """The objectives of the points that were asked for last, in their order; None for one that has none."""
        for trial, values in zip(self._asked, results, strict=True):
            if values is None:
                self._study.tell(trial, state=self._optuna.trial.TrialState.FAIL)
            else:
                self._study.tell(trial, list(values))

    def _distribution(self, axis: Axis) -> Any:
        made = self._optuna.distributions
        if axis.choices:  # as text, for choices may be lists
            return made.CategoricalDistribution([canonical(value) for value in axis.choices])
        if axis.whole:
            return made.IntDistribution(int(axis.low), int(axis.high), log=axis.log)
        return made.FloatDistribution(float(axis.low), float(axis.high), log=axis.log)

    def _value(self, name: str, value: Any) -> Any:
        axis = self._axes[name]
        if axis.choices:
            return next(choice for choice in axis.choices if canonical(choice) == value)
        return value if axis.whole else axis.rounded(value)
