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
    """Clusters visible at one moment: `states`, (k,) of dtype `TRACK`, the last record of each; `birth_us`, (k,) int64."""

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
        born = records[records["kind"] == Kind.BORN]
        ids = np.concatenate([before.states["track_id"], born["track_id"]])
        births_us = np.concatenate([before.birth_us, born["t_us"]])
        joined = np.concatenate([before.states, records])[::-1]
        _, last = np.unique(joined["track_id"], return_index=True)
        states = joined[last]
        states = states[(states["kind"] != Kind.MERGED) & (states["kind"] != Kind.LOST)]
        order = np.argsort(ids)
        self.clusters = Clusters(states, births_us[order[np.searchsorted(ids, states["track_id"], sorter=order)]])
