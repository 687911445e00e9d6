# SPDX-License-Identifier: Apache-2.0
"""Streaming tracking by detection: events are split into frames, objects are detected in each and tracked across frames."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...events import Events
from ...tracks.log import TRACK
from ...tracks.tracking import check_order
from .identity import Identities, IdentityConfig, Track

__all__ = ["DetectionTracker"]


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
