# SPDX-License-Identifier: Apache-2.0
"""The owner of an event: exactly one slot, or none."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..._numba_private import step
from ...bits import lowest, without_lowest
from ._places import BOX_X, BOX_Y, OF_STATE, WIN_X, WIN_Y
from ._state import CANDIDATE, FREE, LEFT, VISIBLE, Table

__all__ = ["find"]


@step
def _first(slots: Any) -> Any:
    """The lowest slot of a set, as a signed number."""
    return np.int64(lowest(slots))


@step
def find(places: Table, x: int, y: int) -> tuple[int, bool, bool]:
    """The owner or -1; whether the event could be another visible slot's as well; whether it seeds a candidate there.

    The lowest visible slot whose box holds the event; else the lowest visible one by its window; else the lowest candidate by
    its window; else the lowest free slot; else the lowest whose track may return.
    """
    held = places[WIN_X, x] & places[WIN_Y, y]
    visible = held & places[OF_STATE, VISIBLE]
    if visible:
        by_box = visible & places[BOX_X, x] & places[BOX_Y, y]
        if by_box:
            visible = by_box
        return _first(visible), without_lowest(visible) != 0, False
    candidates = held & places[OF_STATE, CANDIDATE]
    if candidates:
        return _first(candidates), False, False
    free = places[OF_STATE, FREE]
    if not free:
        free = places[OF_STATE, LEFT]
    if not free:
        return -1, False, False
    return _first(free), False, True
