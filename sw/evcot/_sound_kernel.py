# SPDX-License-Identifier: Apache-2.0
"""Kernels: whether events are valid."""

from __future__ import annotations

import numpy as np

from ._numba_private import njit

__all__ = ["first_fault", "is_sound"]


@njit(cache=True, nogil=True)
def is_sound(t_us, x, y, p, after_us, width, height):  # type: ignore[no-untyped-def]
    """Whether all events are valid: one reduction per column, which the compiler vectorises."""
    x_max, y_max, p_max = np.uint16(0), np.uint16(0), np.uint8(0)
    for value in x:
        x_max = max(x_max, value)
    for value in y:
        y_max = max(y_max, value)
    for value in p:
        p_max = max(p_max, value)
    backwards = 0
    for i in range(1, len(t_us)):
        backwards += t_us[i] < t_us[i - 1]
    return len(t_us) == 0 or (t_us[0] >= after_us and backwards == 0 and x_max < width and y_max < height and p_max <= 1)


@njit(cache=True, nogil=True)
def first_fault(t_us, x, y, p, after_us, width, height):  # type: ignore[no-untyped-def]
    """Index of the first event with a decreasing time, an address outside the sensor or an invalid polarity."""
    last = after_us
    for i in range(len(t_us)):
        if (t_us[i] < last) | (x[i] >= width) | (y[i] >= height) | (p[i] > 1):
            return i
        last = t_us[i]
    return len(t_us)
