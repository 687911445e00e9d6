# SPDX-License-Identifier: Apache-2.0
"""Recordings come in whole and as they are, or not at all."""

from __future__ import annotations

import os
from pathlib import Path

import faery
import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import OutputError, RecordingError
from evcot.events import Events, Recording
from evcot.files import read_recording, write_recording

SHARED = Path(__file__).parents[3] / "shared" / "data"
WIDTH, HEIGHT = 64, 48
EPOCH_US = 1_718_925_184_590_631

# format -> (suffix, options of faery's writer)
WRITERS: dict[str, tuple[str, dict[str, object]]] = {
    "aedat4-lz4": (".aedat4", {}),
    "aedat4-zstd": (".aedat4", {"compression": ("zstd", 3)}),
    "aedat4-plain": (".aedat4", {"compression": None}),
    "evt2": (".raw", {"version": "evt2"}),
    "evt3": (".raw", {"version": "evt3"}),
    "dat1": (".dat", {"version": "dat1"}),
    "dat2": (".dat", {"version": "dat2"}),
    "es": (".es", {}),
    "csv": (".csv", {}),
}
FORMATS = [*WRITERS, "npz"]


def make_events(count: int, start_us: int = EPOCH_US) -> Events:
    random = np.random.default_rng(3)
    return Events(
        t_us=start_us + np.sort(random.integers(0, 3 * count, count)),
        x=random.integers(0, WIDTH, count).astype(np.uint16),
        y=random.integers(0, HEIGHT, count).astype(np.uint16),
        p=random.integers(0, 2, count).astype(np.uint8),
    )


def write(directory: Path, name: str, events: Events) -> Path:
    """A file of a 64x48 sensor in one of `FORMATS`."""
    if name == "npz":
        path = directory / "events.npz"
        write_recording(Recording(events, WIDTH, HEIGHT), path)
        return path
    suffix, options = WRITERS[name]
    path = directory / f"events{suffix}"
    packet = np.zeros(len(events), faery.EVENTS_DTYPE)
    packet["t"], packet["x"], packet["y"], packet["on"] = events.t_us, events.x, events.y, events.p
    faery.events_stream_from_array(packet, (WIDTH, HEIGHT)).to_file(path, **options)
    return path


def columns(events: Events) -> list[NDArray[np.generic]]:
    return [events.t_us, events.x, events.y, events.p]


def assert_same(got: Events, wanted: Events) -> None:
    for values, expected in zip(columns(got), columns(wanted), strict=True):
        assert values.dtype == expected.dtype
        np.testing.assert_array_equal(values, expected)


def refusal(path: Path | str, sensor: tuple[int, int] | None = None) -> str:
    """The one line with which a file is refused, without the file's name that it starts with."""
    with pytest.raises(RecordingError) as caught:
        read_recording(path, sensor)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    return message.removeprefix(f"{path}: ")


@pytest.mark.parametrize("name", FORMATS)
def test_what_was_written_is_read(tmp_path: Path, name: str) -> None:
    events = make_events(5000)
    recording = read_recording(str(write(tmp_path, name, events)))
    start_us = int(events.t_us[0]) if name == "es" else 0  # an ES file keeps no absolute time
    assert_same(recording.events, Events(events.t_us - start_us, events.x, events.y, events.p))
    assert (recording.width, recording.height, recording.name) == (WIDTH, HEIGHT, "events")


@pytest.mark.parametrize("name", FORMATS)
def test_the_content_tells_the_format_and_not_the_name(tmp_path: Path, name: str) -> None:
    path = write(tmp_path, name, make_events(10))
    renamed = path.rename(tmp_path / "recording.bin")
    assert len(read_recording(renamed).events) == 10


@pytest.mark.parametrize("name", FORMATS)
def test_a_given_sensor_wins_and_an_event_outside_it_is_named(tmp_path: Path, name: str) -> None:
    path = write(tmp_path, name, make_events(100))
    assert read_recording(path, sensor=(200, 100)).width == 200
    x = make_events(100).x
    first = int(np.flatnonzero(x >= 20)[0])
    assert refusal(path, sensor=(20, HEIGHT)) == f"event {first}: x = {x[first]}: must be below the sensor's 20"


@pytest.mark.parametrize("name", FORMATS)
def test_a_file_cut_anywhere_is_refused_or_read_as_a_true_prefix(tmp_path: Path, name: str) -> None:
    whole = write(tmp_path, name, make_events(6))
    expected = read_recording(whole).events
    content = whole.read_bytes()
    cut = tmp_path / "cut"
    refused = 0
    for length in range(len(content)):
        cut.write_bytes(content[:length])
        try:
            recording = read_recording(cut)
        except RecordingError as error:
            assert str(error).startswith(f"{cut}: ")  # noqa: PT017
            assert "\n" not in str(error)  # noqa: PT017
            refused += 1
        else:
            assert_same(recording.events, expected[: len(recording.events)])
            assert (recording.width, recording.height) == (WIDTH, HEIGHT)
    assert refused > len(content) // 3


@pytest.mark.filterwarnings("ignore:.*events left out")
@pytest.mark.parametrize("name", FORMATS)
def test_damaged_bytes_never_do_more_than_raise(tmp_path: Path, name: str) -> None:
    content = write(tmp_path, name, make_events(200)).read_bytes()
    random = np.random.default_rng(5)
    damaged = tmp_path / "damaged"
    outcomes = {True: 0, False: 0}
    for _ in range(60):
        changed = np.frombuffer(content, np.uint8).copy()
        where = random.integers(0, min(len(content), 700), 2)
        changed[where] = random.integers(0, 256, 2)
        damaged.write_bytes(changed.tobytes())
        try:
            read_recording(damaged)
            outcomes[True] += 1
        except RecordingError as error:
            assert "\n" not in str(error)  # noqa: PT017
            outcomes[False] += 1
    assert outcomes[False] > 0


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"100,1,1,0\n200,1,1,0\n150,1,1,0\n", "event 2: t = 150 us follows t = 200 us"),
        (b"% evt 2.0\n" + np.array([0x80000002, 0, 0x80000001, 0], "<u4").tobytes(), "event 1: t = 64 us follows t = 128 us"),
        (
            b"% evt 3.0\n" + np.array([0x8000, 0, 0x6064, 0x2001, 0x6032, 0x2001], "<u2").tobytes(),
            "event 1: t = 50 us follows t = 100 us",
        ),
        (b"% Version 1\n\x00\x08" + np.array([100, 200, 150], "<u8").tobytes(), "event 2: t = 150 us follows t = 200 us"),
        (b"% Version 2\n\x0c\x08" + np.array([100, 200, 150], "<u8").tobytes(), "event 2: t = 150 us follows t = 200 us"),
    ],
    ids=["csv", "evt2", "evt3", "dat1", "dat2"],
)
def test_time_that_runs_back_is_refused_with_index_and_values(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "events"
    path.write_bytes(content)
    assert refusal(path) == f"{message}: time must not run back"


def test_time_that_runs_back_in_a_container_is_refused_too(tmp_path: Path) -> None:
    packed = tmp_path / "events.npz"
    np.savez(packed, t_us=[100, 200, 150], x=[0] * 3, y=[0] * 3, p=[0] * 3, width=2, height=2)
    assert refusal(packed) == "event 2: t = 150 us follows t = 200 us: time must not run back"


def test_dat_time_goes_on_where_its_32_bits_wrap_around(tmp_path: Path) -> None:
    path = tmp_path / "wrap.dat"
    times = np.array([(1 << 32) - 2, (1 << 32) - 1, 3, 3 << 30, 1], "<u8")
    path.write_bytes(b"% Version 2\n% T0 7\n\x00\x08" + times.tobytes())
    turns = np.array([0, 0, 1, 1, 2])
    np.testing.assert_array_equal(read_recording(path).events.t_us, 7 + times.astype(np.int64) + (turns << 32))


@pytest.mark.parametrize(
    ("header", "sensor"),
    [
        ("% geometry 346x260\n", (346, 260)),
        ("% format EVT3;height=260;width=346\n", (346, 260)),
        ("% Width 346\n% Height 260\n", (346, 260)),
        ("", (304, 240)),
    ],
)
def test_a_raw_header_gives_the_sensor_else_the_smallest_known_one_that_fits(
    tmp_path: Path, header: str, sensor: tuple[int, int]
) -> None:
    path = tmp_path / "events.raw"
    path.write_bytes(f"% evt 3.0\n{header}% end\n".encode() + np.array([0x8000, 100, 0x2000 + 200], "<u2").tobytes())
    recording = read_recording(path)
    assert (recording.width, recording.height) == sensor
    assert (recording.events.x.tolist(), recording.events.y.tolist()) == ([200], [100])


@pytest.mark.parametrize(
    ("x", "y", "sensor"),
    [
        (303, 239, (304, 240)),
        (304, 0, (320, 320)),
        (0, 321, (480, 360)),
        (639, 0, (640, 480)),
        (640, 0, (1280, 720)),
    ],
)
def test_every_known_sensor_is_tried_in_order(tmp_path: Path, x: int, y: int, sensor: tuple[int, int]) -> None:
    path = tmp_path / "events.raw"
    path.write_bytes(b"% evt 3.0\n" + np.array([0x8000, y, 0x2000 + x], "<u2").tobytes())
    recording = read_recording(path)
    assert (recording.width, recording.height) == sensor


def test_an_event_outside_the_stated_or_the_largest_known_sensor_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "events.raw"
    words = np.array([0x8000, 0, 0x2000 + 1280], "<u2").tobytes()
    path.write_bytes(b"% evt 3.0\n" + words)
    assert refusal(path) == "event 0: x = 1280: must be below the sensor's 1280"
    path.write_bytes(b"% evt 3.0\n% geometry 640x480\n" + words)
    assert refusal(path) == "event 0: x = 1280: must be below the sensor's 640"


def test_events_before_a_raw_file_s_first_time_mark_are_counted_in_a_warning(tmp_path: Path) -> None:
    path = tmp_path / "events.raw"
    path.write_bytes(b"% evt 3.0\n" + np.array([1, 0x2001, 0x2002, 0x8000, 0x2003], "<u2").tobytes())
    with pytest.warns(UserWarning, match="2 events left out: they precede any time mark or address"):
        recording = read_recording(path)
    assert recording.events.x.tolist() == [3]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty"),
        (b"\x00\x01\x02\x03", "is of no known format: must be AEDAT4, Prophesee RAW or DAT, ES, CSV or npz"),
        (b"#!AER-DAT2.0\r\n# more\r\n", "holds no events"),
        (b"#!AER", "ends after 5 bytes: too early to hold an event"),
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
        (b"% evt 3.0\n% t0 -5\n\x00\x80", "header: t0 = -5: must be a whole number of microseconds below 2^62"),
        (b"% Version 2\n\x0c\x08", "holds no events"),
        (b"% Version 2\n\x0c\x08\x01", "ends within a word of 8 bytes, at byte 15; is it cut off?"),
        (b"% Version 3\n\x0c\x08", "DAT version 3: must be 1 or 2"),
        (b"% Date now\n", "the header names no EVT version, and no DAT event type and size follow it; is it cut off?"),
    ],
)
def test_what_is_no_whole_recording_is_refused_by_rule(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "file"
    path.write_bytes(content)
    assert refusal(path) == message


def test_what_is_no_file_is_refused(tmp_path: Path) -> None:
    assert refusal(tmp_path / "absent.raw") == "cannot be read: No such file or directory"
    assert refusal(tmp_path) == "is a directory or a device: must be a file"
    assert refusal("/dev/null") == "is a directory or a device: must be a file"


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read any file")
def test_an_unreadable_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "events.csv"
    path.write_text("1,2,3,1\n")
    path.chmod(0)
    assert refusal(path) == "cannot be read: Permission denied"


def test_npz_appears_whole_or_not_at_all(tmp_path: Path) -> None:
    recording = Recording(make_events(10), WIDTH, HEIGHT)
    path = tmp_path / "out.npz"
    path.write_bytes(b"older")
    write_recording(recording, path)
    assert_same(read_recording(path).events, recording.events)
    with pytest.raises(OutputError, match="cannot be written: No such file or directory"):
        write_recording(recording, tmp_path / "absent" / "out.npz")
    assert [each.name for each in tmp_path.iterdir()] == ["out.npz"]


def test_a_failed_write_leaves_the_older_file_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "out.npz"
    path.write_bytes(b"older")

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(OutputError, match=r"out\.npz: cannot be written: No space left on device"):
        write_recording(Recording(make_events(10), WIDTH, HEIGHT), path)
    assert [each.read_bytes() for each in tmp_path.iterdir()] == [b"older"]


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"t_us": [1]}, "has no array x, y, p, width, height: must have t_us, x, y, p, width, height"),
        (
            {"t_us": [1.5], "x": [1], "y": [1], "p": [1], "width": 4, "height": 4},
            "t: is 1-D of float64: must be a list of integers",
        ),
        ({"t_us": [1], "x": [-1], "y": [1], "p": [1], "width": 4, "height": 4}, "event 0: x = -1: must be from 0 to 65535"),
        (
            {"t_us": [1], "x": [1], "y": [1, 2], "p": [1], "width": 4, "height": 4},
            "t, x, y, p hold 1, 1, 2, 1 values: all must be the same",
        ),
        (
            {"t_us": [1], "x": [1], "y": [1], "p": [1], "width": 0, "height": 4},
            "sensor 0x4: each side must be from 1 to 65536 pixels",
        ),
    ],
)
def test_an_npz_of_other_arrays_is_refused(tmp_path: Path, arrays: dict[str, object], message: str) -> None:
    path = tmp_path / "file.npz"
    np.savez(path, **arrays)  # type: ignore[arg-type]
    assert refusal(path) == message


def shared(name: str) -> Path:
    path = SHARED / name
    if not path.is_file():
        pytest.skip(f"{name} is not on this machine")
    return path


@pytest.mark.parametrize(
    ("name", "count", "sensor"),
    [
        ("traffic_outbound.aedat4", 788_761, (346, 260)),
        ("hand_dvs128.aedat4", 149_629, (128, 128)),
        ("fixture_evt2_640x480.raw", 521_252, (640, 480)),
        ("fixture_evt3_1280x720.raw", 219_596, (1280, 720)),
    ],
)
def test_real_recordings_are_read_as_they_are(name: str, count: int, sensor: tuple[int, int]) -> None:
    path = shared(name)
    recording = read_recording(path)
    assert len(recording.events) == count
    assert (recording.width, recording.height) == sensor
    reference = faery.events_stream_from_file(path).to_array()
    np.testing.assert_array_equal(recording.events.x, reference["x"])
    np.testing.assert_array_equal(recording.events.y, reference["y"])
    np.testing.assert_array_equal(recording.events.p, reference["on"])
    later_us = reference["t"].astype(np.int64) - recording.events.t_us
    if name.startswith("fixture_evt3"):
        # Where the camera's time mark runs ahead of the events after it, faery moves them up to the mark.
        assert np.count_nonzero(later_us) == 1455
        assert (later_us.min(), later_us.max()) == (0, 11)
    else:
        assert not later_us.any()
