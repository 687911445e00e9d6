# SPDX-License-Identifier: Apache-2.0
"""The rate of noise, measured while a stream goes on; and how many neighbours an activity filter then needs."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from .._numba_private import step
from ..bits import count

__all__ = ["MANY_EMPTY", "WINDOW_US", "NoiseRate", "close", "median_pixels", "note", "rate_of", "support_against"]

WINDOW_US = 20_000
_CELL_BITS = 3  # cells of 8 x 8 pixels: a word each
_LASTING = 20  # windows, after which one counts no more
MANY_EMPTY = 0.3  # share of the cells, from which on their number says how much noise there is
_MEDIAN_ABOVE = 0.17  # the mean of a Poisson distribution lies about a sixth above its median, in proportion within a count
_EMPTIEST = 0.05  # share of the pixels without an event, below which it tells nothing
_MOST_NEIGHBOURS = 6
_HZ, _SHARE, _WINDOWS = range(3)  # of the state


class NoiseRate:
    """Events per pixel and second of the background, from the pixels that sent any in windows of `WINDOW_US`.

    It is the mean of the windows so far, or one that the last 0.4 s have most weight in. Cells with moving objects hold more
    than noise: if many cells are empty, those with one pixel are compared with these, since cells with objects are of neither
    kind; else the median over the cells counts. About 2 ns per event.

    Compiled functions write down pixels with `note`, and end windows with `close`; both need its tables.

    Attributes:
        pixels: uint64, a word for each cell: the pixels that sent an event in the open window.
        state: (3,) float64: the rate, the share of the newest window in it, and the number of windows so far.
    """

    def __init__(self, width: int, height: int) -> None:
        side = 1 << _CELL_BITS
        self.pixels = np.zeros((-(-height // side), -(-width // side)), np.uint64)
        self.state = np.array([0.0, 1.0, 0.0])

    @property
    def hz(self) -> float | None:
        """The estimate; None before the end of the first window."""
        return float(self.state[_HZ]) if self.state[_WINDOWS] else None


@step
def note(pixels: Any, x: int, y: int) -> None:
    """A pixel has sent an event."""
    bit = ((y & 7) << 3) | (x & 7)
    pixels[y >> _CELL_BITS, x >> _CELL_BITS] |= np.uint64(1) << np.uint64(bit)


@njit(cache=True, nogil=True)
def close(pixels: Any, state: Any, windows: int) -> float:
    """End the window, and `windows` - 1 after it that held no event; returns the rate, in Hz."""
    rate = _rate(pixels, 1e-6 * WINDOW_US)
    pixels[:] = 0
    state[_HZ] += state[_SHARE] * (rate - state[_HZ])
    state[_SHARE] = max(state[_SHARE] / (1.0 + state[_SHARE]), 1.0 / _LASTING)  # at first the mean of all
    state[_HZ] *= (1.0 - state[_SHARE]) ** (windows - 1)
    state[_WINDOWS] += windows
    return float(state[_HZ])


@njit(cache=True, nogil=True)
def support_against(noise_hz: float, within_us: float, passing_hz: float) -> int:
    """The fewest of eight neighbours that noise must have sent events in, so that at most `passing_hz` a pixel of it passes.

    The events of the neighbours within that time have a Poisson distribution; none is needed of noise that is less already.
    """
    by_chance = 8e-6 * noise_hz * within_us
    exactly = np.exp(-by_chance)  # the probability of as many events as neighbours
    at_least = 1.0
    for neighbours in range(_MOST_NEIGHBOURS):
        if noise_hz * at_least <= passing_hz:
            return neighbours
        at_least -= exactly
        exactly *= by_chance / (neighbours + 1)
    return _MOST_NEIGHBOURS


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
