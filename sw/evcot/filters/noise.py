# SPDX-License-Identifier: Apache-2.0
"""The rate of noise, measured while a stream goes on; and how many neighbours an activity filter then needs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .._numba_private import step
from ..bits import count

__all__ = ["MANY_EMPTY", "WINDOW_US", "NoiseRate", "median_pixels", "rate_of", "support_against"]

WINDOW_US = 20_000
_CELL_BITS = 3  # cells of 8 x 8 pixels: a word each
_LASTING = 20  # windows, after which one counts no more
MANY_EMPTY = 0.3  # share of the cells, from which on their number says how much noise there is
_MEDIAN_ABOVE = 0.17  # the mean of a Poisson distribution lies about a sixth above its median, in proportion within a count
_EMPTIEST = 0.05  # share of the pixels without an event, below which it tells nothing
_MOST_NEIGHBOURS = 6


class NoiseRate:
    """Events per pixel and second of the background, from the pixels that sent any in windows of `WINDOW_US`.

    It is the mean of the windows so far, or one that the last 0.4 s have most weight in. Cells with moving objects hold more
    than noise: if many cells are empty, those with one pixel are compared with these, since cells with objects are of neither
    kind; else the median over the cells counts. About 2 ns per event.

    Attributes:
        hz: the estimate; None before the end of the first window.
    """

    def __init__(self, width: int, height: int) -> None:
        side = 1 << _CELL_BITS
        self._pixels = np.zeros((-(-height // side), -(-width // side)), np.uint64)
        self._share = 1.0  # of the newest window
        self.hz: float | None = None

    def add(self, x: NDArray[np.uint16], y: NDArray[np.uint16], keep: NDArray[np.bool_]) -> None:
        """Add events of the open window, those of the mask, (n,) bool; all lie on the sensor."""
        _add(self._pixels, x, y, keep)

    def close(self, windows: int = 1) -> None:
        """End the window, and `windows` - 1 after it that held no event."""
        rate = _rate(self._pixels, 1e-6 * WINDOW_US)
        self._pixels[:] = 0
        hz = 0.0 if self.hz is None else self.hz
        self.hz = hz + self._share * (rate - hz)
        self._share = max(self._share / (1.0 + self._share), 1.0 / _LASTING)  # at first the mean of all
        self.hz *= (1.0 - self._share) ** (windows - 1)


def support_against(noise_hz: float, within_us: float, passing_hz: float) -> int:
    """The fewest of eight neighbours that noise must have sent events in, so that at most `passing_hz` a pixel of it passes.

    The events of the neighbours within that time have a Poisson distribution; none is needed of noise that is less already.
    """
    by_chance = 8e-6 * noise_hz * within_us
    enough = (n for n in range(_MOST_NEIGHBOURS) if noise_hz * _at_least(n, by_chance) <= passing_hz)
    return next(enough, _MOST_NEIGHBOURS)


def _at_least(count: int, mean: float) -> float:
    """The probability of at least so many events, of a Poisson distribution with that mean."""
    return 1.0 - sum(math.exp(-mean) * mean**number / math.factorial(number) for number in range(count))


@njit(cache=True, nogil=True)
def _add(pixels, x, y, keep):  # type: ignore[no-untyped-def]
    for i in range(len(keep)):
        if keep[i]:
            bit = ((y[i] & 7) << 3) | (x[i] & 7)
            pixels[y[i] >> _CELL_BITS, x[i] >> _CELL_BITS] |= np.uint64(1) << np.uint64(bit)


@step
def median_pixels(counts: Any, cells: int) -> float:
    """The mean number of pixels in a cell by the median over all: cells with objects hold more.

    Args:
        counts: (65,) int64, number of cells with so many pixels.
        cells: their sum.
    """
    below, k = counts[0], 0
    while below < 0.5 * cells:
        k += 1
        below += counts[k]
    # Within the median's own count, in proportion.
    return float(k + 0.5 - (below - 0.5 * cells) / max(counts[k], 1) + _MEDIAN_ABOVE)


@step
def rate_of(pixels: float, window_s: float) -> float:
    """Events per pixel and second that leave so many of a cell's pixels with one event or more in a window, on average."""
    return float(-np.log(max(1.0 - pixels / 64.0, _EMPTIEST)) / window_s)


@njit(cache=True, nogil=True)
def _rate(pixels, window_s):  # type: ignore[no-untyped-def]
    counts = np.zeros(65, np.int64)
    for row in range(pixels.shape[0]):
        for column in range(pixels.shape[1]):
            counts[count(pixels[row, column])] += 1
    cells = pixels.size
    if counts[0] < MANY_EMPTY * cells:
        return rate_of(median_pixels(counts, cells), window_s)
    return rate_of(min(counts[1] / counts[0], -np.log(counts[0] / cells)), window_s)
