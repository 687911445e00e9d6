# SPDX-License-Identifier: Apache-2.0
"""Frames of the live view: the newest event of every active pixel, and the clusters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evcot._numba_private import njit
from evcot.recordings.formats.source import Sensor
from evcot.tracks.log import DROPPED

from .session import Step
from .visible_clusters import Clusters

__all__ = ["Frame", "FrameMaker"]


@dataclass(frozen=True)
class Frame:
    """Events since the previous frame, one per pixel, and the clusters.

    Attributes:
        number: from 0 on.
        t_us: time of the newest event.
        events_t_us, x, y: (n,) times and places, in time order.
        on, filtered: (n,) bool, polarity, and whether a filter removed the event.
        hidden: number of events hidden by newer ones of the same pixel.
        clusters: the visible clusters.
        beside: those of the trackers beside it.
        arrived_s: (k,) arrival times of its packets.
    """

    number: int
    t_us: int
    events_t_us: NDArray[np.int64]
    x: NDArray[np.uint16]
    y: NDArray[np.uint16]
    on: NDArray[np.bool_]
    filtered: NDArray[np.bool_]
    hidden: int
    clusters: Clusters
    beside: Sequence[Clusters]
    arrived_s: NDArray[np.float64]


class FrameMaker:
    """Makes the frames for one subscriber.

    Args:
        first: number of its first frame.
    """

    def __init__(self, sensor: Sensor, first: int = 0) -> None:
        self._width = sensor[0]
        self._seen = np.full(sensor[0] * sensor[1], -1, np.int64)
        self._number = first - 1

    def make(self, steps: Sequence[Step], clusters: Clusters, beside: Sequence[Clusters] = ()) -> Frame:
        """The next frame, from at least one step."""
        self._number += 1
        t_us, x, y, p = (np.concatenate([getattr(step.events, name) for step in steps]) for name in ("t_us", "x", "y", "p"))
        owner = np.concatenate([step.owner for step in steps])
        newest = np.empty(len(t_us), np.bool_)
        _mark_newest(x, y, self._width, self._number, self._seen, newest)
        chosen = np.flatnonzero(newest)
        return Frame(
            self._number, int(t_us[-1]), t_us[chosen], x[chosen], y[chosen], p[chosen] == 1, owner[chosen] == DROPPED,
            len(t_us) - len(chosen), clusters, beside, np.array([step.arrived_s for step in steps]),
        )  # fmt: skip


@njit(cache=True, nogil=True)
def _mark_newest(x, y, width, number, seen, newest):  # type: ignore[no-untyped-def]
    """Mark events that are the last of their pixel; `seen`: per pixel, number of the last frame with an event there."""
    for back in range(len(x)):
        i = len(x) - 1 - back
        cell = np.int64(y[i]) * width + np.int64(x[i])
        newest[i] = seen[cell] != number
        seen[cell] = number
