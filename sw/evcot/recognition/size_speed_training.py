# SPDX-License-Identifier: Apache-2.0
"""Training of rules S (docs/recognition.md), on the verdicts of a trained network, with size and speed of their tracks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ._votes import judge
from .size_speed import inputs_of
from .training import UNLABELLED, LabelledWindows
from .weights import Weights

__all__ = ["fitted_size_speed", "verdicts_of"]

_RIDGE = 1e-3  # of the weights' squares, in units of the mean loss of a track
_STEPS = 500
_SPREAD_MIN = 1e-6  # of an input's standard deviation: others are constant


def verdicts_of(weights: Weights, windows: LabelledWindows) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Winner, margin and number of windows of the vote after each window, (n,) int64, without `margin_min`."""
    tracks, track = np.unique(windows.track_id, return_inverse=True)
    stages = np.full(len(track), 2, np.uint8)  # not 1, which begins a vote: each track has its own
    registers, network = weights.registers, weights.network
    pairs = np.stack((np.arange(len(track)), track), axis=1)
    votes, voted = np.zeros((len(tracks), registers.classes), np.int64), np.zeros(len(tracks), np.int64)
    out = np.zeros((len(track), 5), np.int64)
    judge(
        network.w1.astype(np.int32), network.w2.astype(np.int32), registers.shift_1, registers.shift_2, 0,
        pairs, stages, windows.images, votes, voted, out,
    )  # fmt: skip
    return out[:, 2], out[:, 3], out[:, 4]


def fitted_size_speed(weights: Weights, windows: LabelledWindows, states: NDArray[np.void]) -> NDArray[np.float64]:
    """`Weights.size_speed` of a trained network: multinomial logistic regression, in which every track counts once.

    Args:
        windows: in the order of each track, those that the network was trained with.
        states: (n,) of dtype `TRACK`, the newest record of each window's track.
    """
    classes = len(weights.class_ids)
    inputs = inputs_of(*verdicts_of(weights, windows), states, classes)
    labelled = windows.class_id != UNLABELLED
    inputs, track_id = inputs[labelled], windows.track_id[labelled]
    wanted = windows.class_id[labelled][:, None] == np.array(weights.class_ids)
    _, track, counts = np.unique(track_id, return_inverse=True, return_counts=True)
    share = 1 / (counts[track] * len(counts))
    middle, spread = inputs.mean(axis=0), inputs.std(axis=0)
    middle[-1], spread[spread < _SPREAD_MIN] = 0.0, 1.0
    scaled = _logistic((inputs - middle) / spread, wanted.astype(np.float64), share) / spread[:, None]
    scaled[-1] -= middle @ scaled
    return np.asarray(scaled)


def _logistic(inputs: NDArray[np.float64], wanted: NDArray[np.float64], share: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weights, (inputs, classes): descent with the bound of the second derivative by Boehning (1992), which never diverges."""
    weights = np.zeros((inputs.shape[1], wanted.shape[1]))
    step = np.linalg.inv((inputs * share[:, None]).T @ inputs / 2 + _RIDGE * np.eye(len(weights)))
    for _ in range(_STEPS):
        scores = inputs @ weights
        likely = np.exp(scores - scores.max(axis=1, keepdims=True))
        likely /= likely.sum(axis=1, keepdims=True)
        weights -= step @ (inputs.T @ ((likely - wanted) * share[:, None]) + _RIDGE * weights)
    return weights
