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

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import njit, step
from ...events import Events, Recording
from ...tracks.log import TRACK, TrackLog
from ...tracks.tracking import PacketBegin, check_order, track_recording
from .config import RctConfig
from .find import NOBODY, cell_of, events_within, find_by_options, find_nearest
from .life import check, note_ends_of_life, seed
from .motion import move, pull_extent, pull_size
from .packet import close_packet, open_packet
from .state import (
    NEVER_US,
    RECORDS_PER_PACKET,
    EventOptions,
    EventRules,
    State,
    Table,
    event_options,
    event_rules,
    new_state,
    summary,
)

__all__ = ["RctTracker", "close_last_packet", "feed", "track"]


@step
def _at_times(state: State, t_us: int) -> Any:
    """Process what is due before an event; returns the time of the next call."""
    cur = state.cursor[0]
    if t_us >= cur.packet_end_us:
        open_packet(state, t_us)
    if t_us >= cur.next_due_us:
        note_ends_of_life(state, t_us)
    return min(cur.packet_end_us, cur.next_due_us)


@njit(cache=True, nogil=True)
def feed(
    state: State, rules: EventRules, options: EventOptions | None, ts: Table, xs: Table, ys: Table, owner: Table
) -> int:  # fmt: skip
    """Track events until all are done or the buffer could overflow; returns the number done.

    Without `options` it is the paper's tracker: Numba then compiles it without the code of the options.
    """
    _, cursor, clusters, live, _, cells, around, _, out = state
    cur = cursor[0]
    n_max = len(live)
    radius_px, alpha = rules.radius_px, rules.alpha
    keep = 1.0 - alpha
    wake_us = min(cur.packet_end_us, cur.next_due_us)
    first_index = cur.index
    for e in range(len(ts)):
        t_us = ts[e]
        if t_us >= wake_us:
            if e > 0:
                cur.last_us = ts[e - 1]
            cur.index = first_index + e
            if t_us >= cur.packet_end_us and cur.records + RECORDS_PER_PACKET * n_max > len(out):
                return e
            wake_us = _at_times(state, t_us)
        x = float(xs[e])
        y = float(ys[e])
        if options is None:
            seat, nearest_px = find_nearest(clusters, cells, xs[e], ys[e], x, y)
            held = nearest_px <= radius_px
        else:
            cell = cell_of(xs[e], ys[e])
            seat, (u, v) = find_by_options(options, clusters, cells, 1.0, cell, x, y)
            held = seat != np.uint64(NOBODY)
            if not held and len(around) > 0:
                seat, (u, v) = find_by_options(options, clusters, around, options.surround, cell, x, y)
        if held:
            cluster = clusters[seat]
            astray = False
            if options is None:
                pull_extent(cluster, abs(x - cluster.x), abs(y - cluster.y))
                cluster.x = keep * cluster.x + alpha * x
                cluster.y = keep * cluster.y + alpha * y
            else:
                move(options, cluster, x, y, u, v)
                astray = max(abs(cluster.x - cluster.cells_x), abs(cluster.y - cluster.cells_y)) > cluster.room
            cluster.last_us = t_us
            cluster.packet_events += 1
            owner[e] = cluster.slot
            if astray or cluster.packet_events >= cluster.check_at:
                again = events_within(rules, cluster) if options is None and cluster.track_id >= 0 else 0
                if again > 0:
                    cluster.check_at = cluster.packet_events + again
                    continue
                check(state, np.int64(seat), first_index + e, t_us)  # type: ignore[arg-type]
        elif options is not None and seat != np.uint64(NOBODY):
            pull_size(options, clusters[seat], x, y, u, v)
            owner[e] = -1
        elif cur.live < n_max:
            seat_new = seed(state, x, y, t_us)
            check(state, seat_new, first_index + e, t_us)
            owner[e] = clusters[seat_new].slot
        else:
            owner[e] = -1
    cur.index = first_index + len(ts)
    if len(ts) > 0:
        cur.last_us = ts[len(ts) - 1]
    return len(ts)


@njit(cache=True, nogil=True)
def close_last_packet(state: State) -> None:
    """Close the open packet at the end of the stream: time does not advance beyond the last event."""
    cur = state.cursor[0]
    if cur.packet_end_us != -NEVER_US:
        close_packet(state, cur.last_us)
    cur.closed = cur.records


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
