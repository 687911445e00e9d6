# SPDX-License-Identifier: Apache-2.0
"""The rate of noise from the pixels of cells of 8 x 8 that sent an event in a window."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..._numba_private import step

__all__ = ["MANY_EMPTY", "median_pixels", "rate_of"]

MANY_EMPTY = 0.3  # share of the cells, from which on their number says how much noise there is
_MEDIAN_ABOVE = 0.17  # the mean of a Poisson distribution lies about a sixth above its median, in proportion within a count
_EMPTIEST = 0.05  # share of the pixels without an event, below which it tells nothing


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
