# SPDX-License-Identifier: Apache-2.0
"""Draws: recordings without a tenth of their events, so that a figure is a mean with its standard error, and not one chance.

What is lost depends on the seed set and the number of the draw alone. Two trackers are compared on equal draws.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from field.member import Member
from field.transforms import thinned

__all__ = ["LOST", "Difference", "Estimate", "differences", "drawn", "estimate", "marking", "mean_difference", "mean_of"]

LOST = 0.1  # share of the events
FIXED = "traffic, space", "traffic, time", "traffic, crowd", "pendulum, recorded", "hand, recorded"  # equal in every seed set
_NOISE_OR_LOSS = "traffic, loss and noise"  # of the same recording
_SELECTED_ON = frozenset((1, 2, 21, 22, 71, 81, 93, 100, 101))  # seed sets (docs/defaults.md)

Values = Mapping[str, Mapping[int | None, float]]  # member -> draw -> a figure


class Estimate(NamedTuple):
    """A mean, and its standard error by the chance of the draws; NaN with a single draw."""

    mean: float
    error: float

    def __str__(self) -> str:
        return f"{self.mean:.3f}" if np.isnan(self.error) else f"{self.mean:.3f} ± {self.error:.3f}"


class Difference(NamedTuple):
    """A mean of paired differences, and its standard errors.

    Attributes:
        error: by the chance of the draws: whether these recordings differ.
        others: by the scatter of the recordings' means: whether other recordings of the kind would. NaN for a single one.
    """

    mean: float
    error: float
    others: float

    def __str__(self) -> str:
        errors = "".join(f" ± {error:.3f}" for error in (self.error, self.others) if not np.isnan(error))
        return f"{self.mean:+.3f}{errors}"


def drawn(member: Member, seed_set: int, draw: int | None) -> Member:
    """The member in one draw; None: with all its events."""
    return member if draw is None else thinned(member, LOST, (seed_set, 11, draw))


def marking(family: str, seed_sets: Iterable[int]) -> str:
    """Whether the family of these seed sets is validation, which selected defaults, or test."""
    selected = family in (*FIXED, _NOISE_OR_LOSS) or not _SELECTED_ON.isdisjoint(seed_sets)
    return "validation" if selected else "test"


def estimate(values: Values) -> Estimate:
    """The mean over the members, each of which has draws of its own."""
    own = [np.array(list(draws.values())) for draws in values.values()]
    variances = [np.var(one, ddof=1) / len(one) if len(one) > 1 else np.nan for one in own]
    return Estimate(float(np.mean([np.mean(one) for one in own])), float(np.sqrt(np.sum(variances)) / len(own)))


def mean_of(families: Iterable[Estimate]) -> Estimate:
    """The mean over families."""
    means, errors = np.array(list(families)).T
    return Estimate(float(np.mean(means)), float(np.sqrt(np.sum(errors**2)) / len(errors)))


def differences(now: Mapping[str, Values], before: Mapping[str, Values]) -> dict[str, Difference]:
    """Of each family in both: how much a figure has grown on equal members and draws."""
    found = {}
    for family, members in now.items():
        both = {}
        for name, draws in members.items():
            own = before.get(family, {}).get(name, {})
            grown = {draw: value - own[draw] for draw, value in draws.items() if draw in own}
            if grown:
                both[name] = grown
        if both:
            means = [float(np.mean(list(grown.values()))) for grown in both.values()]
            found[family] = Difference(*estimate(both), _scatter(means))
    return found


def mean_difference(families: Iterable[Difference]) -> Difference:
    """The mean over families; `others` is by the scatter of the families."""
    own = list(families)
    return Difference(*mean_of(Estimate(one.mean, one.error) for one in own), _scatter([one.mean for one in own]))


def _scatter(means: Sequence[float]) -> float:
    return float(np.std(means, ddof=1) / np.sqrt(len(means))) if len(means) > 1 else float("nan")
