# SPDX-License-Identifier: Apache-2.0
"""Sets of track ids, and counts of a track log that are kept while it grows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .record import DROPPED, Kind

__all__ = ["IdSet", "LifeCounter", "Tally"]


_DENSE = 1 << 27  # ids below it are bits


class IdSet:
    """An empty set of int64."""

    def __init__(self) -> None:
        self._bits = np.zeros(0, np.uint8)
        self._others: set[int] = set()

    def add(self, ids: NDArray[np.int64]) -> None:
        """Add ids, some of which may be there."""
        dense = (ids >= 0) & (ids < _DENSE)
        self._others.update(ids[~dense].tolist())
        ids = ids[dense]
        lacking = int(ids.max(initial=-1)) // 8 + 1 - len(self._bits)
        if lacking > 0:
            self._bits = np.concatenate((self._bits, np.zeros(max(lacking, len(self._bits)), np.uint8)))
        np.bitwise_or.at(self._bits, ids >> 3, np.left_shift(1, ids & 7).astype(np.uint8))

    @property
    def nbytes(self) -> int:
        """Bytes of the bits."""
        return self._bits.nbytes

    def __contains__(self, track_id: int) -> bool:
        if 0 <= track_id < _DENSE:
            return track_id >> 3 < len(self._bits) and bool(self._bits[track_id >> 3] >> (track_id & 7) & 1)
        return track_id in self._others


class Tally:
    """Counts of events and tracks; memory holds the tracks that are alive.

    Attributes:
        events, owned, passed, filtered: number of events, of those that a slot took, that none took, and that a filter dropped.
        kinds: number of records of each kind.
        longest_us: from the first record of a track to its last, of the longest; None without a record.
    """

    def __init__(self) -> None:
        self.events = self.owned = self.passed = self.filtered = 0
        self.kinds = dict.fromkeys(Kind, 0)
        self.longest_us: int | None = None
        self._first_us: dict[int, int] = {}

    def add(self, records: NDArray[np.void], owner: NDArray[np.int16]) -> None:
        """Count what a tracker returned for a run of events."""
        self.events += len(owner)
        self.owned += int(np.count_nonzero(owner >= 0))
        self.passed += int(np.count_nonzero(owner == -1))
        self.filtered += int(np.count_nonzero(owner == DROPPED))
        for kind, count in enumerate(np.bincount(records["kind"], minlength=len(Kind)).tolist()):
            self.kinds[Kind(kind)] += count
        if len(records):
            self._lengths(records)

    @property
    def alive(self) -> int:
        """Number of tracks whose last record is no end; one that was lost and found again is alive."""
        return len(self._first_us)

    def _lengths(self, records: NDArray[np.void]) -> None:
        t_us, track_id = records["t_us"], records["track_id"]
        ids, first = np.unique(track_id, return_index=True)
        _, last = np.unique(track_id[::-1], return_index=True)
        last = len(records) - 1 - last
        ended = np.isin(records["kind"][last], (Kind.MERGED, Kind.LOST))
        rows = zip(ids.tolist(), t_us[first].tolist(), t_us[last].tolist(), ended.tolist(), strict=True)
        for track, begin_us, end_us, over in rows:
            since_us = self._first_us.setdefault(track, begin_us)
            self.longest_us = max(self.longest_us or 0, end_us - since_us)
            if over:
                del self._first_us[track]


class LifeCounter:
    """Number of tracks in records that come in runs, as many as `timeline.lifetimes` has; memory holds the ids alive.

    Attributes:
        count: so far.
    """

    def __init__(self) -> None:
        self.count = 0
        self._alive = np.empty(0, np.int64)

    def add(self, records: NDArray[np.void]) -> None:
        """Count a run."""
        order = np.argsort(records["track_id"], kind="stable")
        kind, track_id = records["kind"][order], records["track_id"][order]
        ends = (kind == Kind.MERGED) | (kind == Kind.LOST)
        other = np.append(True, track_id[1:] != track_id[:-1])[: len(order)]
        after = np.append(False, ends[:-1])[: len(order)]
        begins = (kind == Kind.BORN) | np.where(other, ~np.isin(track_id, self._alive), after)
        self.count += int(np.count_nonzero(begins))
        last = np.append(other[1:], True)[: len(order)]
        seen = np.setdiff1d(self._alive, track_id)
        self._alive = np.concatenate((seen, track_id[last & ~ends]))
