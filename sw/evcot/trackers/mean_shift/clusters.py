# SPDX-License-Identifier: Apache-2.0
"""Compiled clustering of a frame's events: points, their modes, and fusion of modes to clusters."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..frame_based.kernel import DETECTION
from .kernel import Cost, Iteration, converge

__all__ = ["Coordinates", "event_points", "fuse", "group", "pixel_points"]

Table = NDArray[Any]

_WINDOW = 1.5  # half a cluster's side, in standard deviations of its points: from a filled square's 1.7 to an outline's 1.2
_BEYOND = 0.05  # share of a cluster's points beyond each side of its box


class Coordinates(NamedTuple):
    """The settings of `config.MeanShiftConfig` that define points and clusters."""

    polarity_px: float
    time_px: float
    tau_us: float
    fuse_px: float
    points_min: int


@njit(cache=True, nogil=True)
def event_points(ts: Table, xs: Table, ys: Table, ps: Table, scale: Coordinates) -> tuple[Table, Table]:
    """Points of n events: (4, n) x, y, p, f in pixels, f by the time before the last event; and (n,) us after the first."""
    n = len(ts)
    points, after_us = np.empty((4, n)), np.empty(n)
    for e in range(n):
        points[0, e] = xs[e]
        points[1, e] = ys[e]
        points[2, e] = scale.polarity_px * ps[e]
        points[3, e] = scale.time_px * np.exp((ts[e] - ts[-1]) / scale.tau_us)
        after_us[e] = ts[e] - ts[0]
    return points, after_us


@njit(cache=True, nogil=True)
def pixel_points(ts: Table, xs: Table, ys: Table, ps: Table, scale: Coordinates) -> tuple[Table, Table]:
    """Points of n pixels with events: (4, n) x, y, mean polarity, 0; and (n,) the mean time of all events after the first,
    since a frame has no finer timing."""
    address = np.empty(len(ts), np.int64)
    mean_us = 0.0
    for e in range(len(ts)):
        address[e] = np.int64(ys[e]) << 16 | np.int64(xs[e])
        mean_us += (ts[e] - ts[0]) / len(ts)
    order = np.argsort(address, kind="mergesort")
    points = np.zeros((4, len(ts)))
    n = 0
    fired = 0
    for k in range(len(order)):
        e = order[k]
        if k == 0 or address[e] != address[order[k - 1]]:
            points[0, n] = xs[e]
            points[1, n] = ys[e]
            n += 1
            fired = 0
        fired += 1
        points[2, n - 1] += (scale.polarity_px * ps[e] - points[2, n - 1]) / fired
    return points[:, :n].copy(), np.full(n, mean_us)


@njit(cache=True, nogil=True)
def fuse(mode_of: Table, modes: Table, fuse_px: float) -> tuple[Table, int]:
    """The cluster of each of n points, and the number of clusters.

    The mode with the most points is the centre of a cluster and absorbs all modes at a distance of at most `fuse_px`; this is
    repeated with the remaining modes.
    """
    m = modes.shape[1]
    points = np.zeros(m, np.int64)
    for mode in mode_of:
        points[mode] += 1
    middle = np.empty(m, np.int64)
    cluster = np.empty(m, np.int64)
    n = 0
    for mode in np.argsort(-points, kind="mergesort"):
        k = 0
        while k < n:
            dx, dy = modes[0, mode] - modes[0, middle[k]], modes[1, mode] - modes[1, middle[k]]
            if dx * dx + dy * dy <= fuse_px * fuse_px:
                break
            k += 1
        if k == n:
            middle[n] = mode
            n += 1
        cluster[mode] = k
    return cluster[mode_of], n


@njit(cache=True, nogil=True)
def _side_px(places: Table) -> float:
    """Side of a box around the pixels of points, along an axis, but for the outermost at both ends."""
    places = np.sort(places)
    out = int(_BEYOND * len(places))
    return float(places[len(places) - 1 - out] - places[out] + 1.0)


@njit(cache=True, nogil=True)
def _describe(points: Table, after_us: Table, cluster: Table, n: int, points_min: int, out: Table, at: int) -> int:
    """Write the clusters with enough points to `out` from index `at` on; returns the index after the last."""
    sums = np.zeros((n, 5))
    for i in range(len(cluster)):
        row = sums[cluster[i]]
        x, y = points[0, i], points[1, i]
        row[0] += 1.0
        row[1] += x
        row[2] += y
        row[3] += x * x + y * y
        row[4] += after_us[i]
    begin = np.zeros(n + 1, np.int64)
    begin[1:] = np.cumsum(sums[:, 0])
    ordered = np.argsort(cluster, kind="mergesort")
    for k in range(n):
        count = sums[k, 0]
        if count < points_min:
            continue
        x, y = sums[k, 1] / count, sums[k, 2] / count
        found = out[at]
        found.x = x
        found.y = y
        found.radius = _WINDOW * np.sqrt(max(sums[k, 3] / count - x * x - y * y, 0.0) / 2.0)
        own = ordered[begin[k] : begin[k + 1]]
        found.width = _side_px(points[0][own])
        found.height = _side_px(points[1][own])
        found.after_us = sums[k, 4] / count
        found.n = np.int64(count)
        at += 1
    return at


@njit(cache=True, nogil=True)
def group(
    rules: Iteration, scale: Coordinates, of_pixels: bool, ts: Table, xs: Table, ys: Table, ps: Table, frames: Table,
) -> tuple[Table, Cost]:  # fmt: skip
    """Cluster each frame independently, and set its range of clusters in `frames`; returns (d,) `DETECTION` and the cost."""
    out = np.zeros(64, DETECTION)
    points_all = shifts = iterations = evaluations = pairs = 0
    at: Any = np.int64(0)  # no constant, for which Numba would compile `_describe` once more
    for frame in frames:
        part = slice(frame.begin, frame.end)
        if of_pixels:
            points, after_us = pixel_points(ts[part], xs[part], ys[part], ps[part], scale)
        else:
            points, after_us = event_points(ts[part], xs[part], ys[part], ps[part], scale)
        mode_of, modes, cost = converge(rules, points, np.ones(points.shape[1]))
        points_all += cost.points
        shifts += cost.shifts
        iterations += cost.iterations
        evaluations += cost.evaluations
        pairs += cost.pairs
        cluster, n = fuse(mode_of, modes, scale.fuse_px)
        while at + n > len(out):
            more = np.zeros(2 * len(out), DETECTION)
            more[:at] = out[:at]
            out = more
        frame.found = at
        at = _describe(points, after_us, cluster, n, scale.points_min, out, at)
        frame.found_end = at
    return out[:at], Cost(points_all, shifts, iterations, evaluations, pairs)
