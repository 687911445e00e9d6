# SPDX-License-Identifier: Apache-2.0
"""Optimal pairing of two sets when few of the possible pairs are allowed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

__all__ = ["best_pairs", "closest_pairs"]


def best_pairs(left: NDArray[np.int64], right: NDArray[np.int64], gain: NDArray[np.float64]) -> NDArray[np.int64]:
    """Choose pairs, each element in one at most, whose total gain is the largest possible.

    The pairs fall apart into groups that share no element; each group is solved on its own, so that the cost grows with the
    size of the groups and not with that of the whole.

    Args:
        left, right: (n,) the allowed pairs, each once, as non-negative element numbers.
        gain: (n,) what each is worth, above 0.

    Returns:
        Indices of the chosen pairs, ascending.
    """
    if not len(left):
        return np.empty(0, np.int64)
    n_left = int(left.max()) + 1
    size = n_left + int(right.max()) + 1
    graph = coo_array((np.ones(len(left), np.int8), (left, n_left + right)), shape=(size, size))
    group = connected_components(graph, directed=False)[1][left]
    order = np.argsort(group, kind="stable")
    starts = np.flatnonzero(np.diff(group[order], prepend=-1))
    sizes = np.diff(starts, append=len(order))
    chosen = [order[starts[sizes == 1]]]
    for start, count in zip(starts[sizes > 1], sizes[sizes > 1], strict=True):
        pairs = order[start : start + count]
        rows, row = np.unique(left[pairs], return_inverse=True)
        columns, column = np.unique(right[pairs], return_inverse=True)
        gains = np.zeros((len(rows), len(columns)))
        gains[row, column] = gain[pairs]
        index = np.full(gains.shape, -1)
        index[row, column] = pairs
        picked = index[linear_sum_assignment(gains, maximize=True)]
        chosen.append(picked[picked >= 0])
    return np.sort(np.concatenate(chosen))


def closest_pairs(left: NDArray[np.int64], right: NDArray[np.int64], cost: NDArray[np.float64]) -> NDArray[np.int64]:
    """As many pairs as possible and, among all ways to have so many, those of the smallest total cost.

    Args:
        left, right: (n,) the allowed pairs.
        cost: (n,) what each costs, from 0 up.

    Returns:
        Indices of the chosen pairs, ascending.
    """
    if not len(left):
        return np.empty(0, np.int64)
    # One pair more must outweigh whatever all others cost together.
    more = (len(left) + 1) * max(float(cost.max()), 1.0)
    return best_pairs(left, right, more - cost)
