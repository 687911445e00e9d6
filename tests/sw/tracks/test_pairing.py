# SPDX-License-Identifier: Apache-2.0
"""Optimal pairing, compared with an exhaustive search."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.tracks.pairing import best_pairs, closest_pairs


def every_pairing(left: NDArray[np.int64], right: NDArray[np.int64]) -> list[list[int]]:
    """All sets of pairs in which no element stands twice."""
    pairings: list[list[int]] = [[]]
    for k in range(len(left)):
        pairings += [[*p, k] for p in pairings if all(left[k] != left[q] and right[k] != right[q] for q in p)]
    return pairings


def random_pairs(seed: int) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    rng = np.random.default_rng(seed)
    allowed = rng.permutation(30)[: rng.integers(1, 13)]  # of 6 x 5
    return allowed // 5 + 100, allowed % 5, rng.random(len(allowed))


@pytest.mark.parametrize("seed", range(40))
def test_best_pairs_gain_the_most(seed: int) -> None:
    left, right, gain = random_pairs(seed)
    chosen = best_pairs(left, right, gain).tolist()
    pairings = every_pairing(left, right)
    assert chosen in pairings
    assert gain[chosen].sum() == pytest.approx(max(gain[p].sum() for p in pairings))


@pytest.mark.parametrize("seed", range(40))
def test_closest_pairs_are_as_many_as_possible_then_as_cheap_as_possible(seed: int) -> None:
    left, right, cost = random_pairs(seed)
    chosen = closest_pairs(left, right, cost).tolist()
    pairings = every_pairing(left, right)
    assert chosen in pairings
    most = max(len(p) for p in pairings)
    assert len(chosen) == most
    assert cost[chosen].sum() == pytest.approx(min(cost[p].sum() for p in pairings if len(p) == most))


def test_one_close_pair_gives_way_to_two_that_are_farther_apart() -> None:
    left, right = np.array([0, 0, 1]), np.array([0, 1, 0])
    assert closest_pairs(left, right, np.array([0.1, 9.0, 9.0])).tolist() == [1, 2]
    assert best_pairs(left, right, np.array([9.0, 1.0, 1.0])).tolist() == [0]


def test_equal_costs_of_nothing_still_pair() -> None:
    assert closest_pairs(np.array([0, 1]), np.array([0, 1]), np.zeros(2)).tolist() == [0, 1]


def test_nothing_to_pair() -> None:
    none = np.empty(0, np.int64)
    assert len(best_pairs(none, none, none.astype(np.float64))) == len(closest_pairs(none, none, none.astype(np.float64))) == 0
