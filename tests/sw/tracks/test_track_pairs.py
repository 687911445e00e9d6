# SPDX-License-Identifier: Apache-2.0
"""Optimal assignment, and the same merges in two logs."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.tracks import track_pairs
from evcot.tracks.timeline import MERGE
from evcot.tracks.track_pairs import best_pairs, closest_pairs, pair_merges


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


def test_assignment_is_that_of_scipy_without_importing_its_package() -> None:
    program = """
import sys
import numpy as np
from evcot.tracks.track_pairs import assignment
gains = [np.random.default_rng(seed).integers(0, 4, (5, 7)).astype(float) for seed in range(50)]
found = [assignment(gain) for gain in gains]
assert "scipy.optimize" not in sys.modules
from scipy.optimize import linear_sum_assignment
for gain, pairs in zip(gains, found, strict=True):
    np.testing.assert_array_equal(pairs, linear_sum_assignment(gain, maximize=True))
"""
    subprocess.run([sys.executable, "-c", program], check=True)


RADIUS_PX, TOLERANCE_US = 6.0, 500


def random_merges(rng: np.random.Generator, count: int) -> NDArray[np.void]:
    merges = np.zeros(count, MERGE)
    merges["t_us"] = np.sort(rng.integers(0, 100 * count, count))
    merges["track_id"] = rng.permutation(count)
    merges["x"], merges["y"] = rng.random((2, count)) * 12
    return merges


def all_at_once(hw: NDArray[np.void], sw: NDArray[np.void]) -> list[tuple[int, int]]:
    late_us = sw["t_us"] - hw["t_us"][:, None]
    distance_px = np.hypot(sw["x"] - hw["x"][:, None], sw["y"] - hw["y"][:, None])
    i, j = np.nonzero((np.abs(late_us) <= TOLERANCE_US) & (distance_px <= RADIUS_PX))
    chosen = closest_pairs(i, j, np.abs(late_us[i, j]) / TOLERANCE_US + distance_px[i, j] / RADIUS_PX)
    return list(zip(i[chosen].tolist(), j[chosen].tolist(), strict=True))


@pytest.mark.parametrize("run", [1, 7, 1 << 14])
@pytest.mark.parametrize("seed", range(4))
def test_runs_do_not_matter(seed: int, run: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(track_pairs, "_RUN", run)
    rng = np.random.default_rng(seed)
    hw, sw = (random_merges(rng, count) for count in rng.integers(60, 120, 2))
    wanted = all_at_once(hw, sw)
    assert 10 < len(wanted) < min(len(hw), len(sw))
    found = pair_merges(hw, sw, RADIUS_PX, TOLERANCE_US, None)
    assert list(zip(found.pairs["i"].tolist(), found.pairs["j"].tolist(), strict=True)) == wanted
    assert found.count == len(wanted)
    assert found.pairs["hardware_id"].tolist() == [hw["track_id"][i] for i, _ in wanted]
    assert found.pairs["software_id"].tolist() == [sw["track_id"][j] for _, j in wanted]
    assert found.hardware_alone.tolist() == np.delete(hw["track_id"], [i for i, _ in wanted]).tolist()
    assert found.software_alone.tolist() == np.delete(sw["track_id"], [j for _, j in wanted]).tolist()
    first = pair_merges(hw, sw, RADIUS_PX, TOLERANCE_US, 5)
    assert first.count == len(wanted)
    assert np.array_equal(first.pairs, found.pairs[:5])
    assert first.hardware_alone.tolist() == found.hardware_alone[:5].tolist()
    assert first.software_alone.tolist() == found.software_alone[:5].tolist()


def test_a_side_without_merges_leaves_the_other_alone() -> None:
    merges, none = random_merges(np.random.default_rng(1), 9), np.empty(0, MERGE)
    assert pair_merges(none, merges, RADIUS_PX, TOLERANCE_US, None).software_alone.tolist() == merges["track_id"].tolist()
    assert pair_merges(merges, none, RADIUS_PX, TOLERANCE_US, None).hardware_alone.tolist() == merges["track_id"].tolist()
