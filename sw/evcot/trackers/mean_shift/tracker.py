# SPDX-License-Identifier: Apache-2.0
"""Mean shift clustering of events in packets, with tracking across them.

Each packet is clustered independently: `kernel` moves its points to their modes, `clusters` fuses the modes to clusters.
In the log `radius` is half the side of the cluster's window, `n_ev` its events in the packet, `support` those in all packets.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.trackers.detections import DETECTION, DetectionTracker, IdentityConfig

from ..._numba_private import njit
from ...events import Events
from ...ranges import Range, check_ranges, ranges_of, setting
from .kernel import converge

__all__ = [
    "MEAN_SHIFT_RANGES",
    "POLARITY_PX",
    "PRESETS",
    "MeanShiftConfig",
    "MeanShiftTracker",
    "cluster",
    "event_points",
    "fuse",
]


Table = NDArray[Any]

POLARITY_PX = 2.0  # distance of the two polarities
_TIME_PX = 2.0  # distance of a current and a very old event
_TAU_US = 10_000.0  # time constant with which an event ages

_WINDOW = 1.5  # half a cluster's side, in standard deviations of its points: from a filled square's 1.7 to an outline's 1.2
_BEYOND = 0.05  # share of a cluster's points beyond each side of its box


@njit(cache=True, nogil=True)
def event_points(ts: Table, xs: Table, ys: Table, ps: Table) -> tuple[Table, Table]:
    """Points of n events: (4, n) x, y, p, f in pixels, f by the time before the last event; and (n,) us after the first."""
    n = len(ts)
    points, after_us = np.empty((4, n)), np.empty(n)
    for e in range(n):
        points[0, e] = xs[e]
        points[1, e] = ys[e]
        points[2, e] = POLARITY_PX * ps[e]
        points[3, e] = _TIME_PX * np.exp((ts[e] - ts[-1]) / _TAU_US)
        after_us[e] = ts[e] - ts[0]
    return points, after_us


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
def cluster(points: Table, after_us: Table, bandwidth_px: float, fold_px: float, points_min: int) -> tuple[Table, int, int]:
    """Cluster (4, n) points with their times; returns (d,) `DETECTION`, and both numbers of evaluations of `converge`.

    Modes at most one bandwidth apart are one cluster.
    """
    mode_of, modes, evaluations, pairs = converge(points, bandwidth_px, fold_px)
    member, n = fuse(mode_of, modes, bandwidth_px)
    sums = np.zeros((n, 5))
    for i in range(len(member)):
        row = sums[member[i]]
        x, y = points[0, i], points[1, i]
        row[0] += 1.0
        row[1] += x
        row[2] += y
        row[3] += x * x + y * y
        row[4] += after_us[i]
    found = np.zeros(n, DETECTION)
    d = 0
    for k in range(n):
        count = sums[k, 0]
        if count < points_min:
            continue
        x, y = sums[k, 1] / count, sums[k, 2] / count
        one = found[d]
        one.x = x
        one.y = y
        one.radius = _WINDOW * np.sqrt(max(sums[k, 3] / count - x * x - y * y, 0.0) / 2.0)
        one.width = _side_px(points[0][member == k])
        one.height = _side_px(points[1][member == k])
        one.after_us = sums[k, 4] / count
        one.n = np.int64(count)
        d += 1
    return found[:d], evaluations, pairs


@dataclass(frozen=True)
class MeanShiftConfig(IdentityConfig):
    """Settings of mean shift clustering.

    Raises:
        ConfigError: a value outside its range.
    """

    packet_events: int = setting(300, 1, 1_000_000, "maximum number of events in a packet")
    bandwidth_px: float = setting(
        6.0, 0.1, 1000.0, "h, the kernel's standard deviation; modes at most this far apart are one cluster"
    )
    points_min: int = setting(8, 1, 1_000_000, "minimum number of events of a cluster")

    def __post_init__(self) -> None:
        check_ranges("mean_shift", self)


MEAN_SHIFT_RANGES: dict[str, Range] = ranges_of(MeanShiftConfig)


PRESETS: dict[str, MeanShiftConfig] = {
    # A contour of about 20 px: from a bandwidth of 0.7 of its radius on, its centre is a single mode.
    "discs": MeanShiftConfig(visible_hits=5, packet_events=300, bandwidth_px=8.0, points_min=8),
    # Vehicles of 25 to 90 px: the smallest must not be fused, the largest not split.
    "traffic": MeanShiftConfig(
        gate_px=25.0, smoothing_us=30_000, visible_hits=10, packet_events=500, bandwidth_px=18.0, points_min=15
    ),
}


_PACKET_US = 20_000  # longest packet
_CANDIDATE_US = 20_000


class MeanShiftTracker(DetectionTracker):
    """Streaming tracker by mean shift clustering.

    Attributes:
        fold_px: side of the cells in which points are joined on their way; 0 for never.
        evaluations: kernel evaluations so far.
        pairs: evaluations if every moving point were compared with every point of its packet.
    """

    def __init__(self, config: MeanShiftConfig) -> None:
        super().__init__(config, _CANDIDATE_US)
        self.config = config
        self.fold_px = config.bandwidth_px / 4
        self.evaluations = self.pairs = 0

    def frame_ends(self, t_us: NDArray[np.int64]) -> NDArray[np.int64]:
        """See `DetectionTracker.frame_ends`: a packet ends with its last event, or before one that comes too late for it."""
        return _packet_ends(t_us, self.config.packet_events)

    def points(self, events: Events) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """See `clusters.event_points`."""
        return event_points(events.t_us, events.x, events.y, events.p)

    def detect(self, events: Events) -> NDArray[np.void]:
        """Cluster a packet."""
        points, after_us = self.points(events)
        rules = float(self.config.bandwidth_px), float(self.fold_px), self.config.points_min
        found, evaluations, pairs = cluster(points, after_us, *rules)
        self.evaluations += evaluations
        self.pairs += pairs
        return found


@njit(cache=True, nogil=True)
def _packet_ends(ts: NDArray[Any], packet_events: int) -> NDArray[np.int64]:
    ends = np.empty(len(ts), np.int64)
    n = begin = 0
    for e in range(len(ts)):
        if ts[e] - ts[begin] >= _PACKET_US:
            ends[n] = begin = e
            n += 1
        if e + 1 - begin == packet_events:
            ends[n] = begin = e + 1
            n += 1
    return ends[:n]
