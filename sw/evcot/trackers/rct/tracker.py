# SPDX-License-Identifier: Apache-2.0
"""The Rectangular Cluster Tracker of the paper's SOFTWARE section, in floating-point arithmetic.

Events are processed one by one, in packets of `packet_us` counted from the first event.

- An event is assigned to the nearest cluster whose window holds it. Distance is Chebyshev, max(|dx|, |dy|), from the event to
  the centre: a square window of radius R holds exactly the points at most R away, so one number is sufficient. Of two
  equally near, the cluster seeded first takes it. The centre moves by equation (7), x <- (1 - alpha) x + alpha e.
- An event in no window seeds a cluster, if there are fewer than `max_clusters`. The cluster becomes visible (BORN) and gets its
  track id with its `visible_events`-th event.
- After each packet: clusters without an event for `lifetime_us` are removed (LOST, at last event + lifetime). Clusters whose
  windows share a point merge at the mean of their centres weighted by events: the one that became visible first survives, of
  two invisible ones the one seeded first (MERGED). Each visible cluster that took events reports its centre once (MOVED).
- Velocity is the displacement from packet end to packet end, mixed by `velocity_alpha`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...events import Events, Recording
from ...tracks.log import TRACK, TrackLog
from ...tracks.tracking import PacketBegin, check_order, track_recording
from .config import RctConfig
from .kernel import close_last_packet, feed
from .state import event_options, event_rules, new_state, summary

__all__ = ["RctTracker", "track"]


class RctTracker:
    """A streaming tracker: feed events in runs of any length; the result does not depend on how they are split into runs.

    Besides the returned arrays, memory is constant.
    """

    def __init__(self, config: RctConfig, width: int = 0, height: int = 0) -> None:
        """A tracker before its first event.

        Args:
            width, height: of the sensor, px; 0 if unknown. Limits prediction.
        """
        self.config = config
        self._state = new_state(config, width, height)
        self._rules, self._options = event_rules(self._state), event_options(self._state)
        self._cursor = self._state.cursor
        self._packet = PacketBegin(config.packet_us)

    def feed(self, events: Events) -> tuple[NDArray[np.void], NDArray[np.int16]]:
        """Track a run of events.

        Args:
            events: (n,) events in time order, none before an event fed earlier.

        Returns:
            (m,) records of dtype `TRACK`, of the packets that these events closed, and (n,) int16 owners: the slot that took
            each event, -1 if it is in no window and no slot is free.

        Raises:
            RecordingError: the run starts before the last event of the previous one.
        """
        check_order(events, int(self._cursor["last_us"][0]), int(self._cursor["index"][0]))
        events = events.read_only()
        owner = np.empty(len(events), np.int16)
        parts: list[NDArray[np.void]] = []
        done = 0
        while done < len(events):
            rest = events[done:]
            done += feed(self._state, self._rules, self._options, rest.t_us, rest.x, rest.y, owner[done:])
            parts.append(self._take_closed())
        self._packet.fed(events, int(self._cursor["packet_end_us"][0]))
        return np.concatenate(parts) if parts else np.empty(0, TRACK), owner

    def finish(self) -> NDArray[np.void]:
        """Close the last packet at the end of the stream; (m,) records of dtype `TRACK`.

        A cluster whose life would end after the last event is still alive.
        """
        close_last_packet(self._state)
        return self._take_closed()

    @property
    def settled(self) -> int:
        """See `tracking.Tracker`: the events before the open packet."""
        return self._packet.index

    def clusters(self) -> NDArray[np.void]:
        """The live clusters, in order of seeding: (k,) with x, y, half_width, half_height (px), velocity_x, velocity_y (px/s),
        events, last_us, track_id (-1 while invisible) and slot."""
        return summary(self._live())

    def paths(self) -> list[NDArray[np.void]]:
        """The paths of the live clusters, in the order of `clusters`: per cluster (m,) with t_us, x, y (px), oldest first, one
        position per packet in which it took events, the last `path_points` of them."""
        paths = []
        for cluster in self._live():
            places, size = int(cluster["places"]), self.config.path_points
            paths.append(self._state.paths[cluster["slot"], np.arange(max(0, places - size), places) % max(1, size)])
        return paths

    def _live(self) -> NDArray[np.void]:
        live: NDArray[np.void] = self._state.clusters[self._state.live[: int(self._cursor["live"][0])]]
        return live

    def _take_closed(self) -> NDArray[np.void]:
        """Take the records of closed packets from the buffer; move those of the open packet to its front."""
        closed, records = int(self._cursor["closed"][0]), int(self._cursor["records"][0])
        out = self._state.out
        taken: NDArray[np.void] = out[:closed].copy()
        out[: records - closed] = out[closed:records].copy()
        self._cursor["records"] = records - closed
        self._cursor["closed"] = 0
        return taken


def track(recording: Recording, config: RctConfig, keep: NDArray[np.bool_] | None = None) -> TrackLog:
    """Run the Rectangular Cluster Tracker over a recording, or over a selection of its events.

    Args:
        keep: (n,) bool, mask of the events that the tracker sees; None for all. Event indices in the log are the recording's.

    In the log `radius` is the constant `radius_px`, `support` the events that the cluster accumulated, and `n_ev` those that it
    took in the packet.
    """
    return track_recording("rct", RctTracker(config, recording.width, recording.height), recording, keep)
