# SPDX-License-Identifier: Apache-2.0
"""CSV as people write it."""

from __future__ import annotations

from pathlib import Path

import pytest

from evcot.errors import RecordingError
from evcot.files import read_recording
from evcot.formats.columns import Sensor


def rows(path: Path, sensor: Sensor | None = None) -> list[tuple[int, ...]]:
    events = read_recording(path, sensor).events
    return list(zip(events.t_us.tolist(), events.x.tolist(), events.y.tolist(), events.p.tolist(), strict=True))


EVENTS = [(10, 1, 2, 1), (12, 3, 4, 0)]


@pytest.mark.parametrize(
    "text",
    [
        "10,1,2,1\n12,3,4,0\n",
        "10,1,2,1\r\n12,3,4,0",
        "t,x,y,p\n10,1,2,1\n12,3,4,0\n",
        "# t x y p\n10 1 2 1\n12 3 4 -1\n",
        "timestamp;x;y;polarity\n10;1;2;1\n12;3;4;0\n",
        "x\ty\tp\tt_us\n1\t2\t1\t10\n3\t4\t0\t12\n",
        "on, note, t, y, x\n1, 9, 10, 2, 1\n0, 9, 12, 4, 3\n",
        "\n10,1,2,1\n\n12,3,4,0\n".lstrip("\n"),
    ],
)
def test_every_usual_layout_gives_the_same_events(tmp_path: Path, text: str) -> None:
    path = tmp_path / "events.csv"
    path.write_bytes(text.encode())
    assert rows(path) == EVENTS


def test_the_sensor_is_given_or_stated_or_the_smallest_that_holds_every_event(tmp_path: Path) -> None:
    path = tmp_path / "events.csv"
    path.write_text("10,1,2,1\n12,3,4,0\n")
    small, given = read_recording(path), read_recording(path, sensor=(128, 64))
    assert (small.width, small.height) == (4, 5)
    assert (given.width, given.height) == (128, 64)
    path.write_text("t,x@346,y@260,on\n10,1,2,1\n")
    stated = read_recording(path)
    assert (stated.width, stated.height) == (346, 260)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("10,1,2,1\n9,1,2,1\n", "event 1: t = 9 us follows t = 10 us: time must not run back"),
        ("10,-1,2,1\n", "event 0: x = -1: must be from 0 to 65535"),
        ("10,1,70000,1\n", "event 0: y = 70000: must be from 0 to 65535"),
        ("10,1,2,1\n11,1,2,3\n", "event 1: p = 3: must be 0 or 1"),
        ("10,1,2,-2\n", "event 0: p = -2: must be from 0 to 255"),
        ("t,x,y,p\n", "holds no events"),
        ("t,x,y\n1,2,3\n", "line 1: 't,x,y': must be an event, or name each of t, x, y, p once; p is not"),
        ("t,x,x,y,p\n1,2,3,4,1\n", "line 1: 't,x,x,y,p': must be an event, or name each of t, x, y, p once; x is not"),
        ("p,x,y,t\n1,2,3,1000", "the last line must end in a newline; is it cut off?"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "events.csv"
    path.write_text(text)
    with pytest.raises(RecordingError) as caught:
        read_recording(path)
    assert str(caught.value) == f"{path}: {message}"


@pytest.mark.parametrize(
    "text", ["0.5,1,2,1\n", "10,1,2\n", "10,1,2,\n", "10,a,2,1\n", "10,1,2,1\n11,1\n", "9" * 30 + ",1,2,1\n"]
)
def test_what_is_no_event_is_refused_in_one_line(tmp_path: Path, text: str) -> None:
    path = tmp_path / "events.csv"
    path.write_text(text)
    with pytest.raises(RecordingError, match=r"; must be whole numbers t \(microseconds\), x, y, p$") as caught:
        read_recording(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)
