# SPDX-License-Identifier: Apache-2.0
"""Mean shift clustering of events in packets, or of pixels in frames, with tracking across them.

Each packet is clustered independently (`kernel` moves its points to their modes, `clusters` fuses the modes to clusters), and
clusters are tracked by optimal assignment (`evcot.trackers.frame_based.identity`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...events import Events, Recording
from ...tracks.log import TrackLog
from ...tracks.tracking import track_recording
from ..frame_based.framing import Framing
from ..frame_based.stream import DetectionTracker
from .clusters import Coordinates, group
from .config import MeanShiftConfig
from .kernel import Cost, Iteration

__all__ = ["MeanShiftTracker", "track"]


class MeanShiftTracker(DetectionTracker):
    """Streaming tracker by mean shift clustering."""

    def __init__(self, config: MeanShiftConfig) -> None:
        self.config = config
        self._rules = Iteration(
            bandwidth_px=float(config.bandwidth_px),
            cutoff=float(config.cutoff),
            tolerance_px=float(config.tolerance_px),
            max_iterations=config.max_iterations,
            fold_px=float(config.fold_px),
        )
        self._scale = Coordinates(
            polarity_px=float(config.polarity_px),
            time_px=float(config.time_px),
            tau_us=float(config.tau_us),
            fuse_px=float(config.fuse_px),
            points_min=config.points_min,
        )
        self._of_pixels = config.source == "frames"
        self._cost = Cost(0, 0, 0, 0, 0)
        self._frames = 0
        framing = Framing(config.frame_us) if self._of_pixels else Framing(config.packet_us, config.packet_events)
        super().__init__(config, framing, self._clusters)

    @property
    def cost(self) -> Cost:
        """Computational cost of the clustering so far."""
        return self._cost

    @property
    def packets(self) -> int:
        """Number of packets, or frames, so far."""
        return self._frames

    def _clusters(self, events: Events, frames: NDArray[np.void]) -> NDArray[np.void]:
        events = events.read_only()
        columns = events.t_us, events.x, events.y, events.p
        found, cost = group(self._rules, self._scale, self._of_pixels, *columns, frames)
        self._cost = Cost(*(before + now for before, now in zip(self._cost, cost, strict=True)))
        self._frames += len(frames)
        return np.asarray(found)


def track(recording: Recording, config: MeanShiftConfig, keep: NDArray[np.bool_] | None = None) -> TrackLog:
    """Cluster and track the events of a recording, or a selection of them.

    Args:
        keep: (n,) bool, mask of the events that the tracker sees; None for all. Event indices in the log are the recording's.

    In the log `radius` is half the side of the cluster's window, `n_ev` its points in the packet, and `support` those in all
    packets.
    """
    return track_recording("mean-shift", MeanShiftTracker(config), recording, keep)
