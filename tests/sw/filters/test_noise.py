# SPDX-License-Identifier: Apache-2.0
"""The rate of noise, by windows, and the neighbours that it asks for."""

from __future__ import annotations

import math

import numpy as np
import pytest

from evcot.filters.noise import WINDOW_US, NoiseRate, support_against

WIDTH, HEIGHT = 346, 260
SEED = 20260


def measured(noise_hz: float, windows: int = 60, block: tuple[int, int] | None = None) -> float:
    """The rate after so many windows of Poisson noise; in a block of the sensor every pixel sends an event besides."""
    random = np.random.default_rng(SEED)
    rate = NoiseRate(WIDTH, HEIGHT)
    for _ in range(windows):
        count = random.poisson(noise_hz * 1e-6 * WINDOW_US * WIDTH * HEIGHT)
        x, y = random.integers(WIDTH, size=count), random.integers(HEIGHT, size=count)
        rate.add(x.astype(np.uint16), y.astype(np.uint16), np.ones(count, np.bool_))
        if block is not None:
            rows, columns = np.mgrid[: block[0], : block[1]].astype(np.uint16)
            rate.add(columns.ravel(), rows.ravel(), np.ones(rows.size, np.bool_))
        rate.close()
    assert rate.hz is not None
    return rate.hz


@pytest.mark.parametrize("noise_hz", [0.01, 0.1, 1.0, 5.0, 20.0])
def test_the_rate_of_noise_alone(noise_hz: float) -> None:
    assert measured(noise_hz) == pytest.approx(noise_hz, rel=0.12)


@pytest.mark.parametrize("noise_hz", [0.1, 1.0, 5.0])
def test_objects_that_cover_a_tenth_of_the_sensor_change_it_little(noise_hz: float) -> None:
    assert measured(noise_hz, block=(80, 112)) == pytest.approx(noise_hz, rel=0.2)


def test_unknown_until_the_first_window_ends_and_only_events_that_are_kept_count() -> None:
    rate = NoiseRate(16, 16)
    assert rate.hz is None
    some = np.arange(16, dtype=np.uint16)
    rate.add(some, some, np.zeros(16, np.bool_))
    rate.close()
    assert rate.hz == 0.0


def test_windows_without_an_event_are_windows_without_noise() -> None:
    one, other = NoiseRate(32, 32), NoiseRate(32, 32)
    for rate in (one, other):
        for _ in range(30):
            rate.add(np.array([3], np.uint16), np.array([5], np.uint16), np.ones(1, np.bool_))
            rate.close()
    before = one.hz
    one.close(4)
    for _ in range(4):
        other.close()
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
