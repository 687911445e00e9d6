# SPDX-License-Identifier: Apache-2.0
"""Kernel steps: the natural logarithm, in the same bits on every machine, and a fast exponential."""

from __future__ import annotations

import math

import numpy as np

from .._numba_private import step

__all__ = ["exponential", "logarithm"]

_SQRT_HALF = 0x3FE6A09E667F3BCD  # the bits of sqrt(1/2)
_LN2_HIGH, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
_LOG2_E = 1.0 / math.log(2.0)
_LOG = (  # coefficients of (log((1 + s) / (1 - s)) - 2 s) / s in powers of s^2
    6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01, 2.222219843214978396e-01,
    1.818357216161805012e-01, 1.531383769920937332e-01, 1.479819860511658591e-01,
)  # fmt: skip


@step
def logarithm(value):  # type: ignore[no-untyped-def]
    """Natural logarithm of a positive normal number, to less than an ulp: fdlibm's method.

    A value is 2^k z with z from sqrt(1/2) to sqrt(2); with f = z - 1 and s = f / (2 + f), log z = log((1 + s) / (1 - s)).
    """
    bits = np.float64(value).view(np.int64)
    k = (bits - _SQRT_HALF) >> 52
    f = np.int64(bits - (k << 52)).view(np.float64) - 1.0
    s = f / (2.0 + f)  # never divides by 0: z is at least sqrt(1/2)
    w = s * s
    q = w * w
    odd = w * (_LOG[0] + q * (_LOG[2] + q * (_LOG[4] + q * _LOG[6])))
    even = q * (_LOG[1] + q * (_LOG[3] + q * _LOG[5]))
    half = 0.5 * f * f
    return k * _LN2_HIGH - ((half - (s * (half + odd + even) + k * _LN2_LOW)) - f)


@step
def exponential(value):  # type: ignore[no-untyped-def]
    """e^value to a relative error of 1e-8, for values from -700 to 700: 2^k times a Taylor polynomial of the rest."""
    k = np.floor(value * _LOG2_E + 0.5)
    r = value - k * (_LN2_HIGH + _LN2_LOW)
    s = r * r
    low, high = 1.0 + r + s * (1 / 2 + r * (1 / 6)), 1 / 24 + r * (1 / 120) + s * (1 / 720 + r * (1 / 5040))
    return np.int64((np.int64(k) + 1023) << 52).view(np.float64) * (low + s * s * high)
