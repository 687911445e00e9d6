# SPDX-License-Identifier: Apache-2.0
"""Kalman filter of one axis of a box: centre, velocity, half side, growth; corrected by the number of events beyond a side.

A side is defined by a share `quantile` of the object's events lying beyond it. With n of N events beyond, the side is off by
(n / N - quantile) / f, where f is the density of events at the side, with variance quantile (1 - quantile) / (N f^2). This
holds for any N, whereas the sample quantile of few events would lie too far inside.
"""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from ..._numba_private import step

__all__ = ["correct", "predict"]

Table = NDArray[Any]


@step
def predict(s: Table, p: Table, dt: float, velocity_walk: float, growth_walk: float) -> None:
    """Predict one axis' state (4,) and covariance (4, 4) by dt seconds: velocity and growth are random walks."""
    s[0] += dt * s[1]
    s[2] += dt * s[3]
    for k in range(4):
        p[0, k] += dt * p[1, k]
        p[2, k] += dt * p[3, k]
    for k in range(4):
        p[k, 0] += dt * p[k, 1]
        p[k, 2] += dt * p[k, 3]
    for at, walk in ((0, velocity_walk), (2, growth_walk)):
        q = walk * walk * dt
        p[at, at] += q * dt * dt / 3.0
        p[at, at + 1] += q * dt / 2.0
        p[at + 1, at] += q * dt / 2.0
        p[at + 1, at + 1] += q


@step
def correct(s: Table, p: Table, sign: float, off_px: float, variance: float) -> None:
    """Update with a measurement of the side centre + sign * half that is `off_px` above the estimate."""
    row = (p[0, 0] + sign * p[2, 0], p[0, 1] + sign * p[2, 1], p[0, 2] + sign * p[2, 2], p[0, 3] + sign * p[2, 3])
    total = row[0] + sign * row[2] + variance
    for i in range(4):
        gain = row[i] / total
        s[i] += gain * off_px
        for k in range(4):
            p[i, k] -= gain * row[k]
