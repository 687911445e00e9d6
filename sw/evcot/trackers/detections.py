# SPDX-License-Identifier: Apache-2.0
"""Track management: detections are assigned to the predicted positions of tracks by optimal assignment.

- Tracks are predicted with constant velocity. Tracks and detections are paired to give as many pairs within the gate as
  possible and, among those, the smallest sum of distances (`scipy.optimize.linear_sum_assignment`); visible tracks take
  precedence over those that are not yet visible.
- A detection without a track starts one. With its `visible_hits`-th detection it becomes visible (BORN).
- Each visible track that was detected reports its predicted position at the frame's last event (MOVED). One that was not
  coasts with its velocity, without records, until it is detected again or `lifetime_us` have passed (LOST). Tracks never merge.
- An event is assigned to the nearest visible track whose window holds it, by the state before the event's frame is complete.

A frame, here, is a set of events and the detections in it: the pixels of some milliseconds, or a packet of events.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from evcot._numba_private import njit
from evcot.events import Events
from evcot.ranges import setting
from evcot.tracks.log import TRACK, Kind
from evcot.tracks.tracking import check_order

__all__ = ["DETECTION", "DetectionTracker", "Identities", "IdentityConfig", "Track", "own"]


# Track management: detections are assigned to the predicted positions of tracks by optimal assignment.
#
# - Tracks are predicted with constant velocity. Tracks and detections are paired to give as many pairs within the gate as
# possible and, among those, the smallest sum of distances (`scipy.optimize.linear_sum_assignment`); visible tracks take
# precedence over those that are not yet visible.
# - A detection without a track starts one. With its `visible_hits`-th detection it becomes visible (BORN).
# - Each visible track that was detected reports its predicted position at the frame's last event (MOVED). One that was not
# coasts with its velocity, without records, until it is detected again or `lifetime_us` have passed (LOST). Tracks never merge.
# - An event is assigned to the nearest visible track whose window holds it, by the state before the event's frame is complete.
#
# A frame, here, is a set of events and the detections in it: the pixels of some milliseconds, or a packet of events.

_TRACKS_MAX = 64
_OUTSIDE = 1e3  # cost of a pair outside the gate, in gates


DETECTION = np.dtype(
    [
        ("x", "<f8"),  # centre, pixels
        ("y", "<f8"),
        ("radius", "<f8"),  # half the side of its window, pixels
        ("width", "<f8"),  # of the object, pixels
        ("height", "<f8"),
        ("after_us", "<f8"),  # mean time of its events after the frame's first
        ("n", "<i8"),  # its points: events or pixels
    ]
)


@dataclass(frozen=True)
class IdentityConfig:
    """Settings of track management."""

    gate_px: float = setting(20.0, 0.1, 10_000.0, "farthest a detection may lie from where its track is expected")
    smoothing_us: int = setting(
        10_000, 0, 10**9, "time constant with which a track takes over what is measured; 0 takes it as it is"
    )
    visible_hits: int = setting(3, 1, 1_000_000, "detections after which a track becomes visible")
    lifetime_us: int = setting(150_000, 1, 10**12, "silence after which a visible track is lost")


@dataclass(slots=True, eq=False)
class Track:
    """A track; x and y, in pixels, are its centre `before_us` before `last_us`.

    Attributes:
        last_us: last event of the frame in which it was last detected.
        n, support: points in that frame, and in all frames.
        hits: frames in which it was detected.
        velocity_x, velocity_y: pixels per second.
        track_id: -1 until it is visible.
    """

    x: float
    y: float
    radius: float
    width: float
    height: float
    before_us: float
    last_us: int
    n: int
    support: int
    slot: int
    velocity_x: float = 0.0
    velocity_y: float = 0.0
    hits: int = 1
    track_id: int = -1


class Identities:
    """The tracks of a stream of frames.

    Args:
        candidate_us: silence after which a track that is not yet visible is dropped.

    Attributes:
        tracks: the live tracks, oldest first.
    """

    def __init__(self, config: IdentityConfig, candidate_us: int) -> None:
        self._config = config
        self._candidate_us = candidate_us
        self._births = 0
        self.tracks: list[Track] = []

    def own(self, events: Events) -> NDArray[np.int16]:
        """The owner of each of n read-only events: the slot of a visible track, -1 for none."""
        owner = np.full(len(events), -1, np.int16)
        visible = [c for c in self.tracks if c.track_id >= 0]
        windows = np.array([(c.x, c.y, c.velocity_x, c.velocity_y, c.radius, c.before_us) for c in visible]).reshape(-1, 6)
        last_us, slots = np.array([c.last_us for c in visible], np.int64), np.array([c.slot for c in visible], np.int16)
        own(events.t_us, events.x, events.y, windows, last_us, slots, self._config.lifetime_us, owner)
        return owner

    def follow(self, t_us: NDArray[np.int64], index: int, found: NDArray[np.void]) -> list[tuple[Any, ...]]:
        """Update the tracks with a complete frame.

        Args:
            t_us: times of the frame's events.
            index: of the first of them in the stream.
            found: (d,) detections of dtype `DETECTION`.

        Returns:
            Records with the fields of `TRACK`.
        """
        first_us, last_us = int(t_us[0]), int(t_us[-1])
        records = self._end_lives(first_us, t_us, index)
        partner = self._partners(found, first_us)
        for k, (x, y, radius, width, height, after_us, n) in enumerate(found.tolist()):
            before_us = (last_us - first_us) - after_us
            seen = Track(x, y, radius, width, height, before_us, last_us, n, n, -1)
            if k in partner:
                self._correct(partner[k], seen, (first_us - partner[k].last_us) + after_us + partner[k].before_us)
            elif len(self.tracks) < _TRACKS_MAX:
                seen.slot = min({*range(len(self.tracks) + 1)} - {track.slot for track in self.tracks})
                self.tracks.append(seen)
        records += self._end_lives(last_us, t_us, index)
        for track in self.tracks:
            if track.last_us != last_us or track.hits < self._config.visible_hits:
                continue
            kind = Kind.MOVED
            if track.track_id < 0:
                track.track_id, kind = self._births, Kind.BORN
                self._births += 1
            records.append(self._record(kind, index + len(t_us) - 1, last_us, track))
        return records

    def _end_lives(self, until_us: int, t_us: NDArray[np.int64], index: int) -> list[tuple[Any, ...]]:
        """Remove the tracks whose life has ended by `until_us`; their LOST records in order of time."""
        limits = [(self._config.lifetime_us if c.track_id >= 0 else self._candidate_us) + c.last_us for c in self.tracks]
        ended = [(end_us, c) for end_us, c in zip(limits, self.tracks, strict=True) if end_us <= until_us]
        if not ended:
            return []
        self.tracks = [c for end_us, c in zip(limits, self.tracks, strict=True) if end_us > until_us]
        return [
            self._record(Kind.LOST, index + int(np.searchsorted(t_us, end_us)), end_us, c)
            for end_us, c in sorted(ended, key=lambda pair: pair[0])
            if c.track_id >= 0
        ]

    def _partners(self, found: NDArray[np.void], first_us: int) -> dict[int, Track]:
        """Index of a detection -> its track.

        Cost is the distance from a track's prediction, plus one gate for a track that is not yet visible, so that visible
        tracks take precedence. A pair outside the gate costs more than all other pairs together.
        """
        if not self.tracks or not len(found):
            return {}
        gate_px = self._config.gate_px
        state = [(c.x, c.y, c.velocity_x, c.velocity_y, c.before_us, first_us - c.last_us, c.track_id < 0) for c in self.tracks]
        x, y, velocity_x, velocity_y, before_us, since_us, candidate = np.array(state).T[:, :, None]
        elapsed_s = 1e-6 * (since_us + found["after_us"] + before_us)
        off_x, off_y = found["x"] - (x + velocity_x * elapsed_s), found["y"] - (y + velocity_y * elapsed_s)
        apart_px = np.sqrt(off_x * off_x + off_y * off_y)
        cost = np.where(apart_px <= gate_px, apart_px + gate_px * candidate, _OUTSIDE * len(found) * gate_px)
        pairs = zip(*linear_sum_assignment(cost), strict=True)
        return {int(k): self.tracks[i] for i, k in pairs if cost[i, k] <= 2 * gate_px}

    def _correct(self, track: Track, seen: Track, elapsed_us: float) -> None:
        """A critically damped g-h filter: memory fades with one time constant, independent of the frame rate.

        E. Brookner, "Tracking and Kalman Filtering Made Easy", 1998, section 1.2.6: g = 1 - theta^2, h = (1 - theta)^2. Until
        the memory is filled, the position is the mean of the detections.
        """
        elapsed_s = 1e-6 * elapsed_us
        fading = math.exp(-elapsed_us / self._config.smoothing_us) if self._config.smoothing_us else 0.0
        gain, faster = max(1.0 - fading * fading, 1.0 / (track.hits + 1)), (1.0 - fading) * (1.0 - fading)
        track.x += track.velocity_x * elapsed_s
        track.y += track.velocity_y * elapsed_s
        off_x, off_y = seen.x - track.x, seen.y - track.y
        track.x += gain * off_x
        track.y += gain * off_y
        if elapsed_s > 0.0:
            track.velocity_x += faster * off_x / elapsed_s
            track.velocity_y += faster * off_y / elapsed_s
        track.radius += gain * (seen.radius - track.radius)
        track.width += gain * (seen.width - track.width)
        track.height += gain * (seen.height - track.height)
        track.n, track.support, track.hits = seen.n, track.support + seen.n, track.hits + 1
        track.last_us, track.before_us = seen.last_us, seen.before_us

    def _record(self, kind: Kind, index: int, t_us: int, c: Track) -> tuple[Any, ...]:
        """A record with a track's predicted position at the end of the frame in which it was last detected."""
        ahead_s = 1e-6 * c.before_us
        x, y = c.x + c.velocity_x * ahead_s, c.y + c.velocity_y * ahead_s
        box = (c.radius, c.width, c.height, 0.0)
        confidence = c.hits / (c.hits + self._config.visible_hits)
        id_, slot, moves = c.track_id, c.slot, (c.velocity_x, c.velocity_y)
        return (t_us, index, int(kind), id_, slot, x, y, *box, *moves, confidence, c.n, c.support, -1)


@njit(cache=True, nogil=True)
def own(
    ts: NDArray[Any], xs: NDArray[Any], ys: NDArray[Any],
    windows: NDArray[Any], last_us: NDArray[Any], slots: NDArray[Any], lifetime_us: int, owner: NDArray[Any],
) -> None:  # fmt: skip
    """Assign each event to the nearest visible track whose window, at its predicted position, holds it.

    windows: (k, 6) x, y, velocity_x, velocity_y, radius, before_us of the visible tracks.
    """
    for e in range(len(ts)):
        nearest_px = np.inf
        for i in range(len(slots)):
            if ts[e] >= last_us[i] + lifetime_us:
                continue
            x, y, velocity_x, velocity_y, radius, before_us = windows[i]
            ahead_s = 1e-6 * ((ts[e] - last_us[i]) + before_us)
            apart_px = max(abs(xs[e] - (x + velocity_x * ahead_s)), abs(ys[e] - (y + velocity_y * ahead_s)))
            if apart_px <= radius and apart_px < nearest_px:
                nearest_px = apart_px
                owner[e] = slots[i]


class DetectionTracker(ABC):
    """A streaming tracker: feed events in runs of any length; the result does not depend on how they are split into runs.

    Subclasses define `frame_ends` and `detect`. Besides the returned arrays, memory holds the events of one frame.

    Args:
        candidate_us: silence after which a track that is not yet visible is dropped.

    Attributes:
        settled: see `tracking.Tracker`: the events of complete frames.
    """

    def __init__(self, config: IdentityConfig, candidate_us: int) -> None:
        self._identities = Identities(config, candidate_us)
        self._open = Events.empty()  # the frame that is not yet complete
        self._last_us: int | None = None
        self.settled = 0

    @abstractmethod
    def frame_ends(self, t_us: NDArray[np.int64]) -> NDArray[np.int64]:
        """Where frames end, as indices after their last event; the first of the (n,) event times, n >= 1, begins a frame."""

    @abstractmethod
    def detect(self, events: Events) -> NDArray[np.void]:
        """Detect the objects in the read-only events of a frame: (d,) of dtype `identity.DETECTION`."""

    def feed(self, events: Events) -> tuple[NDArray[np.void], NDArray[np.int16]]:
        """Track a run of events.

        Args:
            events: (n,) events in time order, none before an event fed earlier.

        Returns:
            (m,) records of dtype `TRACK`, of the frames that these events completed, and (n,) int16 owners: the slot of the
            visible track that took each event, -1 for none.

        Raises:
            RecordingError: the run starts before the last event of the previous one, or detection fails for a frame.
        """
        if not len(events):
            return np.empty(0, TRACK), np.empty(0, np.int16)
        owned = len(self._open)  # these leading events have an owner already
        check_order(events, self._last_us, self.settled + owned)
        self._last_us = int(events.t_us[-1])
        together = Events.joined([self._open, events] if owned else [events]).read_only()
        records: list[tuple[Any, ...]] = []
        owners: list[NDArray[np.int16]] = []
        begin = 0
        for end in self.frame_ends(together.t_us).tolist():
            owners.append(self._identities.own(together[max(begin, owned) : end]))
            records += self._complete(together[begin:end])
            begin = end
        owners.append(self._identities.own(together[max(begin, owned) :]))
        self._open = together[begin:].kept()  # a copy: the caller may reuse its arrays
        return np.array(records, TRACK), np.concatenate(owners)

    def finish(self) -> NDArray[np.void]:
        """Complete the last frame at the end of the stream; (m,) records of dtype `TRACK`.

        A track whose life would end after the last event is still alive.
        """
        frame, self._open = self._open.read_only(), Events.empty()
        return np.array(self._complete(frame) if len(frame) else [], TRACK)

    def tracks(self) -> list[Track]:
        """The live tracks, oldest first."""
        return self._identities.tracks

    def _complete(self, frame: Events) -> list[tuple[Any, ...]]:
        records = self._identities.follow(frame.t_us, self.settled, self.detect(frame))
        self.settled += len(frame)
        return records
