# SPDX-License-Identifier: Apache-2.0
"""Positions and trails of tracks at each picture of a film."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...tracks.log import TrackLog
from ...tracks.timeline import sample
from .colours import RGB, SIDES

__all__ = ["Follower", "Side", "side_of"]

_TRAIL_PICTURES = 300


@dataclass(frozen=True)
class Side:
    """A track log with its display name and colour."""

    name: str
    log: TrackLog
    colour: RGB


def side_of(place: int, name: str, log: TrackLog) -> Side:
    """The side for the log at index `place` of several."""
    return Side(name, log, SIDES[place % len(SIDES)])


class Follower:
    """The visible tracks of a side, picture by picture.

    Args:
        times_us: (n,) times of the pictures, ascending.
    """

    def __init__(self, side: Side, times_us: NDArray[np.int64]) -> None:
        self.side = side
        self._states = sample(side.log, times_us)
        self._begin = np.searchsorted(self._states["sample"], np.arange(len(times_us) + 1))
        self._trails: dict[int, deque[tuple[float, float]]] = {}

    def at(self, picture: int) -> tuple[NDArray[np.void], dict[int, deque[tuple[float, float]]]]:
        """(states of dtype `timeline.SAMPLE`, track id -> past positions); must be called for the pictures in order."""
        states = self._states[self._begin[picture] : self._begin[picture + 1]]
        trails = {}
        for track_id, x, y in zip(states["track_id"].tolist(), states["x"].tolist(), states["y"].tolist(), strict=True):
            trail = self._trails.get(track_id)
            trails[track_id] = deque(maxlen=_TRAIL_PICTURES) if trail is None else trail
            trails[track_id].append((x, y))
        self._trails = trails
        return states, trails
