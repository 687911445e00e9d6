# SPDX-License-Identifier: Apache-2.0
"""Track management across frames: detections are assigned to the predicted positions of tracks by optimal assignment.

- Tracks are predicted with constant velocity. Tracks and detections are paired to give as many pairs within the gate as
  possible and, among those, the smallest sum of distances (`scipy.optimize.linear_sum_assignment`); visible tracks take
  precedence over those that are not yet visible.
- A detection without a track starts one. With its `visible_hits`-th detection it becomes visible (BORN).
- Each visible track that was detected reports its predicted position at the frame's last event (MOVED). One that was not
  coasts with its velocity, without records, until it is detected again or `lifetime_us` have passed (LOST). Tracks never merge.
- An event is assigned to the nearest visible track whose window holds it, by the state before the event's frame is complete.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from ...events import Events
from ...tracks.log import TRACK
from .config import IdentityConfig
from .kernel import CURSOR, RECORDS_PER_TRACK, TRACKED, Rules, distances, follow, own, settle

__all__ = ["Identities"]


class Identities:
    """The tracks of a stream of frames."""

    def __init__(self, config: IdentityConfig) -> None:
        self._rules = Rules(
            gate_px=float(config.gate_px),
            smoothing_us=float(config.smoothing_us),
            visible_hits=config.visible_hits,
            candidate_us=config.candidate_us,
            lifetime_us=config.lifetime_us,
        )
        self._tracks = np.zeros(config.max_tracks, TRACKED)
        self._slot_taken = np.zeros(config.max_tracks, np.bool_)
        self._cursor = np.zeros(1, CURSOR)
        self._buffer = np.zeros(RECORDS_PER_TRACK * config.max_tracks + 4096, TRACK)

    def follow(
        self, events: Events, owned: int, frames: NDArray[np.void], found: NDArray[np.void]
    ) -> tuple[NDArray[np.void], NDArray[np.int16]]:
        """Update the tracks with complete frames.

        Args:
            events: (n,) events of the frames, followed by those of a frame that is not yet complete.
            owned: number of leading events whose owner was returned by an earlier call.
            frames: (f,) of dtype `kernel.FRAME`, contiguous from the first event on.
            found: (d,) detections of dtype `kernel.DETECTION`.

        Returns:
            (m,) records of dtype `TRACK`, and (n - owned,) int16 owners.
        """
        owner = np.empty(len(events), np.int16)
        events = events.read_only()
        columns = events.t_us, events.x, events.y
        state = self._rules, self._cursor, self._tracks
        parts: list[NDArray[np.void]] = []
        frame = 0
        while frame < len(frames):
            frame, choice = follow(*state, self._slot_taken, *columns, owned, owner, frames, found, frame, self._buffer)
            if choice:
                self._choose(events.t_us, frames[frame], found)
                frame += 1
            parts.append(self._taken())
        done = int(frames["end"][-1]) if len(frames) else 0
        own(*state, *columns, max(done, owned), len(events), owner)
        self._cursor["index"] += done
        return np.concatenate(parts) if parts else np.empty(0, TRACK), owner[owned:]

    def tracks(self) -> NDArray[np.void]:
        """The live tracks, oldest first: (k,) of dtype `kernel.TRACKED`."""
        return self._tracks[: int(self._cursor["live"][0])].copy()

    @property
    def seen(self) -> int:
        """Number of events in frames so far."""
        return int(self._cursor["index"][0])

    def _choose(self, t_us: NDArray[np.int64], frame: np.void, found: NDArray[np.void]) -> None:
        seen = found[frame["found"] : frame["found_end"]]
        cost = distances(self._rules, self._cursor, self._tracks, seen, t_us[frame["begin"]])
        row, column = linear_sum_assignment(cost)
        inside = cost[row, column] <= 2 * self._rules.gate_px
        partner = np.full(len(seen), -1)
        partner[column[inside]] = row[inside]
        settle(self._rules, self._cursor, self._tracks, self._slot_taken, t_us, frame, seen, partner, self._buffer)

    def _taken(self) -> NDArray[np.void]:
        taken = self._buffer[: int(self._cursor["records"][0])].copy()
        self._cursor["records"] = 0
        return taken
