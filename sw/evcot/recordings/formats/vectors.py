# SPDX-License-Identifier: Apache-2.0
"""Vector words: neighbouring pixels of a row as the set bits of a mask, leftmost pixel in the lowest bit."""

from __future__ import annotations

import numpy as np

from ..._numba_private import step

__all__ = ["put_vector"]

# A de Bruijn sequence: the five top bits of its product with 2^i are different for every i from 0 to 31.
_DE_BRUIJN = 0x077CB531
_LOWEST = np.zeros(32, np.int64)
_LOWEST[[(_DE_BRUIJN << i & 0xFFFFFFFF) >> 27 for i in range(32)]] = np.arange(32)


@step
def put_vector(n, mask, time_us, left, row, polarity, t_us, x, y, p):  # type: ignore[no-untyped-def]
    """Write an event for each set bit of `mask`, an int64 below 2^32, from index `n` on; returns the index after the last."""
    while mask:
        lowest = mask & -mask
        t_us[n] = time_us
        x[n] = left + _LOWEST[(lowest * _DE_BRUIJN & 0xFFFFFFFF) >> 27]
        y[n] = row
        p[n] = polarity
        n += 1
        mask ^= lowest
    return n
