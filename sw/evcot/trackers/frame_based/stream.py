# SPDX-License-Identifier: Apache-2.0
"""Tracking by detection as a stream: events are cut into frames, objects detected in each, and followed across them."""

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
"""Events and (f,) frames of dtype `kernel.FRAME` in, of which `begin` and `end` are set; sets `found` and `found_end` and
returns (d,) detections of dtype `kernel.DETECTION`."""


class DetectionTracker:
    """A stream: feed events in runs of any length, the result does not depend on where they are cut.

    Memory is that of one frame's events, beyond the arrays that are returned.

    Attributes:
        detect: what finds the objects; may be wrapped, to look at what is found.
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
            events: (n,) events in time order, none before an event that was fed earlier.

        Returns:
            (m,) records of dtype `TRACK`, of the frames that these events completed, and (n,) int16 owners: the slot of the
            visible track that took each event, -1 for none.

        Raises:
            RecordingError: the run starts before the last event of the previous one, or a frame cannot be detected in.
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
        """Complete the last frame when no more events come; (m,) records of dtype `TRACK`.

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
        """The live tracks, started first first: (k,) of dtype `kernel.TRACKED`; velocities in px/s."""
        return self._identities.tracks()

    def _hold(self, events: Events) -> None:
        """Keep a copy: the caller may fill its arrays anew, and a slice would keep all of them alive."""
        self._open.append(events.where(np.ones(len(events), np.bool_)))
        self._held += len(events)

    def _follow(self, events: Events, owned: int, ends: NDArray[np.int64]) -> tuple[NDArray[np.void], NDArray[np.int16]]:
        frames = np.zeros(len(ends), FRAME)
        frames["begin"][1:], frames["end"] = ends[:-1], ends
        found = self.detect(events, frames)
        return self._identities.follow(events, owned, frames, found)
