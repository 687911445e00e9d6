# SPDX-License-Identifier: Apache-2.0
"""Events, and events in ticks: columns as kernels and drives need them, parts, and invalid ones refused by the rule."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import EvcotError, RecordingError
from evcot.events import Events, Recording
from evcot.recordings.files import write_recording
from evcot.ticks import TickCounter, TickedEvents
from support.refusals import refused
from support.tokens import ticked


def make_events(t_us: list[int], x: list[int], y: list[int], p: list[int]) -> Events:
    return Events(np.array(t_us, np.int64), np.array(x, np.uint16), np.array(y, np.uint16), np.array(p, np.uint8))


def test_a_recording_keeps_what_it_is_given() -> None:
    events = make_events([10, 10, 30], [0, 63, 5], [47, 0, 6], [0, 1, 1])
    recording = Recording(events, 64, 48, "story")
    assert recording.events is events
    assert (recording.width, recording.height, recording.name) == (64, 48, "story")
    assert recording.duration_us == 20


def test_times_in_a_camera_s_own_epoch_are_exact() -> None:
    start = 1_718_925_184_590_631
    recording = Recording(make_events([start, start + 1], [0, 1], [0, 1], [0, 1]), 2, 2)
    assert recording.events.t_us.tolist() == [start, start + 1]
    assert recording.duration_us == 1
    assert Recording(Events.empty(), 1, 1).duration_us == 0


def test_a_window_of_events_is_cut_from_every_field() -> None:
    window = make_events([1, 2, 3], [4, 5, 6], [7, 8, 9], [0, 1, 0])[1:]
    assert len(window) == 2
    assert [field.tolist() for field in (window.t_us, window.x, window.y, window.p)] == [[2, 3], [5, 6], [8, 9], [1, 0]]


def test_read_only_columns_are_the_same_memory_and_cannot_be_written() -> None:
    events = make_events([1, 2, 3], [4, 5, 6], [7, 8, 9], [0, 1, 0])
    seen = events.read_only()
    for name in ("t_us", "x", "y", "p"):
        column, view = getattr(events, name), getattr(seen, name)
        assert np.shares_memory(column, view)
        assert column.flags.writeable
        with pytest.raises(ValueError, match="read-only"):
            view[0] = 0


@pytest.mark.parametrize(
    ("events", "message"),
    [
        (make_events([5, 9, 8], [0] * 3, [0] * 3, [0] * 3), "event 2: t = 8 us follows t = 9 us: time must not run back"),
        (make_events([1, 2], [0, 64], [0, 0], [0, 0]), "event 1: x = 64: must be below the sensor's 64"),
        (make_events([1, 2], [0, 63], [48, 0], [0, 0]), "event 0: y = 48: must be below the sensor's 48"),
        (make_events([1, 2], [0, 63], [47, 0], [1, 2]), "event 1: p = 2: must be 0 or 1"),
        (make_events([1, 2], [0], [0, 0], [0, 0]), "t, x, y, p hold 2, 1, 2, 2 values: all must be the same"),
    ],
)
def test_the_first_broken_rule_is_named(events: Events, message: str) -> None:
    with refused(RecordingError, f"story: {message}"):
        Recording(events, 64, 48, "story")


@pytest.mark.parametrize(("width", "height"), [(0, 48), (64, 0), (65537, 48), (64, -1)])
def test_a_sensor_has_from_1_to_65536_pixels_a_side(width: int, height: int) -> None:
    assert issubclass(RecordingError, EvcotError)
    with pytest.raises(ValueError, match=f"sensor {width}x{height}: each side must be from 1 to 65536 pixels"):
        Recording(Events.empty(), width, height)


def test_numpy_makes_a_structured_array_of_events() -> None:
    events = Events(np.array([5, 9]), np.array([1, 2], np.uint16), np.array([3, 4], np.uint16), np.array([1, 0], np.uint8))
    array = np.asarray(events)
    assert array["t"].tolist() == [5, 9]
    assert np.array_equal(array, events.to_array())
    with pytest.raises(ValueError, match=r"copy = False: must be True or None"):
        np.asarray(events, copy=False)


def test_a_short_text_stands_for_many_events() -> None:
    events = Events(np.arange(5_000), *np.zeros((2, 5_000), np.uint16), np.zeros(5_000, np.uint8))
    assert repr(events) == "<Events: 5,000, from 0 to 4,999 us>"
    assert repr(Events.empty()) == "<Events: none>"
    assert repr(Recording(events, 346, 260, "drive")) == "<Recording drive: 5,000 events in 0.004999 s, 346x260 pixels>"


def test_what_is_no_recording_is_refused_in_one_line(tmp_path: Path) -> None:
    recording = Recording(Events.empty(), 4, 3)
    for arguments in ((tmp_path / "a.npz", recording), (recording.events, tmp_path / "a.npz"), (recording, 5)):
        with pytest.raises(RecordingError, match=r"must be a Recording, then the path of the file to write$"):
            write_recording(*arguments)  # type: ignore[arg-type]
    with pytest.raises(RecordingError, match="recording: events are of type list: must be Events"):
        Recording([], 4, 3)  # type: ignore[arg-type]


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
    with refused(RecordingError, message):
        TickedEvents(**columns)  # type: ignore[arg-type]


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
