# SPDX-License-Identifier: Apache-2.0
"""The scores of multi-object tracking: CLEAR MOT, HOTA, and ID scores."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..tracks.track_pairs import assignment, best_pairs
from .frames import Frames, Matches, Pairs

__all__ = ["THRESHOLDS", "Clear", "Hota", "Identity", "clear", "hota", "identity"]


# CLEAR MOT: K. Bernardin, R. Stiefelhagen, "Evaluating Multiple Object Tracking Performance: The CLEAR MOT Metrics",
# EURASIP Journal on Image and Video Processing, 2008.
#
# At every instant objects and tracks are matched one to one, if their similarity reaches the threshold. A pair that was matched
# before stays matched, even if others are nearer; the rest is matched to maximise the sum of similarities.

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


# HOTA: J. Luiten, A. Ošep, P. Dendorfer, P. Torr, A. Geiger, L. Leal-Taixé, B. Leibe, "HOTA: A Higher Order Metric for
# Evaluating Multi-Object Tracking", International Journal of Computer Vision 129, 2021.
#
# At every instant objects and tracks are matched one to one to maximise the sum of similarity times global alignment, which
# measures how well object and track agree over the whole time. Each threshold selects the pairs of sufficient similarity.

THRESHOLDS = np.arange(0.05, 0.99, 0.05)


@dataclass(frozen=True)
class Hota:
    """HOTA scores, each averaged over `THRESHOLDS`.

    TP, FP, FN are the matched pairs, unmatched tracks and unmatched objects at all instants. For a pair c of TP, TPA is the
    number of instants at which its track and its object are matched with each other; FPA, FNA those of the track and of the
    object at which they are not:

    Attributes:
        hota: sqrt(DetA AssA).
        deta: TP / (TP + FN + FP); dere: TP / (TP + FN); depr: TP / (TP + FP).
        assa: mean over c of TPA / (TPA + FNA + FPA); asre: of TPA / (TPA + FNA); aspr: of TPA / (TPA + FPA).
        loca: mean similarity of matched pairs; 1 if there are none.
    """

    hota: float
    deta: float
    assa: float
    loca: float
    detre: float
    detpr: float
    assre: float
    asspr: float


def hota(frames: Frames) -> Hota:
    """HOTA scores of tracks; without objects or tracks all are 0 except LocA."""
    matches = _match(frames)
    pairs = Pairs.of(matches.truth, matches.track, frames.n_tracks)
    at = [_scores(frames, matches, pairs, float(threshold)) for threshold in THRESHOLDS]
    return Hota(*(float(mean) for mean in np.mean(at, axis=0)))


def _match(frames: Frames) -> Matches:
    alignment = _alignment(frames)
    parts = []
    for frame, (truth, tracks, similarity) in enumerate(zip(frames.truth, frames.tracks, frames.similarity, strict=True)):
        row, column = assignment(alignment[np.ix_(truth, tracks)] * similarity)
        parts.append((frame, truth[row], tracks[column], similarity[row, column]))
    return Matches.joined(parts)


def _alignment(frames: Frames) -> NDArray[np.float64]:
    """(n_truth, n_tracks): Jaccard index of object and track over the whole time, with each instant weighted by their
    similarity relative to that of competing pairs."""
    together = np.zeros((frames.n_truth, frames.n_tracks))
    for truth, tracks, similarity in zip(frames.truth, frames.tracks, frames.similarity, strict=True):
        either = similarity.sum(0) + similarity.sum(1)[:, None] - similarity
        together[np.ix_(truth, tracks)] += np.divide(similarity, either, out=np.zeros_like(similarity), where=either > _EPS)
    return together / (frames.truth_lengths[:, None] + frames.track_lengths - together)


def _scores(frames: Frames, matches: Matches, pairs: Pairs, threshold: float) -> tuple[float, ...]:
    """The fields of `Hota` at one threshold."""
    kept = matches.similarity >= threshold - _EPS
    tp = int(kept.sum())
    fn, fp = int(frames.truth_lengths.sum()) - tp, int(frames.track_lengths.sum()) - tp
    times = np.bincount(pairs.of_each[kept], minlength=len(pairs.truth))
    met = np.flatnonzero(times)
    tpa, truth, track = times[met], frames.truth_lengths[pairs.truth[met]], frames.track_lengths[pairs.track[met]]
    assa, assre, asspr = (float(np.sum(tpa * tpa / of)) / max(tp, 1) for of in (truth + track - tpa, truth, track))
    deta = tp / max(tp + fn + fp, 1)
    loca = float(matches.similarity[kept].mean()) if tp else 1.0
    return (deta * assa) ** 0.5, deta, assa, loca, tp / max(tp + fn, 1), tp / max(tp + fp, 1), assre, asspr


# ID scores: E. Ristani, F. Solera, R. Zou, R. Cucchiara, C. Tomasi, "Performance Measures and a Data Set for Multi-Target,
# Multi-Camera Tracking", ECCV Workshops, 2016.
#
# Objects and tracks are assigned one to one for the whole time, to maximise the number of instants at which they agree.


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
