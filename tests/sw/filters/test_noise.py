# SPDX-License-Identifier: Apache-2.0
"""The rate of noise, by windows, and the neighbours that it asks for."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from evcot.filters.noise import WINDOW_US, NoiseRate, close, note, support_against

WIDTH, HEIGHT = 346, 260
SEED = 20260


@njit
def _note(pixels, x, y):  # type: ignore[no-untyped-def]
    for i in range(len(x)):
        note(pixels, x[i], y[i])


def add(rate: NoiseRate, x: NDArray[np.int64], y: NDArray[np.int64]) -> None:
    """Events of these pixels, in the open window."""
    _note(rate.pixels, x, y)


def end(rate: NoiseRate, windows: int = 1) -> None:
    """The window ends, and so many more without an event."""
    assert close(rate.pixels, rate.state, windows) == rate.hz


def measured(noise_hz: float, windows: int = 60, block: tuple[int, int] | None = None) -> float:
    """The rate after so many windows of Poisson noise; in a block of the sensor every pixel sends an event besides."""
    random = np.random.default_rng(SEED)
    rate = NoiseRate(WIDTH, HEIGHT)
    for _ in range(windows):
        count = random.poisson(noise_hz * 1e-6 * WINDOW_US * WIDTH * HEIGHT)
        x, y = random.integers(WIDTH, size=count), random.integers(HEIGHT, size=count)
        add(rate, x, y)
        if block is not None:
            rows, columns = np.mgrid[: block[0], : block[1]]
            add(rate, columns.ravel(), rows.ravel())
        end(rate)
    assert rate.hz is not None
    return rate.hz


@pytest.mark.parametrize("noise_hz", [0.01, 0.1, 1.0, 5.0, 20.0])
def test_the_rate_of_noise_alone(noise_hz: float) -> None:
    assert measured(noise_hz) == pytest.approx(noise_hz, rel=0.12)


@pytest.mark.parametrize("noise_hz", [0.1, 1.0, 5.0])
def test_objects_that_cover_a_tenth_of_the_sensor_change_it_little(noise_hz: float) -> None:
    assert measured(noise_hz, block=(80, 112)) == pytest.approx(noise_hz, rel=0.2)


def test_unknown_until_the_first_window_ends() -> None:
    rate = NoiseRate(16, 16)
    assert rate.hz is None
    end(rate)
    assert rate.hz == 0.0


def test_windows_without_an_event_are_windows_without_noise() -> None:
    one, other = NoiseRate(32, 32), NoiseRate(32, 32)
    for rate in (one, other):
        for _ in range(30):
            add(rate, np.array([3]), np.array([5]))
            end(rate)
    before = one.hz
    end(one, 4)
    for _ in range(4):
        end(other)
    assert one.hz is not None
    assert before is not None
    assert one.hz == pytest.approx(other.hz)
    assert one.hz == pytest.approx(before * 0.95**4)


def test_as_few_neighbours_as_let_no_more_noise_pass() -> None:
    within_us, passing_hz = 40_000, 0.03
    last = 0
    for noise_hz in np.geomspace(0.01, 3.0, 200):
        support = support_against(noise_hz, within_us, passing_hz)
        assert support >= last, "it grows with the noise"
        mean = 8 * noise_hz * 1e-6 * within_us
        passing = [
            noise_hz * (1 - sum(math.exp(-mean) * mean**k / math.factorial(k) for k in range(n))) for n in range(support + 1)
        ]
        assert passing[support] <= passing_hz
        assert all(more > passing_hz for more in passing[:support])
        last = support
    assert last == 5
    assert support_against(1e3, within_us, passing_hz) == 6, "no more than six of eight"
