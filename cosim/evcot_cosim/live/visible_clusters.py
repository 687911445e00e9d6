# SPDX-License-Identifier: Apache-2.0
"""The set of currently visible clusters, updated from records."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from evcot.tracks.log import TRACK, Kind

__all__ = ["Alive", "Clusters"]


@dataclass(frozen=True)
class Clusters:
    """Clusters visible at one moment.

    Attributes:
        states: (k,) of dtype `TRACK`, the last record of each.
        birth_us: (k,) int64, when each became visible; of one that was lost, when it was found again.
    """

    states: NDArray[np.void] = field(default_factory=lambda: np.empty(0, TRACK))
    birth_us: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))


class Alive:
    """Applies records; `clusters` is replaced as a whole, so that another thread may read it at any time.

    Attributes:
        clusters: the visible clusters, in order of track id.
        count: number of records of each kind so far.
    """

    def __init__(self) -> None:
        self.clusters = Clusters()
        self.count: Counter[Kind] = Counter()

    def apply(self, records: NDArray[np.void]) -> None:
        """Apply records, in order."""
        if not len(records):
            return
        kinds = np.bincount(records["kind"], minlength=len(Kind))
        self.count.update({kind: int(kinds[kind]) for kind in Kind})
        before = self.clusters
        joined = np.concatenate([before.states, records])
        began_us = np.concatenate([before.birth_us, records["t_us"]])
        order = np.argsort(joined["track_id"], kind="stable")
        track_id, kind = joined["track_id"][order], joined["kind"][order]
        ended = (kind == Kind.MERGED) | (kind == Kind.LOST)
        follows = np.append(False, track_id[1:] == track_id[:-1])  # the record before it is of the same track
        begins = ~follows | (kind == Kind.BORN) | np.append(False, ended[:-1])
        birth = np.maximum.accumulate(np.where(begins, np.arange(len(order)), 0))
        newest = np.flatnonzero(np.append(~follows[1:], True) & ~ended)
        self.clusters = Clusters(joined[order[newest]], began_us[order[birth[newest]]])
