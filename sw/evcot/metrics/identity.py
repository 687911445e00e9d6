# SPDX-License-Identifier: Apache-2.0
"""ID scores: E. Ristani, F. Solera, R. Zou, R. Cucchiara, C. Tomasi, "Performance Measures and a Data Set for Multi-Target,
Multi-Camera Tracking", ECCV Workshops, 2016.

Objects and tracks are assigned one to one for the whole time, to maximise the number of instants at which they agree.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..tracks.pairing import best_pairs
from .frames import Frames, Pairs

__all__ = ["Identity", "identity"]


@dataclass(frozen=True)
class Identity:
    """ID scores.

    Attributes:
        idf1: idtp / (idtp + idfp / 2 + idfn / 2).
        idp: idtp / (idtp + idfp), idr: idtp / (idtp + idfn); all three are 0 for 0 / 0.
        idtp: instants at which an object and its track agree; idfp, idfn: all other instants of tracks and of objects.
    """

    idf1: float
    idp: float
    idr: float
    idtp: int
    idfp: int
    idfn: int


def identity(frames: Frames, threshold: float = 0.5) -> Identity:
    """ID scores of tracks at a similarity threshold.

    Minimising idfp + idfn is equivalent to maximising idtp.
    """
    met_truth, met_track = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for truth, tracks, similarity in zip(frames.truth, frames.tracks, frames.similarity, strict=True):
        row, column = np.nonzero(similarity >= threshold)
        met_truth.append(truth[row])
        met_track.append(tracks[column])
    pairs = Pairs.of(np.concatenate(met_truth), np.concatenate(met_track), frames.n_tracks)
    times = np.bincount(pairs.of_each, minlength=len(pairs.truth))
    chosen = best_pairs(pairs.truth, pairs.track, times.astype(np.float64))
    idtp = int(times[chosen].sum())
    idfp, idfn = int(frames.track_lengths.sum()) - idtp, int(frames.truth_lengths.sum()) - idtp
    return Identity(
        idf1=idtp / max(idtp + idfp / 2 + idfn / 2, 1),
        idp=idtp / max(idtp + idfp, 1),
        idr=idtp / max(idtp + idfn, 1),
        idtp=idtp,
        idfp=idfp,
        idfn=idfn,
    )
