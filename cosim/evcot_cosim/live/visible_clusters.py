# SPDX-License-Identifier: Apache-2.0
"""The set of currently visible clusters, updated from records and verdicts."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from evcot.tracks.log import TRACK, Kind
from evcot.tracks.record import NO_CLASS, NO_NAMES, ClassNames, no_verdicts

__all__ = ["Alive", "Clusters"]


@dataclass(frozen=True)
class Clusters:
    """Clusters visible at one moment.

    Attributes:
        states: (k,) of dtype `TRACK`, the last record of each.
        birth_us: (k,) int64, when each became visible; of one that was lost, when it was found again.
        label: (k,) int64, the class of each by its last verdict, a place in `Alive.labels`.
    """

    states: NDArray[np.void] = field(default_factory=lambda: np.empty(0, TRACK))
    birth_us: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))
    label: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))


_NO_VERDICTS = no_verdicts()


class Alive:
    """Applies records; `clusters` is replaced as a whole, so that another thread may read it at any time.

    Args:
        class_names: of all classes of the tracker's classifier; empty without one.

    Attributes:
        clusters: the visible clusters, in order of track id.
        count: number of records of each kind so far.
        labels: how classes are shown: none yet, none of the classes, and each class.
    """

    def __init__(self, class_names: ClassNames = NO_NAMES) -> None:
        self.clusters = Clusters()
        self.count: Counter[Kind] = Counter()
        self.labels = ("", NO_CLASS, *class_names.values())
        self._places = {class_id: place for place, class_id in enumerate((-1, *class_names), 1)}
        self._newest: dict[int, tuple[int, int]] = {}  # of each slot with a verdict: track and label of the last one

    def apply(self, records: NDArray[np.void], verdicts: NDArray[np.void] = _NO_VERDICTS) -> None:
        """Apply records and verdicts, in order."""
        for slot, track_id, class_id in verdicts[["slot", "track_id", "class_id"]].tolist():
            self._newest[slot] = track_id, self._places[class_id]
        if len(records):
            self._apply_records(records)
        if self._newest:
            labels = [self._label(*cluster) for cluster in self.clusters.states[["slot", "track_id"]].tolist()]
            self.clusters = replace(self.clusters, label=np.array(labels, np.int64))

    def _label(self, slot: int, track_id: int) -> int:
        of, place = self._newest.get(slot, (track_id, 0))
        return place if of == track_id else 0

    def _apply_records(self, records: NDArray[np.void]) -> None:
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
        self.clusters = Clusters(joined[order[newest]], began_us[order[birth[newest]]], np.zeros(len(newest), np.int64))
