# SPDX-License-Identifier: Apache-2.0
"""How many events that are decided again were touched by the window that changed, worked out by hand."""

from __future__ import annotations

import numpy as np

import replay
from evcot.hardware.contract import RECORD
from evcot.hardware.model import Decisions
from evcot.tracks.log import Kind


def record(kind: Kind, slot: int, seq: int, x: int, radius: int) -> tuple[Kind, int, int, int, int, int]:
    return kind, slot, seq, x * 16, 64 * 16, radius


def decided(records: list[tuple[Kind, int, int, int, int, int]], owners: list[int]) -> Decisions:
    rows = np.zeros(len(records), RECORD)
    for row, values in zip(rows, records, strict=True):
        for name, value in zip(("kind", "slot", "seq", "cm_x", "cm_y", "radius"), values, strict=True):
            row[name] = value
    empty = np.zeros(len(owners), np.uint16)
    return Decisions(rows, np.array(owners, np.int16), empty, empty)


def test_events_in_the_old_window_in_the_new_one_or_of_the_slot_are_touched() -> None:
    # Slot 1 is born at 20, [16, 24], and moves to 30, [26, 34]. Behind: 90 of slot 0, 17 in the old window, 34 in the new.
    records = [record(Kind.BORN, 1, 0, 20, 4), record(Kind.LOST, 0, 3, 0, 0), record(Kind.MOVED, 1, 5, 30, 4)]
    x = np.array([20, 60, 61, 62, 63, 30, 90, 17, 34, 35], np.uint16)
    y = np.full(10, 64, np.uint16)
    found = replay.replayed(decided(records, [1, 0, 0, 0, 0, 1, 0, -1, -1, -1]), x, y, 4, lost=6)
    # Behind the birth 60 to 63 and 30, which is slot 1's; behind the move 90, 17, 34 and 35, then nothing.
    assert found == (2, 9, 3, 4 + 1)


def test_nothing_touched_saves_all_but_a_clock() -> None:
    x = np.array([20, *[100] * 9], np.uint16)
    found = replay.replayed(decided([record(Kind.BORN, 1, 0, 20, 4)], [1, *[-1] * 9]), x, np.full(10, 64, np.uint16), 4, lost=6)
    assert found == (1, 5, 0, 5)


def test_a_window_of_another_life_is_not_the_old_one() -> None:
    records = [record(Kind.BORN, 0, 0, 100, 4), record(Kind.LOST, 0, 1, 100, 4), record(Kind.BORN, 0, 1, 20, 4)]
    x = np.array([100, 20, 100, 100, 20], np.uint16)
    found = replay.replayed(decided(records, [0, 0, -1, -1, -1]), x, np.full(5, 64, np.uint16), 4, lost=4)
    # Behind the first birth 20, of slot 0, and twice 100; behind the second 100 twice, then 20.
    assert found == (2, 6, 4, 0 + 2)
