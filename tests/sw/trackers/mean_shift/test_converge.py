# SPDX-License-Identifier: Apache-2.0
"""The hybrid mean shift compared with its equations, written out in NumPy; and the error of joining points."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.trackers.mean_shift.kernel import converge

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


def equations(points: Floats, bandwidth_px: float, fold_px: float) -> tuple[Floats, int]:
    """All pairs, all points at once: where the points end, and how many shifts it took."""
    n = points.shape[1]
    z, weight, moving, ends = points.copy(), np.ones(n), np.ones(n, bool), np.arange(n)
    if fold_px:
        z, weight, moving, ends = together(z, weight, moving, fold_px)
    original, mass, now = z[:2].copy(), weight, np.arange(z.shape[1])
    shifts = iterations = 0
    while moving.any() and iterations < 50:
        iterations += 1
        shifts += int(moving.sum())
        others = np.concatenate((original, z[2:, now]))
        d2 = ((z[:, :, None] - others[:, None, :]) ** 2).sum(0)
        w = mass * np.exp(-d2 / (2 * bandwidth_px**2)) * (d2 <= (3 * bandwidth_px) ** 2)
        total = w.sum(1)
        there = (w @ others.T).T / np.where(total > 0, total, 1)
        there = np.where(moving & (total > 0), there, z)
        moving &= ((there - z) ** 2).sum(0) > (bandwidth_px / 40) ** 2
        z = there
        if fold_px and moving.any():
            z, weight, moving, into = together(z, weight, moving, fold_px)
            now, ends = into[now], into[ends]
    return z[:, ends], shifts


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


def packet(seed: int, n: int = 200, size: int = 120) -> Floats:
    """Events of three rings, and noise, at pixels; polarity 0 or 2, time within 4."""
    random = np.random.default_rng(seed)
    ring, angle = random.integers(0, 3, n), random.uniform(0, 2 * np.pi, n)
    x, y = (random.uniform(20, size - 20, 3)[ring] + 8 * wave(angle) for wave in (np.cos, np.sin))
    noise = random.random(n) < 0.1
    x, y = (np.where(noise, random.uniform(0, size, n), axis) for axis in (x, y))
    return np.stack((np.rint(x), np.rint(y), 2.0 * random.integers(0, 2, n), np.sort(random.uniform(0, 4, n))))


@pytest.mark.parametrize("fold_px", [0.0, 0.7123, 3.1416])  # sides that no place is a multiple of: there, rounding would decide
@pytest.mark.parametrize("bandwidth_px", [2.0, 6.0, 15.0])
@pytest.mark.parametrize("seed", range(3))
def test_the_equations_to_1e_9(seed: int, bandwidth_px: float, fold_px: float) -> None:
    points = packet(seed)
    expected, shifts = equations(points, bandwidth_px, fold_px)
    mode_of, modes, evaluations, pairs = converge(points, bandwidth_px, fold_px)
    np.testing.assert_allclose(modes[:, mode_of], expected, rtol=0, atol=1e-9)
    if fold_px == 0:
        assert pairs == shifts * points.shape[1]
    assert 0 < evaluations < pairs or bandwidth_px > 10


@pytest.mark.parametrize("seed", range(3))
def test_folding_saves_most_evaluations_and_moves_modes_little(seed: int) -> None:
    points = packet(seed)
    plain_of, plain, many, _ = converge(points, 10.0, 0.0)
    folded_of, folded, few, _ = converge(points, 10.0, 2.5)
    assert few < 0.4 * many
    off = np.hypot(*(folded[:, folded_of] - plain[:, plain_of])[:2])
    assert np.median(off) < 0.6
    assert np.quantile(off, 0.95) < 2.0


def test_single_points_stay() -> None:
    points = np.array([[3.0, 60_000.0], [4.0, 60_000.0], [0.0, 2.0], [1.0, 1.0]])
    mode_of, modes, _, _ = converge(points, 6.0, 0.0)
    np.testing.assert_allclose(modes[:, mode_of], points, atol=1e-12)
