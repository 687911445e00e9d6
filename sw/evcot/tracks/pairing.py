# SPDX-License-Identifier: Apache-2.0
"""Optimal assignment between two sets with a sparse set of allowed pairs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["assignment", "best_pairs", "closest_pairs", "most_first", "within"]


def assignment(gain: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows and columns, each at most once, that maximise the total gain; rows ascending.

    Args:
        gain: (rows, columns) gain of each pair.
    """
    # Loaded at the first choice to make: it takes longer than all else that a short command loads of scipy.
    from scipy.optimize import linear_sum_assignment

    rows, columns = linear_sum_assignment(gain, maximize=True)
    return rows, columns


def best_pairs(left: NDArray[np.int64], right: NDArray[np.int64], gain: NDArray[np.float64]) -> NDArray[np.int64]:
    """Choose pairs, with each element in at most one, that maximise the total gain.

    The pairs are split into connected components, which are solved independently, so that the cost depends on the size of
    the components and not on the total.

    Args:
        left, right: (n,) the allowed pairs, each once, as non-negative element indices.
        gain: (n,) gain of each pair, above 0.

    Returns:
        Indices of the chosen pairs, ascending.
    """
    if not len(left):
        return np.empty(0, np.int64)
    # As in `assignment`: a command that compares nothing loads none of scipy.
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

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
        picked = index[assignment(gains)]
        chosen.append(picked[picked >= 0])
    return np.sort(np.concatenate(chosen))


def closest_pairs(left: NDArray[np.int64], right: NDArray[np.int64], cost: NDArray[np.float64]) -> NDArray[np.int64]:
    """Choose as many pairs as possible and, among all such choices, the one with the smallest total cost.

    Args:
        left, right: (n,) the allowed pairs.
        cost: (n,) cost of each pair, at least 0.

    Returns:
        Indices of the chosen pairs, ascending.
    """
    if not len(left):
        return np.empty(0, np.int64)
    return best_pairs(left, right, most_first(len(left), float(cost.max())) - cost)


def most_first(count: int, dearest: float) -> float:
    """What a pair is worth, before its cost, so that one more pair is worth more than the cost of all others.

    Args:
        count: number of allowed pairs.
        dearest: the largest cost of one.
    """
    return (count + 1) * max(dearest, 1.0)


def within(left: NDArray[np.number], right: NDArray[np.number], reach: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """All (i, j) with |left[i] - right[j]| <= reach; `right` ascending."""
    first = np.searchsorted(right, left - reach, "left")
    count = np.searchsorted(right, left + reach, "right") - first
    i = np.repeat(np.arange(len(left)), count)
    j = np.arange(len(i)) - np.repeat(np.cumsum(count) - count, count) + first[i]
    return i, j
