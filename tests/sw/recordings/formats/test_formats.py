# SPDX-License-Identifier: Apache-2.0
"""Common behaviour of all formats: refusal by rule, detection of the sensor; and real recordings are read unchanged."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evcot.recordings.files import read_recording

from .reading import refusal


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"#!AER-DAT2.0\r\n# more\r\n", "holds no events"),
        (b"#!AER-DAT4.0\r\n\x10\x00", "ends within its header, at byte 16"),
        (b"Event Stream\x02\x00\x00", "ends within its header, at byte 15: must be at least 20 bytes"),
        (b"Event Stream\x03\x00\x00\x01\x40\x00\x30\x00", "ES version 3: must be 2"),
        (b"Event Stream\x02\x00\x00\x00\x40\x00\x30\x00", "ES events of kind 0: must be 1 (DVS) or 2 (ATIS)"),
        (b"Event Stream\x02\x00\x00\x01\x40\x00\x30\x00", "holds no events"),
        (b"Event Stream\x02\x00\x00\x01\x40\x00\x30\x00\x01\x02", "ends within an event, at byte 22; is it cut off?"),
        (b"% evt 2.0\n% geome", "ends within its header, at byte 17: a header line must end in a newline"),
        (b"% evt 2.0\n", "holds no events"),
        (b"% evt 2.0\n\x00\x00\x00\x80\x00", "ends within a word of 4 bytes, at byte 15; is it cut off?"),
        (b"% evt 3.0\n\x00\x80\x00", "ends within a word of 2 bytes, at byte 13; is it cut off?"),
        (b"% evt 2.1\n\x00\x80\x00\x00", "ends within a word of 8 bytes, at byte 14; is it cut off?"),
        (b"% evt 4.0\n\x00\x80\x00\x00", "EVT version 4: must be 2.0, 2.1 or 3.0"),
        (b"% Version 2\n\x0c\x08", "holds no events"),
        (b"% Version 2\n\x0c\x08\x01", "ends within a word of 8 bytes, at byte 15; is it cut off?"),
        (b"% Version 3\n\x0c\x08", "DAT version 3: must be 1 or 2"),
        (b"% Date now\n", "the header names no EVT version, and no DAT event type and size follow it; is it cut off?"),
    ],
)
def test_what_is_no_whole_recording_is_refused_by_rule(tmp_path: Path, content: bytes, message: str) -> None:
    assert refusal(tmp_path / "file", content) == message


@pytest.mark.parametrize(
    ("header", "words", "message"),
    [
        (b"% evt 2.0\n", np.array([0x80000200, 0, 0x80000001, 0], "<u4"), "event 1: t = 64 us follows t = 32768 us"),
        (b"% evt 3.0\n", np.array([0x8003, 0, 0x6064, 0x2001, 0x8000, 0x6032, 0x2001], "<u2"),
         "event 1: t = 50 us follows t = 12388 us"),
        (b"% Version 1\n\x00\x08", np.array([100, 20200, 150], "<u8"), "event 2: t = 150 us follows t = 20200 us"),
        (b"% Version 2\n\x0c\x08", np.array([100, 20200, 150], "<u8"), "event 2: t = 150 us follows t = 20200 us"),
    ],
    ids=["evt2", "evt3", "dat1", "dat2"],
)  # fmt: skip
def test_time_that_runs_back_is_refused_with_index_and_values(
    tmp_path: Path, header: bytes, words: np.ndarray, message: str
) -> None:
    assert refusal(tmp_path / "events", header + words.tobytes()) == f"{message}: time must not run back"


@pytest.mark.parametrize(
    ("header", "x", "y", "sensor"),
    [
        ("% geometry 346x260\n", 200, 100, (346, 260)),
        ("% format EVT3;height=260;width=346\n", 200, 100, (346, 260)),
        ("% Width 346\n% Height 260\n", 200, 100, (346, 260)),
        ("", 303, 239, (304, 240)),
        ("", 304, 0, (320, 320)),
        ("", 0, 321, (480, 360)),
        ("", 639, 0, (640, 480)),
        ("", 640, 0, (1280, 720)),
    ],
)
def test_a_raw_header_gives_the_sensor_else_the_smallest_known_one_that_fits(
    tmp_path: Path, header: str, x: int, y: int, sensor: tuple[int, int]
) -> None:
    path = tmp_path / "events.raw"
    path.write_bytes(f"% evt 3.0\n{header}% end\n".encode() + np.array([0x8000, y, 0x2000 + x], "<u2").tobytes())
    recording = read_recording(path)
    assert (recording.width, recording.height) == sensor
    assert (recording.events.x.tolist(), recording.events.y.tolist()) == ([x], [y])


def test_an_event_outside_the_stated_or_the_largest_known_sensor_is_refused(tmp_path: Path) -> None:
    path, words = tmp_path / "events.raw", np.array([0x8000, 0, 0x2000 + 1280], "<u2").tobytes()
    assert refusal(path, b"% evt 3.0\n" + words) == "event 0: x = 1280: must be below the sensor's 1280"
    stated = b"% evt 3.0\n% geometry 640x480\n" + words
    assert refusal(path, stated) == "event 0: x = 1280: must be below the sensor's 640"


def test_events_before_a_raw_file_s_first_time_mark_are_counted_in_a_warning(tmp_path: Path) -> None:
    path = tmp_path / "events.raw"
    path.write_bytes(b"% evt 3.0\n" + np.array([1, 0x2001, 0x2002, 0x8000, 0x2003], "<u2").tobytes())
    with pytest.warns(UserWarning, match="2 events left out: they precede any time mark or address"):
        recording = read_recording(path)
    assert recording.events.x.tolist() == [3]
