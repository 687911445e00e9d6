# SPDX-License-Identifier: Apache-2.0
"""How two boxes lie to each other, for compiled functions: (2, 2) tables, centre and half side by axis."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from .._numba_private import step

__all__ = ["mostly_within", "overlap", "together"]

Table = NDArray[Any]

_WITHIN = 0.7  # share of the smaller box that lies in the larger


@step
def mostly_within(a: Table, b: Table) -> bool:
    """Whether most of the smaller box lies in the larger, along both axes."""
    for axis in range(2):
        shared = a[axis, 1] + b[axis, 1] - abs(a[axis, 0] - b[axis, 0])
        if shared < 2.0 * _WITHIN * min(a[axis, 1], b[axis, 1]):
            return False
    return True


@step
def overlap(a: Table, b: Table, axis: int) -> float:
    """The length along an axis that two boxes share; negative for the gap between them."""
    return float(min(a[axis, 0] + a[axis, 1], b[axis, 0] + b[axis, 1]) - max(a[axis, 0] - a[axis, 1], b[axis, 0] - b[axis, 1]))


@step
def together(a: Table, b: Table, axis: int) -> float:
    """The length along an axis of both boxes together."""
    return float(max(a[axis, 0] + a[axis, 1], b[axis, 0] + b[axis, 1]) - min(a[axis, 0] - a[axis, 1], b[axis, 0] - b[axis, 1]))
