# SPDX-License-Identifier: Apache-2.0
"""Which pixels never rest, epoch by epoch; and the rate of noise by the pixels in cells."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.trackers.adaptive import restless
from support.interpreted import interpret


@pytest.fixture(autouse=True)
def _interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    interpret(monkeypatch)


def told(epochs: list[int]) -> list[bool]:
    """Whether a pixel rests, at an event in each of these epochs."""
    noted = np.zeros((4, 5), np.int32)
    said = [restless.rests(noted, 3, 2, epoch) for epoch in epochs]
    assert np.flatnonzero(noted).tolist() == [13]
    return said


def test_epochs_last_65_ms_from_the_first_event() -> None:
    assert [restless.epoch_of(7 + us, 7) for us in (0, 65_535, 65_536, 655_360)] == [3, 3, 4, 13]
    assert restless.epoch_of(((1 << 23) - 3) << 16, 0) == 0, "numbers begin again after 2^23 - 1"


def test_a_pixel_that_sends_in_eleven_epochs_in_a_row_does_not_rest() -> None:
    assert told(list(range(3, 16))) == [True] * 10 + [False] * 3
    assert told([3, 3, 3, *range(4, 16)]) == [True] * 12 + [False] * 3, "several events in an epoch are one"


def test_one_silent_epoch_at_a_time_is_forgiven_and_two_are_rest() -> None:
    misses = [*range(3, 8), *range(9, 16)]
    assert told(misses) == [True] * 11 + [False], "but does not count"
    assert told([*range(3, 14), 16]) == [True] * 10 + [False, True]
    assert told([*range(3, 14), 15]) == [True] * 10 + [False, False]


def test_counts_end_at_255() -> None:
    assert told(list(range(3, 403)))[10:] == [False] * 390


def test_the_pixels_that_do_not_rest_now() -> None:
    noted = np.array([[13 << 8 | 10, 13 << 8 | 9, 11 << 8 | 10, 10 << 8 | 10, 0, 12 << 8 | 255]], np.int32)
    t_us = 10 << 16  # epoch 13
    assert restless.restless(noted, t_us + 5, 5).tolist() == [[True, False, True, False, False, True]]


@pytest.mark.parametrize(
    ("counts", "median"),
    [
        ({0: 2, 1: 4, 2: 2}, 1 + 0.5 - 2 / 4 + 0.17),  # the middle of those with one pixel
        ({0: 3, 3: 3}, 0 + 0.5 - 0 + 0.17),
        ({1: 1, 5: 7}, 5 + 0.5 - 4 / 7 + 0.17),
        ({64: 4}, 64 + 0.5 - 0.5 + 0.17),
    ],
)
def test_the_median_of_pixels_in_cells(counts: dict[int, int], median: float) -> None:
    table = np.zeros(65, np.int64)
    table[list(counts)] = list(counts.values())
    assert restless.median_pixels(table, sum(counts.values())) == pytest.approx(median)


def test_the_rate_of_noise_that_leaves_so_many_pixels() -> None:
    assert restless.rate_of(64 * (1 - np.exp(-0.02 * 3.0)), 0.02) == pytest.approx(3.0)
    assert restless.rate_of(0.0, 0.02) == 0.0
    assert restless.rate_of(64.0, 0.02) == restless.rate_of(61.0, 0.02) == pytest.approx(-np.log(0.05) / 0.02)
