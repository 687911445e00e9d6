# SPDX-License-Identifier: Apache-2.0
"""Kernel step: the natural logarithm, in the same bits on every machine."""

from __future__ import annotations

import numpy as np

from .._numba_private import step

__all__ = ["logarithm"]

_SQRT_HALF = 0x3FE6A09E667F3BCD  # the bits of sqrt(1/2)
_LN2_HIGH, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
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
