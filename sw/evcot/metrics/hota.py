# SPDX-License-Identifier: Apache-2.0
"""HOTA: J. Luiten, A. Ošep, P. Dendorfer, P. Torr, A. Geiger, L. Leal-Taixé, B. Leibe, "HOTA: A Higher Order Metric for
Evaluating Multi-Object Tracking", International Journal of Computer Vision 129, 2021.

At every instant objects and tracks are matched one to one to maximise the sum of similarity times global alignment, which
measures how well object and track agree over the whole time. Each threshold selects the pairs of sufficient similarity.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..tracks.pairing import assignment
from .frames import Frames, Matches, Pairs

__all__ = ["THRESHOLDS", "Hota", "hota"]

THRESHOLDS = np.arange(0.05, 0.99, 0.05)
_EPS = float(np.finfo(np.float64).eps)


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
