# SPDX-License-Identifier: Apache-2.0
"""Mean shift clustering of events in packets, with tracking across them.

Each packet is clustered independently: `kernel` moves its points to their modes, `clusters` fuses the modes to clusters.
In the log `radius` is half the side of the cluster's window, `n_ev` its events in the packet, `support` those in all packets.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ...events import Events
from ..detections.stream import DetectionTracker
from .clusters import cluster, event_points
from .config import MeanShiftConfig

__all__ = ["MeanShiftTracker"]

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
