# SPDX-License-Identifier: Apache-2.0
"""Windows to verdicts: the network in integers, and the vote of a track."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit
from ..hardware.classifier import HIDDEN_MAX, LOSS_MAX, NONE, VOTED_MAX

__all__ = ["judge"]

Table = NDArray[Any]


@njit(cache=True, nogil=True)
def judge(
    w1: Table, w2: Table, shift_1: int, shift_2: int, margin_min: int,
    closed: Table, stages: Table, images: Table, votes: Table, voted: Table, out: Table,
) -> int:  # fmt: skip
    """Evaluate windows in their order, see `_windows.fill`; `out` takes seq, slot, class, margin and windows of each verdict.

    Args:
        w1, w2: (cells, hidden) and (hidden, classes) int32.
        votes, voted: (slots, classes) and (slots,), the vote of each slot, and how many windows are in it.

    Returns:
        Number of verdicts.
    """
    n = 0
    classes = w2.shape[1]
    hidden = np.zeros(w1.shape[1], np.int32)
    scores = np.zeros(classes, np.int32)
    for window in range(len(stages)):
        if stages[window] == 0:
            continue
        hidden[:] = 0
        for cell in range(w1.shape[0]):
            count = np.int32(images[window, cell])
            if count:
                for j in range(len(hidden)):
                    hidden[j] += w1[cell, j] * count
        scores[:] = 0
        for j in range(len(hidden)):
            value = min(max(hidden[j], 0) >> shift_1, HIDDEN_MAX)
            for k in range(classes):
                scores[k] += w2[j, k] * value
        i = closed[window, 1]
        if stages[window] == 1:
            voted[i] = 0
            votes[i] = 0
        if voted[i] == VOTED_MAX:
            voted[i] >>= 1
            for k in range(classes):
                votes[i, k] >>= 1
        voted[i] += 1
        best = scores.max()
        for k in range(classes):
            votes[i, k] += min((best - scores[k]) >> shift_2, LOSS_MAX)
        winner = 0
        for k in range(1, classes):
            if votes[i, k] < votes[i, winner]:
                winner = k
        margin = LOSS_MAX * VOTED_MAX
        for k in range(classes):
            if k != winner:
                margin = min(margin, votes[i, k] - votes[i, winner])
        out[n, 0] = closed[window, 0]
        out[n, 1] = i
        out[n, 2] = NONE if margin < margin_min * voted[i] else winner
        out[n, 3] = margin
        out[n, 4] = voted[i]
        n += 1
    return n
