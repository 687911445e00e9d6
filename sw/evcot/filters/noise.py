# SPDX-License-Identifier: Apache-2.0
"""The least levels of noise at which an event needs more neighbours: docs/filters.md, "Support that follows the noise"."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .contract import CELL_LOG2, LEVEL_FRAC, LEVEL_MAX, NOISE_SUPPORTS

__all__ = ["thresholds"]


def thresholds(within_us: float, passing_hz: float, window_us: float) -> list[int]:
    """The least levels of noise at which an event needs 2, 3, ... 6 neighbours, so that at most `passing_hz` a pixel passes.

    Events of noise in the 8 neighbours within the time have a Poisson distribution. A level counts events per cell of 8 x 8
    pixels and longest window, in 1/256.

    Args:
        within_us: time of the activity filter.
        passing_hz: events of noise that may pass, per pixel and second.
        window_us: length of the longest window.
    """
    rates_hz = np.geomspace(1e-4, 1e4, 80_001)  # per pixel, in steps of 0.02 %
    mean = 8e-6 * rates_hz * within_us
    at_least, exactly = np.ones_like(mean), np.exp(-mean)
    found = []
    for neighbours in NOISE_SUPPORTS:
        at_least = at_least - exactly  # the probability of as many events, one fewer than `neighbours`
        exactly = exactly * mean / (neighbours - 1)
        found.append(_least(rates_hz, rates_hz * at_least > passing_hz, window_us))
    return found


def _least(rates_hz: NDArray[np.float64], passes: NDArray[np.bool_], window_us: float) -> int:
    if not passes.any():
        return LEVEL_MAX
    level = rates_hz[np.argmax(passes)] * 1e-6 * window_us * (1 << (2 * CELL_LOG2 + LEVEL_FRAC))
    return int(min(max(round(level), 1), LEVEL_MAX))
