# SPDX-License-Identifier: Apache-2.0
"""Which tracks of two logs are of one object: those that were near each other at most samples.

Lives come as rows of dtype `ROW`, as they end, and are read run by run: memory depends on how many tracks met at a sample, and
not on how many there are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .column import Column, in_runs
from .pairing import best_pairs
from .timeline import LIFE

__all__ = ["ROW", "PairedTracks", "pair_tracks"]

ROW = np.dtype([(name, LIFE[name]) for name in ("track_id", "birth_us", "end_us", "ended")] + [("goes_on", "?")])
"""A life, and whether it goes on with a track that was lost before."""

_TRACK = np.dtype([*ROW.descr, ("row", "<i8")])  # from its first life to the end of its last; the number of the first one


@dataclass(frozen=True)
class PairedTracks:
    """Pairs, in order of the hardware track's birth, and tracks without a partner.

    Attributes:
        hardware, software: (n,) the tracks of each pair: `track_id`, `birth_us`, `end_us`.
        samples: (n,) how often each pair met.
        hardware_alone, software_alone: ids of the first tracks without a partner, in order of birth.
    """

    hardware: NDArray[np.void]
    software: NDArray[np.void]
    samples: NDArray[np.int64]
    hardware_alone: NDArray[np.int64]
    software_alone: NDArray[np.int64]


def pair_tracks(hardware: Column, software: Column, met: NDArray[np.int64], *, by_row: bool, most: int | None) -> PairedTracks:
    """Pair tracks so that their total time together is longest.

    Args:
        hardware, software: rows of dtype `ROW`.
        met: (k, 2) hardware and software id, for each sample at which they were paired.
        by_row: rows are in order of birth; otherwise equal births are in order of ids.
        most: largest number of ids without a partner; None: all.
    """
    met, together = np.unique(met, axis=0, return_counts=True)
    hw, sw = (_tracks(rows, np.unique(met[:, side]), by_row=by_row) for side, rows in enumerate((hardware, software)))
    i, j = _row_of(hw, met[:, 0]), _row_of(sw, met[:, 1])
    chosen = best_pairs(i, j, together.astype(np.float64))
    chosen = chosen[np.argsort(i[chosen])]
    ours, theirs = hw[i[chosen]], sw[j[chosen]]
    alone = (_others(rows, np.sort(own["row"]), by_row, most) for rows, own in ((hardware, ours), (software, theirs)))
    return PairedTracks(ours, theirs, together[chosen], *alone)


def _tracks(rows: Column, ids: NDArray[np.int64], *, by_row: bool) -> NDArray[np.void]:
    """The tracks with these ids, in order of birth; one that was lost and found again lasts from its first life to its last."""
    parts = [np.empty(0, _TRACK)]
    for begin, run in in_runs(rows):
        which = np.flatnonzero(np.isin(run["track_id"], ids))
        part = np.empty(len(which), _TRACK)
        for name in ROW.names or ():
            part[name] = run[name][which]
        part["row"] = begin + which
        parts.append(part)
    lives = np.concatenate(parts)
    lives = lives[np.lexsort((lives["birth_us"], lives["track_id"]))]
    first = np.flatnonzero(~lives["goes_on"])
    last = np.append(first[1:], len(lives)) - 1 if len(first) else first
    tracks = lives[first]
    tracks["end_us"] = lives["end_us"][last]
    return tracks[_by_birth(tracks, by_row)]


def _by_birth(tracks: NDArray[np.void], by_row: bool) -> NDArray[np.int64]:
    return np.lexsort((tracks["row"],) if by_row else (tracks["row"], tracks["track_id"], tracks["birth_us"]))


def _row_of(tracks: NDArray[np.void], ids: NDArray[np.int64]) -> NDArray[np.int64]:
    """Where each id is; of tracks with the same id, the last one."""
    order = np.argsort(tracks["track_id"], kind="stable")
    return order[np.searchsorted(tracks["track_id"][order], ids, "right") - 1] if len(order) else np.empty(0, np.int64)


def _others(rows: Column, taken: NDArray[np.int64], by_row: bool, most: int | None) -> NDArray[np.int64]:
    """Ids of the first tracks whose first lives are not the rows `taken`, which ascend."""
    found = np.empty(0, _TRACK)
    for begin, run in in_runs(rows):
        free = ~run["goes_on"]
        free[taken[slice(*np.searchsorted(taken, (begin, begin + len(run))))] - begin] = False
        which = np.flatnonzero(free)
        part = np.empty(len(which), _TRACK)
        for name in ("track_id", "birth_us"):
            part[name] = run[name][which]
        part["row"] = begin + which
        found = np.concatenate((found, part))
        found = found[_by_birth(found, by_row)[:most]]
    return np.asarray(found["track_id"], np.int64)
