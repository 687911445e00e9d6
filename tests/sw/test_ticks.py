# SPDX-License-Identifier: Apache-2.0
"""Ticked events: columns as kernels and drives need them, parts, bad input; and tick 0 of a recording that comes in runs."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import RecordingError
from evcot.events import Events
from evcot.ticks import TickCounter, TickedEvents
from support.tokens import ticked

COLUMNS = {"ticks": np.int64, "x": np.uint16, "y": np.uint16, "p": np.uint8}


def recording(*t_us: int) -> Events:
    n = len(t_us)
    x = np.arange(n, dtype=np.uint16)
    return Events(np.array(t_us, np.int64), x, x + np.uint16(10), (x % 2).astype(np.uint8))


def is_read_only_view(column: NDArray[np.generic], given: NDArray[np.generic]) -> bool:
    """Whether a column is the given one, in the same memory, but read-only."""
    return column.__array_interface__["data"] == (given.ctypes.data, True) and np.array_equal(column, given)


def test_good_columns_are_taken_as_they_are_and_are_read_only() -> None:
    given = {name: np.arange(5).astype(kind) for name, kind in COLUMNS.items()}
    made = TickedEvents(**given)
    assert all(is_read_only_view(getattr(made, name), column) for name, column in given.items())
    assert all(column.flags.writeable for column in given.values())


@pytest.mark.parametrize("name", COLUMNS)
@pytest.mark.parametrize("kind", [np.int64, np.uint8, ">i4", float])
def test_other_types_and_layouts_become_what_kernels_and_drives_read(name: str, kind: str | type) -> None:
    given = {each: np.arange(5).astype(own) for each, own in COLUMNS.items()}
    given[name] = np.arange(10).astype(kind)[::2]
    made = TickedEvents(**given)
    for each, own in COLUMNS.items():
        column = getattr(made, each)
        assert column.dtype == own
        assert column.flags.c_contiguous
    assert getattr(made, name).tolist() == [0, 2, 4, 6, 8]


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("x", 65536, "event 1: x = 65536: must be a value of uint16"),
        ("y", -1, "event 1: y = -1: must be a value of uint16"),
        ("p", 256, "event 1: p = 256: must be a value of uint8"),
        ("ticks", 0.5, "event 1: ticks = 0.5: must be a value of int64"),
        ("x", np.nan, "event 1: x = nan: must be a value of uint16"),
    ],
)
def test_a_value_that_its_type_cannot_hold_is_refused(name: str, value: float, message: str) -> None:
    columns = {each: np.array([0, 1, 1]) for each in COLUMNS} | {name: np.array([0, value, 1])}
    with pytest.raises(RecordingError) as caught:
        TickedEvents(**columns)  # type: ignore[arg-type]
    assert str(caught.value) == message


@pytest.mark.parametrize("short", COLUMNS)
def test_columns_of_different_length_are_refused(short: str) -> None:
    columns = {name: np.zeros(3 - (name == short), kind) for name, kind in COLUMNS.items()}
    lengths = ", ".join(str(len(column)) for column in columns.values())
    with pytest.raises(RecordingError, match=f"^ticks, x, y, p hold {lengths} values: all must be the same$"):
        TickedEvents(**columns)


def test_a_run_shares_memory_and_a_mask_chooses() -> None:
    events = ticked(np.arange(6), np.arange(6), np.arange(6) + 10, [0, 1] * 3)
    part = events[2:5]
    assert len(part) == 3
    assert (part.ticks.tolist(), part.x.tolist()) == ([2, 3, 4], [2, 3, 4])
    assert (part.y.tolist(), part.p.tolist()) == ([12, 13, 14], [0, 1, 0])
    assert all(np.shares_memory(getattr(part, name), getattr(events, name)) for name in COLUMNS)
    chosen = events[events.p == 1]
    assert (chosen.ticks.tolist(), chosen.y.tolist(), chosen.p.tolist()) == ([1, 3, 5], [11, 13, 15], [1, 1, 1])
    assert len(events[6:]) == 0


def test_a_mask_is_contiguous_and_one_value_per_event() -> None:
    events = ticked([0, 1, 2], 5, 5)
    keep = np.array([True, True, False, False, True, True])[::2]
    assert events.mask(keep).flags.c_contiguous
    assert events.mask(keep).tolist() == [True, False, True]
    with pytest.raises(RecordingError, match=r"^keep holds 2 values: must be one for each of 3 events$"):
        events.mask(keep[:2])


@pytest.mark.parametrize(("tick_us", "ticks"), [(1, [0, 9, 10, 25]), (10, [0, 0, 1, 2])])
def test_events_become_ticks_from_the_first_of_them_or_from_a_time(tick_us: int, ticks: list[int]) -> None:
    events = recording(100, 109, 110, 125)
    made = TickedEvents.of(events, tick_us)
    assert made.ticks.tolist() == ticks
    assert all(is_read_only_view(getattr(made, axis), getattr(events, axis)) for axis in "xyp")
    assert TickedEvents.of(events, tick_us, 80).ticks.tolist() == [(t - 80) // tick_us for t in (100, 109, 110, 125)]
    assert len(TickedEvents.of(events[:0], tick_us)) == 0


def test_a_counter_counts_from_the_first_event_of_all_runs() -> None:
    events, counter = recording(100, 109, 110, 125), TickCounter(10)
    assert (len(counter.count(events[:0])), counter.t0_us) == (0, 0)
    runs = [counter.count(events[a:b]).ticks.tolist() for a, b in ((0, 1), (1, 1), (1, 3), (3, 4))]
    assert (runs, counter.t0_us) == ([[0], [], [0, 1], [2]], 100)


def test_a_counter_may_begin_at_time_0() -> None:
    counter = TickCounter(1)
    assert [counter.count(recording(t_us)).ticks.tolist() for t_us in (0, 7)] == [[0], [7]]
