# SPDX-License-Identifier: Apache-2.0
"""Mean shift, compiled: the hybrid iteration of the paper's equations 1 and 2.

A point i is z_i = [x, y, p, f], in pixels, f(t) = exp(-dt / tau). In every iteration

    w_ij = w_j K(|[x_i, y_i] - [x_j0, y_j0]|^2 + |[p_i, f_i] - [p_j, f_j]|^2),    K(d^2) = exp(-d^2 / (2 h^2)),
    [x_i, y_i] <- sum_j w_ij [x_j0, y_j0] / sum_j w_ij,    [p_i, f_i] <- sum_j w_ij [p_j, f_j] / sum_j w_ij,

all points at once: positions are compared with the original ones, polarity and time with those of the previous iteration.

Optimisations:

- K is 0 beyond three bandwidths. Points are stored in strips of that height, sorted by x within a strip, so that the
  neighbours of a position are in three runs. Each sum omits less than exp(-9 / 2) per point.
- K within three bandwidths is a polynomial with an error below 1e-13.
- A point that moves by no more than h / 40 has converged and is not computed again.
- Points in one cell of the four-dimensional grid of `fold_px` are joined to one trajectory at their mean: events of one pixel
  before the first iteration, and later all points that meet.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import njit

__all__ = ["converge"]

Table = NDArray[Any]

_CUTOFF = 3.0  # bandwidths
_TOLERANCE = 1 / 40  # bandwidths
_ITERATIONS_MAX = 50


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract", "nsz"})
def _sums(
    x: Table, y: Table, p: Table, f: Table, w: Table, begin: int, end: int,
    at_x: float, at_y: float, at_p: float, at_f: float, narrow: float, reach: float,
) -> Any:  # fmt: skip
    """Sums of weight and of weighted coordinates over a run of points; `narrow` = 1 / (2 h^2), `reach` the squared cutoff."""
    s_w = s_x = s_y = s_p = s_f = 0.0
    first: Any = np.uint64(begin)  # unsigned: avoids the check for negative indices
    for j in range(first, np.uint64(end)):
        dx = x[j] - at_x
        dy = y[j] - at_y
        dp = p[j] - at_p
        df = f[j] - at_f
        d2 = dx * dx + dy * dy + dp * dp + df * df
        # exp(-u) = exp(-u / 64)^64; u / 64 is at most 0.29, for which eight terms of the series suffice.
        v = d2 * (-narrow / 64.0)
        e = 1.0 + v * (1 / 7)
        e = 1.0 + v * (1 / 6) * e
        e = 1.0 + v * (1 / 5) * e
        e = 1.0 + v * (1 / 4) * e
        e = 1.0 + v * (1 / 3) * e
        e = 1.0 + v * (1 / 2) * e
        e = 1.0 + v * e
        for _ in range(6):
            e = e * e
        e = e * w[j] if d2 <= reach else 0.0
        s_w += e
        s_x += e * x[j]
        s_y += e * y[j]
        s_p += e * p[j]
        s_f += e * f[j]
    return s_w, s_x, s_y, s_p, s_f


@njit(cache=True, nogil=True)
def _fold(z: Table, weight: Table, moving: Table, side: float, into: Table) -> int:
    """Join those of the m trajectories that share a cell, in place; `into` gets the new index of each; returns their number.

    z: (4, m), weight: (m,), moving: (m,) whether it has not yet converged, into: (m,).
    """
    m = len(weight)
    size = 16
    while size < 2 * m:
        size *= 2
    table = np.full(size, -1, np.int64)
    cells = np.empty((4, m), np.int64)
    n = 0
    for i in range(m):
        a, b = np.int64(np.floor(z[0, i] / side)), np.int64(np.floor(z[1, i] / side))
        c, d = np.int64(np.floor(z[2, i] / side)), np.int64(np.floor(z[3, i] / side))
        at = (((a * 1_000_003 + b) * 1_000_003 + c) * 1_000_003 + d) & (size - 1)
        while True:
            k = table[at]
            if k < 0 or (cells[0, k] == a and cells[1, k] == b and cells[2, k] == c and cells[3, k] == d):
                break
            at = (at + 1) & (size - 1)
        if k < 0:
            table[at] = k = n
            n += 1
            cells[0, k], cells[1, k], cells[2, k], cells[3, k] = a, b, c, d
            for axis in range(4):
                z[axis, k] = z[axis, i]
            weight[k] = weight[i]
            moving[k] = moving[i]
        else:
            total = weight[k] + weight[i]
            for axis in range(4):
                z[axis, k] += (z[axis, i] - z[axis, k]) * (weight[i] / total)
            weight[k] = total
            moving[k] |= moving[i]
        into[i] = k
    return n


@njit(cache=True, nogil=True)
def _in_strips(z: Table, top: float, height_px: float) -> tuple[Table, Table]:
    """The order of points by strip of y and then by x, and the index at which each strip begins."""
    strip = ((z[1] - top) / height_px).astype(np.int64)
    order = np.argsort(z[0], kind="mergesort")
    order = order[np.argsort(strip[order], kind="mergesort")]
    return order, np.searchsorted(strip[order], np.arange(strip.max() + 2))


@njit(cache=True, nogil=True)
def converge(points: Table, bandwidth_px: float, fold_px: float) -> tuple[Table, Table, int, int]:
    """Move points to their modes.

    Args:
        points: (4, n) x, y, p, f in pixels; n at least 1.
        bandwidth_px: h.
        fold_px: side of the cells in which points are joined; 0 for never.

    Returns:
        (n,) int64, the trajectory of each point; (4, m) the final positions of the trajectories; kernel evaluations made; and
        evaluations without a cutoff, of every moving trajectory with every original point.
    """
    n = points.shape[1]
    z, weight = points.copy(), np.ones(n)
    moving = np.ones(n, np.bool_)
    mode_of = np.arange(n)
    into = np.empty(n, np.int64)
    m = _fold(z, weight, moving, fold_px, mode_of) if fold_px > 0.0 else n

    reach_px = _CUTOFF * bandwidth_px
    tolerance_px = _TOLERANCE * bandwidth_px
    narrow, reach = 0.5 / bandwidth_px**2, reach_px * reach_px
    top = z[1, :m].min()
    order, strips = _in_strips(z[:, :m], top, reach_px)
    x, y, w = z[0][order], z[1][order], weight[order]
    source = order.copy()  # the trajectory of each of these
    originals = m

    shifts = evaluations = iterations = 0
    going = True
    while going and iterations < _ITERATIONS_MAX:
        going = False
        iterations += 1
        p, f = z[2][source], z[3][source]
        for i in range(m):
            if not moving[i]:
                continue
            shifts += 1
            at = z[:, i]
            s_w = s_x = s_y = s_p = s_f = 0.0
            strip: Any = np.int64((at[1] - top) / reach_px)
            for s in range(max(strip - 1, 0), min(strip + 2, len(strips) - 1)):
                run = x[strips[s] : strips[s + 1]]
                begin = strips[s] + np.searchsorted(run, at[0] - reach_px)
                end = strips[s] + np.searchsorted(run, at[0] + reach_px)
                if begin < end:
                    a, b, c, d, e = _sums(x, y, p, f, w, begin, end, at[0], at[1], at[2], at[3], narrow, reach)
                    s_w += a
                    s_x += b
                    s_y += c
                    s_p += d
                    s_f += e
                    evaluations += end - begin
            moving[i] = False
            if s_w > 0.0:
                to_x, to_y, to_p, to_f = s_x / s_w, s_y / s_w, s_p / s_w, s_f / s_w
                way = (to_x - at[0]) ** 2 + (to_y - at[1]) ** 2 + (to_p - at[2]) ** 2 + (to_f - at[3]) ** 2
                moving[i] = way > tolerance_px * tolerance_px
                going |= moving[i]
                # p and f of others are read from the copies that were made before: this point may change at once.
                at[0], at[1], at[2], at[3] = to_x, to_y, to_p, to_f
        if fold_px > 0.0 and going:
            m = _fold(z[:, :m], weight[:m], moving[:m], fold_px, into[:m])
            source, mode_of = into[source], into[mode_of]
    return mode_of, z[:, :m].copy(), evaluations, shifts * originals
