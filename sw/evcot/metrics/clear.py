# SPDX-License-Identifier: Apache-2.0
"""CLEAR MOT: K. Bernardin, R. Stiefelhagen, "Evaluating Multiple Object Tracking Performance: The CLEAR MOT Metrics",
EURASIP Journal on Image and Video Processing, 2008.

At every instant objects and tracks are matched one to one, if their similarity reaches the threshold. A pair that was matched
before stays matched, even if others are nearer; the rest is matched to maximise the sum of similarities.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..tracks.pairing import assignment
from .frames import Frames, Matches

__all__ = ["Clear", "clear"]

_EPS = float(np.finfo(np.float64).eps)
_CONTINUED = 1000.0  # exceeds the sum of all other pairs' similarities


@dataclass(frozen=True)
class Clear:
    """CLEAR scores.

    Attributes:
        mota: 1 - (fn + fp + idsw) / objects, summed over the instants; 0 without objects.
        motp: mean similarity of matched pairs; 0 if there are none.
        tp, fp, fn: matched pairs, tracks without an object, objects without a track, summed over the instants.
        idsw: identity switches: matches of an object with a different track than the last one.
        frag: fragmentations: number of times an object was matched again after it had been lost.
        mt, pt, ml: objects matched at more than 80 % of their instants, at 20 % to 80 %, and at less.
        matches: the pairs.
    """

    mota: float
    motp: float
    tp: int
    fp: int
    fn: int
    idsw: int
    frag: int
    mt: int
    pt: int
    ml: int
    matches: Matches


def clear(frames: Frames, threshold: float = 0.5) -> Clear:
    """CLEAR scores of tracks at a similarity threshold.

    An instant without objects, or without tracks, does not change the pairs carried over to the next instant.
    """
    last = np.full(frames.n_truth, -1)  # the track with which an object was last matched, at any time
    before = np.full(frames.n_truth, -1)  # the same for the previous instant only
    starts = np.zeros(frames.n_truth, np.int64)  # number of times an object began to be matched
    idsw = 0
    parts = []
    for frame, (truth, tracks, similarity) in enumerate(zip(frames.truth, frames.tracks, frames.similarity, strict=True)):
        if not similarity.size:
            continue
        score = _CONTINUED * (tracks == before[truth][:, None]) + similarity
        score[similarity < threshold - _EPS] = 0
        row, column = assignment(score)
        matched = score[row, column] > _EPS
        row, column = row[matched], column[matched]
        objects, partners = truth[row], tracks[column]
        idsw += int(np.sum((last[objects] >= 0) & (last[objects] != partners)))
        starts[objects] += before[objects] < 0
        last[objects] = partners
        before[:] = -1
        before[objects] = partners
        parts.append((frame, objects, partners, similarity[row, column]))
    matches = Matches.joined(parts)

    tp = len(matches.truth)
    objects_all, tracks_all = int(frames.truth_lengths.sum()), int(frames.track_lengths.sum())
    fp, fn = tracks_all - tp, objects_all - tp
    ratio = np.bincount(matches.truth, minlength=frames.n_truth) / np.maximum(frames.truth_lengths, 1)
    mt, ml = int(np.sum(ratio > 0.8)), int(np.sum(ratio < 0.2))
    return Clear(
        mota=(tp - fp - idsw) / objects_all if objects_all else 0.0,
        motp=float(matches.similarity.sum()) / max(tp, 1),
        tp=tp,
        fp=fp,
        fn=fn,
        idsw=idsw,
        frag=int(np.maximum(starts - 1, 0).sum()),
        mt=mt,
        pt=frames.n_truth - mt - ml,
        ml=ml,
        matches=matches,
    )
