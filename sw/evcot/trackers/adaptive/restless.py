# SPDX-License-Identifier: Apache-2.0
"""Pixels that never rest, hot ones or in the light of a lamp that flickers; the rate of noise."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import step

__all__ = ["EPOCH_BITS", "MANY_EMPTY", "epoch_of", "median_pixels", "rate_of", "restless", "rests"]


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


Table = NDArray[Any]

EPOCH_BITS = 16  # an epoch lasts 2^16 us
_FIRST = 3  # number of the first epoch: a pixel that has sent nothing was last noted in epoch 0
_RESTLESS = 10  # epochs in a row
_COUNT_BITS = 8
_MOST = (1 << _COUNT_BITS) - 1
_EPOCHS = (1 << (31 - _COUNT_BITS)) - 1  # mask of an epoch's number: six days, then it begins again


@step
def epoch_of(t_us: int, first_us: int) -> int:
    """The number of the epoch that holds a time; `first_us` is that of the first event."""
    return (_FIRST + ((t_us - first_us) >> EPOCH_BITS)) & _EPOCHS


def restless(noted: NDArray[np.int32], t_us: int, first_us: int) -> NDArray[np.bool_]:
    """The pixels that do not rest, (height, width), at a time; `noted` as in `rests`."""
    epoch = (_FIRST + ((t_us - first_us) >> EPOCH_BITS)) & _EPOCHS
    lately = ((epoch - (noted >> _COUNT_BITS)) & _EPOCHS) <= 2
    mask: NDArray[np.bool_] = lately & ((noted & _MOST) >= _RESTLESS)
    return mask


@step
def rests(noted: Table, x: int, y: int, epoch: int) -> bool:
    """Note an event of a pixel; returns whether it was silent in one of the last ten epochs, or in two in a row before.

    Args:
        noted: (height, width) int32; of each pixel the last epoch in which it sent an event, and in the low bits for how many
            in a row it has done so, one miss forgiven each time.
        epoch: the number of the open epoch.
    """
    last = int(noted[y, x])
    since = (epoch - (last >> _COUNT_BITS)) & _EPOCHS
    count = last & _MOST
    count = min(count + (1 if since == 1 else 0), _MOST) if since <= 2 else 0
    noted[y, x] = (epoch << _COUNT_BITS) | count
    return bool(count < _RESTLESS)
