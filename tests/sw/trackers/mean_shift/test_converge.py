# SPDX-License-Identifier: Apache-2.0
"""The hybrid mean shift against its equations, written out in NumPy; and the error of its optimisations."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.trackers.mean_shift.kernel import Cost, Iteration, converge

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

PLAIN = Iteration(bandwidth_px=6.0, cutoff=3.0, tolerance_px=0.05, max_iterations=60, fold_px=0.0)


def equations(points: Floats, weights: Floats, rules: Iteration) -> tuple[Floats, int, int]:
    """All pairs, all points at once: where the points end, and how many shifts and iterations it took."""
    z, weight, moving = points.copy(), weights, np.ones(points.shape[1], bool)
    ends = np.arange(points.shape[1])
    if rules.fold_px:
        z, weight, moving, ends = together(z, weight, moving, rules.fold_px)
    original, mass, now = z[:2].copy(), weight, np.arange(z.shape[1])
    shifts = iterations = 0
    while moving.any() and iterations < rules.max_iterations:
        iterations += 1
        shifts += int(moving.sum())
        others = np.concatenate((original, z[2:, now]))
        d2 = ((z[:, :, None] - others[:, None, :]) ** 2).sum(0)
        w = mass * np.exp(-d2 / (2 * rules.bandwidth_px**2)) * (d2 <= (rules.cutoff * rules.bandwidth_px) ** 2)
        total = w.sum(1)
        there = (w @ others.T).T / np.where(total > 0, total, 1)
        there = np.where(moving & (total > 0), there, z)
        moving &= ((there - z) ** 2).sum(0) > rules.tolerance_px**2
        z = there
        if rules.fold_px and moving.any():
            z, weight, moving, into = together(z, weight, moving, rules.fold_px)
            now, ends = into[now], into[ends]
    return z[:, ends], shifts, iterations


def together(z: Floats, weight: Floats, moving: Bools, side: float) -> tuple[Floats, Floats, Bools, NDArray[np.int64]]:
    """What shares a cell is one, at the mean; it moves if any of it does."""
    cells: dict[tuple[float, ...], list[int]] = {}
    for i, cell in enumerate(np.floor(z / side).T.tolist()):
        cells.setdefault(tuple(cell), []).append(i)
    groups = list(cells.values())
    into = np.empty(len(weight), np.int64)
    for k, group in enumerate(groups):
        into[group] = k
    means = [np.average(z[:, group], axis=1, weights=weight[group]) for group in groups]
    return (
        np.stack(means, axis=1),
        np.array([weight[group].sum() for group in groups]),
        np.array([moving[group].any() for group in groups]),
        into,
    )


def packet(seed: int, n: int = 200, size: int = 120) -> tuple[Floats, Floats]:
    """Events of three rings, and noise, at pixels; polarity 0 or 2, time within 4."""
    random = np.random.default_rng(seed)
    ring, angle = random.integers(0, 3, n), random.uniform(0, 2 * np.pi, n)
    x, y = (random.uniform(20, size - 20, 3)[ring] + 8 * wave(angle) for wave in (np.cos, np.sin))
    noise = random.random(n) < 0.1
    x, y = (np.where(noise, random.uniform(0, size, n), axis) for axis in (x, y))
    points = np.stack((np.rint(x), np.rint(y), 2.0 * random.integers(0, 2, n), np.sort(random.uniform(0, 4, n))))
    return points, np.ones(n)


def run(points: Floats, weights: Floats, rules: Iteration) -> tuple[Floats, Cost]:
    """Where each point ends, (4, n)."""
    mode_of, modes, cost = converge(rules, points, weights)
    return modes[:, mode_of], Cost(*cost)


@pytest.mark.parametrize("fold_px", [0.0, 0.7123, 3.1416])  # sides that no place is a multiple of: there, rounding would decide
@pytest.mark.parametrize("bandwidth_px", [2.0, 6.0, 15.0])
@pytest.mark.parametrize("seed", range(4))
def test_the_equations_to_1e_9(seed: int, bandwidth_px: float, fold_px: float) -> None:
    points, _ = packet(seed)
    weights = np.random.default_rng(seed).uniform(0.5, 2.0, points.shape[1])
    rules = PLAIN._replace(bandwidth_px=bandwidth_px, fold_px=fold_px)
    expected, shifts, iterations = equations(points, weights, rules)
    ends, cost = run(points, weights, rules)
    np.testing.assert_allclose(ends, expected, rtol=0, atol=1e-9)
    assert (cost.shifts, cost.iterations) == (shifts, iterations)
    if fold_px == 0:
        assert cost.pairs == shifts * points.shape[1]
    assert 0 < cost.evaluations < cost.pairs or bandwidth_px > 10


def test_polarity_and_time_are_compared_as_updated_and_places_as_they_were() -> None:
    """Two points: after one iteration places have moved by the original distance, polarities too; a second tells them apart."""
    points = np.array([[0.0, 4.0], [0.0, 0.0], [0.0, 3.0], [0.0, 0.0]])
    h2 = 2 * PLAIN.bandwidth_px**2
    first = np.exp(-(4**2 + 3**2) / h2)
    x1, p1 = 4 * first / (1 + first), 3 * first / (1 + first)
    ends, _ = run(points, np.ones(2), PLAIN._replace(max_iterations=1))
    np.testing.assert_allclose(ends[[0, 2], 0], [x1, p1], atol=1e-12)
    q = 3 - 2 * p1  # between the updated polarities, which moved alike from both sides
    here, there = np.exp(-(x1**2) / h2), np.exp(-((4 - x1) ** 2 + q**2) / h2)
    ends, _ = run(points, np.ones(2), PLAIN._replace(max_iterations=2))
    np.testing.assert_allclose(ends[0, 0], 4 * there / (here + there), atol=1e-12)
    np.testing.assert_allclose(ends[2, 0], (p1 * here + (3 - p1) * there) / (here + there), atol=1e-12)


@pytest.mark.parametrize("cutoff", [2.0, 3.0, 4.0, 6.0])
def test_what_a_cutoff_leaves_out_is_bounded(cutoff: float) -> None:
    """One shift moves by at most (sum of the weights left out) / (sum of the others) times the farthest point's distance."""
    points, weights = packet(1)
    whole, _, _ = equations(points, weights, PLAIN._replace(cutoff=1e3, max_iterations=1))
    ends, _ = run(points, weights, PLAIN._replace(cutoff=cutoff, max_iterations=1))
    away = np.sqrt(((points[:, :, None] - points[:, None, :]) ** 2).sum(0))
    left_out = (away > cutoff * PLAIN.bandwidth_px).sum(1) * np.exp(-(cutoff**2) / 2)
    off = np.hypot(*(ends - whole)[:2])
    assert (off <= left_out * away.max(1)).all()  # a point's own weight is 1, so that the sum of the others is not less
    assert off.max() > 0


def test_events_of_one_pixel_are_one_point_of_their_weight() -> None:
    points, _ = packet(2, 60)
    points[3] = 0.25
    twice = np.repeat(points, 3, axis=1)
    folding = PLAIN._replace(fold_px=0.5, max_iterations=1)
    ends, cost = run(twice, np.ones(180), folding)
    assert (cost.points, cost.shifts) == (180, len(np.unique(points, axis=1).T))
    expected, _, _ = equations(points, np.full(60, 3.0), folding)
    # After the iteration the ends are folded too: each lies within its cell.
    assert (np.abs(ends[:, ::3] - expected) <= 0.5).all()


@pytest.mark.parametrize("seed", range(3))
def test_folding_on_the_way_saves_most_and_moves_modes_little(seed: int) -> None:
    points, weights = packet(seed)
    rules = PLAIN._replace(bandwidth_px=10.0)
    plain, cost = run(points, weights, rules)
    folded, less = run(points, weights, rules._replace(fold_px=2.0))
    assert less.evaluations < 0.4 * cost.evaluations
    off = np.hypot(*(folded - plain)[:2])
    assert np.median(off) < 0.5
    assert np.quantile(off, 0.95) < 2.0


def test_one_point_stays_and_two_far_apart_do() -> None:
    points = np.array([[3.0, 60_000.0], [4.0, 60_000.0], [0.0, 2.0], [1.0, 1.0]])
    for n in (1, 2):
        ends, cost = run(points[:, :n].copy(), np.ones(n), PLAIN)
        np.testing.assert_allclose(ends, points[:, :n], atol=1e-12)
        assert cost.shifts == n


def test_the_clusters_that_scikit_learn_finds() -> None:
    """Its kernel is flat: on blobs that lie apart both find the same ones, with about the same middles."""
    cluster = pytest.importorskip("sklearn.cluster")
    random = np.random.default_rng(4)
    middles = np.array([[30, 30], [90, 40], [50, 100], [120, 110]])
    blob = random.integers(0, 4, 240)
    place = np.rint(middles[blob] + random.normal(0, 3, (240, 2)))
    theirs = cluster.MeanShift(bandwidth=12.0).fit(place)
    points = np.concatenate((place.T, np.zeros((2, 240))))
    ends, _ = run(points, np.ones(240), PLAIN)
    ours = np.array([np.hypot(*(middles - end).T).argmin() for end in ends[:2].T])
    pairs = {(int(a), int(b)) for a, b in zip(ours, theirs.labels_, strict=True)}
    assert len(pairs) == 4
    for a, b in pairs:
        assert np.hypot(*(ends[:2, ours == a].mean(1) - theirs.cluster_centers_[b])) < 1.0
