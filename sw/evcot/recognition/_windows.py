# SPDX-License-Identifier: Apache-2.0
"""Kernels of the classifier.

Owned events to windows: normalised images of a slot's events, and the queue of windows that wait to be evaluated. Windows to
verdicts: the network in integers, and the vote of a track.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit, step
from ..hardware.classifier import CELLS, COUNT_MAX, HIDDEN_MAX, LOSS_MAX, NONE, SERVICE_EVENTS, VOTED_MAX

__all__ = ["BUSY", "FIELD_COUNT", "FRESH", "GLOBAL_COUNT", "STAGE", "fill", "judge"]

Table = NDArray[Any]

# A slot's state (docs/recognition.md).
COUNT, FRESH, PENDING, STAGE, OFF_U, OFF_V, SCALE_X, SCALE_Y, SKEW = range(9)
FIELD_COUNT = 9
# Of all slots: owned events until the first window of the queue leaves it, number of the queue's windows. The queue follows.
BUSY, WAITING, QUEUE = range(3)
GLOBAL_COUNT = QUEUE

_HALF = CELLS // 2
_LOWEST, _HIGHEST = -_HALF << 8, (_HALF << 8) - 1  # of a normalised address, 2^-8 cells


@step
def _clamp(value: int, low: int, high: int) -> int:
    return min(max(value, low), high)


@step
def _signed(value: Any, half: int) -> Any:
    """An address of so many bits that its highest has the weight -`half`."""
    return ((np.int64(value) + half) & (2 * half - 1)) - half


@step
def _advance_queue(s: Table, glob: Table) -> None:
    """Rule Q2, before each owned event."""
    if not glob[WAITING]:
        return
    glob[BUSY] -= 1
    if glob[BUSY]:
        return
    s[glob[QUEUE], PENDING] = 0
    glob[WAITING] -= 1
    for k in range(glob[WAITING]):
        glob[QUEUE + k] = glob[QUEUE + k + 1]
    glob[BUSY] = SERVICE_EVENTS


@step
def _count(s: Table, cells: Table, i: int, dx: int, dy: int) -> None:
    """Rules N1 and N2: the event is counted in its cell."""
    v = _clamp(((dy * s[i, SCALE_Y]) >> 4) - s[i, OFF_V], _LOWEST, _HIGHEST)
    u = _clamp(((dx * s[i, SCALE_X]) >> 4) - s[i, OFF_U] - ((s[i, SKEW] * v) >> 7), _LOWEST, _HIGHEST)
    cell = ((v >> 8) + _HALF) * CELLS + (u >> 8) + _HALF
    if cells[i, cell] < COUNT_MAX:
        cells[i, cell] += 1


@step
def _fit(s: Table, cells: Table, i: int, window_log2: int) -> None:
    """Rules F1 and F2: the next window's normalisation follows the moments of this one's image."""
    total = sum_u = sum_v = spread_u = spread_v = skewed = 0
    for cell in range(CELLS * CELLS):
        count: Any = np.int64(cells[i, cell])  # signed: products with unsigned numbers would be floats
        u = 2 * (cell % CELLS) - CELLS + 1
        v = 2 * (cell // CELLS) - CELLS + 1
        total += count
        sum_u += count * u
        sum_v += count * v
        spread_u += count * abs(u)
        spread_v += count * abs(v)
        skewed += count * (u if v > 0 else -u)
    slow = 0 if s[i, STAGE] == 0 else 2
    s[i, OFF_U] = _clamp(s[i, OFF_U] + ((sum_u << 7) >> (window_log2 + slow)), -1024, 1023)
    s[i, OFF_V] = _clamp(s[i, OFF_V] + ((sum_v << 7) >> (window_log2 + slow)), -1024, 1023)
    by = window_log2 + 3 + slow
    s[i, SCALE_X] = _clamp(s[i, SCALE_X] + ((s[i, SCALE_X] * (9 * total - 2 * spread_u)) >> by), 16, 4095)
    s[i, SCALE_Y] = _clamp(s[i, SCALE_Y] + ((s[i, SCALE_Y] * (9 * total - 2 * spread_v)) >> by), 16, 4095)
    s[i, SKEW] = _clamp(s[i, SKEW] + ((skewed << 5) >> (window_log2 + slow)), -127, 127)


@njit(cache=True, nogil=True)
def fill(
    s: Table, glob: Table, cells: Table, window_log2: int, scale_start: int, rel_w: int,
    owner: Table, rel_x: Table, rel_y: Table, visible: Table, done: int, closed: Table, stages: Table, images: Table,
) -> tuple[int, int]:  # fmt: skip
    """Process a run of events, of which `done` are done, to its end or until `closed` could overflow.

    A row of `closed` is the event that closed a window and its slot; `stages` has the window's stage, `images` its cells.

    Returns:
        Events done and windows closed.
    """
    n = 0
    half = 1 << (rel_w - 1)
    whole = 1 << window_log2
    for e in range(done, len(owner)):
        i = owner[e]
        if i < 0:
            continue
        if n == len(closed):
            return e, n
        _advance_queue(s, glob)
        if not visible[e]:
            s[i, COUNT] = 0
            s[i, FRESH] = 1
            continue
        if s[i, PENDING]:
            continue
        if s[i, COUNT] == 0:
            cells[i] = 0
            if s[i, FRESH]:
                s[i, FRESH] = 0
                s[i, STAGE] = 0
                s[i, OFF_U] = s[i, OFF_V] = s[i, SKEW] = 0
                s[i, SCALE_X] = s[i, SCALE_Y] = scale_start
        _count(s, cells, i, _signed(rel_x[e], half), _signed(rel_y[e], half))
        s[i, COUNT] += 1
        if s[i, COUNT] == whole:
            s[i, COUNT] = 0
            s[i, PENDING] = 1
            if not glob[WAITING]:
                glob[BUSY] = SERVICE_EVENTS
            glob[QUEUE + glob[WAITING]] = i
            glob[WAITING] += 1
            closed[n, 0] = e
            closed[n, 1] = i
            stages[n] = s[i, STAGE]
            images[n] = cells[i]
            n += 1
            _fit(s, cells, i, window_log2)
            s[i, STAGE] = min(s[i, STAGE] + 1, 2)
    return len(owner), n


@njit(cache=True, nogil=True)
def judge(
    w1: Table, w2: Table, shift_1: int, shift_2: int, margin_min: int,
    closed: Table, stages: Table, images: Table, votes: Table, voted: Table, out: Table,
) -> int:  # fmt: skip
    """Evaluate windows in their order, see `fill`; `out` takes seq, slot, class, margin and windows of each verdict.

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
