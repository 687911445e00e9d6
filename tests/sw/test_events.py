# SPDX-License-Identifier: Apache-2.0
"""Invalid recordings are refused, with the place, the value and the rule."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evcot.errors import EvcotError, RecordingError
from evcot.events import Events, Recording
from evcot.recordings.files import write_recording


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


def test_no_events_are_a_recording_of_no_duration() -> None:
    recording = Recording(Events.empty(), 1, 1)
    assert len(recording.events) == 0
    assert recording.duration_us == 0


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
    with pytest.raises(RecordingError) as caught:
        Recording(events, 64, 48, "story")
    assert str(caught.value) == f"story: {message}"


@pytest.mark.parametrize(("width", "height"), [(0, 48), (64, 0), (65537, 48), (64, -1)])
def test_a_sensor_has_from_1_to_65536_pixels_a_side(width: int, height: int) -> None:
    with pytest.raises(RecordingError, match=f"sensor {width}x{height}: each side must be from 1 to 65536 pixels"):
        Recording(Events.empty(), width, height)


def test_the_error_can_be_caught_by_kind() -> None:
    assert issubclass(RecordingError, EvcotError)
    assert issubclass(RecordingError, ValueError)


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
