# SPDX-License-Identifier: Apache-2.0
"""Streaming tracking by detection: events are split into frames, objects are detected in each and tracked across frames."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ...events import Events
from ...tracks.log import TRACK
from ...tracks.tracking import check_order
from .config import IdentityConfig
from .framing import Framing
from .identity import Identities
from .kernel import DETECTION, FRAME

__all__ = ["Detect", "DetectionTracker"]

Detect = Callable[[Events, NDArray[np.void]], NDArray[np.void]]
"""Takes events and (f,) frames of dtype `kernel.FRAME` with `begin` and `end` set; sets `found` and `found_end` and returns
(d,) detections of dtype `kernel.DETECTION`."""


class DetectionTracker:
    """A streaming tracker: feed events in runs of any length; the result does not depend on how they are split into runs.

    Besides the returned arrays, memory holds the events of one frame.

    Attributes:
        detect: the detection function; may be wrapped to inspect detections.
    """

    def __init__(self, config: IdentityConfig, framing: Framing, detect: Detect) -> None:
        self._identities = Identities(config)
        self._framing = framing
        self.detect = detect
        self._open: list[Events] = []  # the frame that is not yet complete
        self._held = 0  # its events
        self._last_us: int | None = None

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
        check_order(events, self._last_us, self._identities.seen + self._held)
        self._last_us = int(events.t_us[-1])
        ends = self._framing.cut(events.t_us)
        if not len(ends):
            self._hold(events)
            return self._identities.follow(events, 0, np.empty(0, FRAME), np.empty(0, DETECTION))
        owned = self._held
        together = Events.joined([*self._open, events])
        ends += owned
        self._open, self._held = [], 0
        self._hold(together[int(ends[-1]) :])
        return self._follow(together, owned, ends)

    def finish(self) -> NDArray[np.void]:
        """Complete the last frame at the end of the stream; (m,) records of dtype `TRACK`.

        A track whose life would end after the last event is still alive.
        """
        if not self._held:
            return np.empty(0, TRACK)
        events = Events.joined(self._open)
        self._open, self._held = [], 0
        return self._follow(events, len(events), np.array([len(events)]))[0]

    @property
    def settled(self) -> int:
        """See `tracking.Tracker`: the events of complete frames."""
        return self._identities.seen

    def tracks(self) -> NDArray[np.void]:
        """The live tracks, oldest first: (k,) of dtype `kernel.TRACKED`; velocities in px/s."""
        return self._identities.tracks()

    def _hold(self, events: Events) -> None:
        """Keep a copy: the caller may reuse its arrays, and a slice would keep the whole arrays in memory."""
        self._open.append(events.where(np.ones(len(events), np.bool_)))
        self._held += len(events)

    def _follow(self, events: Events, owned: int, ends: NDArray[np.int64]) -> tuple[NDArray[np.void], NDArray[np.int16]]:
        frames = np.zeros(len(ends), FRAME)
        frames["begin"][1:], frames["end"] = ends[:-1], ends
        found = self.detect(events, frames)
        return self._identities.follow(events, owned, frames, found)
