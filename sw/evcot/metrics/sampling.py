# SPDX-License-Identifier: Apache-2.0
"""A log that can be evaluated, and the positions of its tracks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..tracks.log import Kind, TrackLog
from ..tracks.log_parts import windows
from ..tracks.record import BEGIN_US, check_records

__all__ = ["Around", "checked", "checked_runs", "positions", "positions_around"]

_AT_ONCE = 1 << 16  # positions: half a megabyte of each coordinate


def checked(log: TrackLog) -> TrackLog:
    """Validate a log and return it; see `check_records`."""
    check_records(log.records)
    return log


def checked_runs(runs: Iterable[NDArray[np.void]]) -> Iterator[NDArray[np.void]]:
    """The runs of a log, validated one after the other; see `check_records`."""
    first, since_us = 0, BEGIN_US
    for records in runs:
        check_records(records, first, since_us)
        yield records
        if len(records):
            first, since_us = first + len(records), int(records["t_us"][-1])


def positions(
    log: TrackLog, track_ids: NDArray[np.int64], times_us: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Positions of tracks: of track_ids[i] at each of times_us[i].

    Args:
        track_ids: (n,)
        times_us: (n, k)

    Returns:
        x, y: (n, k) in pixels, NaN where the track does not exist.
    """
    return _ByTrack(log).positions(track_ids, times_us)


class _ByTrack:
    """The records of a log, track by track."""

    def __init__(self, log: TrackLog) -> None:
        self._records = log.records[np.argsort(log.records["track_id"], kind="stable")]

    def positions(
        self, track_ids: NDArray[np.int64], times_us: NDArray[np.int64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """As the function of this name."""
        by_track = np.argsort(track_ids, kind="stable")
        wanted, starts = np.unique(track_ids[by_track], return_index=True)
        begin, end = (np.searchsorted(self._records["track_id"], wanted, side) for side in ("left", "right"))
        x, y = np.full((2, *times_us.shape), np.nan)
        for i, rows in enumerate(np.split(by_track, starts[1:])[: len(wanted)]):
            own = self._records[begin[i] : end[i]]
            if not len(own):
                continue
            newest = np.searchsorted(own["t_us"], times_us[rows], "right") - 1
            there = (newest >= 0) & (own["kind"][newest] <= Kind.MOVED)
            x[rows], y[rows] = (np.where(there, own[axis][newest], np.nan) for axis in "xy")
        return x, y


class Around(NamedTuple):
    """Some of the positions that `positions_around` finds.

    Attributes:
        rows: which of the instants.
        there: (n, k) mask of those that are known by now; others are known from other parts.
        x, y: (n, k) in pixels, NaN where the track does not exist.
    """

    rows: slice
    there: NDArray[np.bool_]
    x: NDArray[np.float64]
    y: NDArray[np.float64]


def positions_around(
    runs: Iterable[NDArray[np.void]],
    max_age_us: int,
    track_ids: NDArray[np.int64],
    instants_us: NDArray[np.int64],
    offsets_us: NDArray[np.int64],
) -> Iterator[Around]:
    """Positions of tracks in a log whose states expire: of track_ids[i] at instants_us[i] plus each of the offsets.

    They come in parts that fit into a processor's cache; what is in none of them does not exist.

    Args:
        runs, max_age_us: as of `windows`.
        track_ids: (n,)
        instants_us: (n,) ascending
        offsets_us: (k,)
    """
    size = max(_AT_ONCE // len(offsets_us), 1)
    for window in windows(runs, max_age_us):
        around = (window.from_us - int(offsets_us.max()), window.until_us - int(offsets_us.min()))
        first, end = (int(i) for i in np.searchsorted(instants_us, around))
        states = _ByTrack(window.states) if first < end else None
        for begin in range(first, end, size):
            rows = slice(begin, min(begin + size, end))
            times_us = instants_us[rows, None] + offsets_us
            there = (times_us >= window.from_us) & (times_us < window.until_us)
            assert states is not None
            yield Around(rows, there, *states.positions(track_ids[rows], times_us))
