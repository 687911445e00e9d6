# SPDX-License-Identifier: Apache-2.0
"""The owner of an event: exactly one slot, or none."""

from __future__ import annotations

from ..._numba_private import step
from ..contract import Mode
from ._state import FREE, LEFT, STATE, VISIBLE, Table
from ._windows import in_box, in_window

__all__ = ["find"]

SEEDED_MODE = int(Mode.SEEDED)


@step
def find(s: Table, modes: Table, x: int, y: int) -> tuple[int, bool, bool]:
    """The owner or -1; whether the event could be another visible slot's as well; whether it seeds a candidate there.

    The lowest visible slot whose box holds the event; else the lowest visible one by its window; else the lowest candidate by
    its window; else the lowest free slot; else the lowest whose track may return.
    """
    in_boxes = 0
    in_windows = 0
    by_box = -1
    by_window = -1
    candidate = -1
    free = -1
    left = -1
    for i in range(s.shape[1]):
        state = s[STATE, i]
        if state == FREE:
            if free < 0 and modes[i] == SEEDED_MODE:
                free = i
        elif state == LEFT:
            if left < 0 and modes[i] == SEEDED_MODE:
                left = i
        elif in_window(s, i, x, y):
            if state == VISIBLE:
                in_windows += 1
                if by_window < 0:
                    by_window = i
                if in_box(s, i, x, y):
                    in_boxes += 1
                    if by_box < 0:
                        by_box = i
            elif candidate < 0:
                candidate = i
    if in_boxes > 0:
        return by_box, in_boxes > 1, False
    if in_windows > 0:
        return by_window, in_windows > 1, False
    if candidate >= 0:
        return candidate, False, False
    if free < 0:
        free = left
    return free, False, free >= 0
