# SPDX-License-Identifier: Apache-2.0
"""Recordings are read completely and unchanged, or refused; and written so that they can be read back."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from itertools import pairwise, product
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import ConfigError, OutputError, RecordingError, RecordingWarning
from evcot.events import Events, Recording
from evcot.recordings.files import Damage, format_for, open_recording, read_recording, write_events, write_recording
from evcot.recordings.formats import WRITABLE, formats, text
from support.refusals import refused

from .formats.reading import assert_same, refusal

WIDTH, HEIGHT = 64, 48
EPOCH_US = 1_718_925_184_590_631


def make_events(t_us: np.ndarray) -> Events:  # type: ignore[type-arg]
    random = np.random.default_rng(3)
    n = len(t_us)
    x, y = random.integers(0, WIDTH, n), random.integers(0, HEIGHT, n)
    return Events(t_us.astype(np.int64), x.astype(np.uint16), y.astype(np.uint16), random.integers(0, 2, n).astype(np.uint8))


def steps(*parts: tuple[int, int], start_us: int = EPOCH_US) -> Events:
    """Runs of events: (how many, microseconds before each)."""
    between = np.concatenate([np.full(count, step) for count, step in parts])
    between[0] = 0
    return make_events(start_us + np.cumsum(between))


STORIES = {
    "one event": steps((1, 0)),
    "from zero": steps((1000, 3), start_us=0),
    "epoch": steps((5000, 3)),
    "one instant": steps((700, 0)),
    "equal times": make_events(EPOCH_US + np.sort(np.random.default_rng(1).integers(0, 99, 3000))),
    "gaps of a minute": steps((50, 1), (1, 60_000_000), (50, 7), (2, 60_000_000), (50, 0)),
}


def csv(path: Path, *rows: str) -> Path:
    path.write_text("".join(f"{row}\n" for row in rows))
    return path


@pytest.mark.parametrize("name", WRITABLE)
class TestEveryWritableFormat:
    @pytest.mark.parametrize("story", STORIES)
    def test_gives_back_what_was_written(self, tmp_path: Path, name: str, story: str) -> None:
        path = tmp_path / f"events{WRITABLE[name].suffix}"
        write_recording(Recording(STORIES[story], WIDTH, HEIGHT), path, name)
        recording = read_recording(str(path))
        assert_same(recording.events, STORIES[story])
        assert (recording.width, recording.height, recording.name) == (WIDTH, HEIGHT, "events")
        assert [each.name for each in tmp_path.iterdir()] == [path.name]

    def test_is_known_by_its_content_and_not_its_name_and_takes_blocks_of_any_size(self, tmp_path: Path, name: str) -> None:
        path, events = tmp_path / "recording.bin", STORIES["epoch"]
        blocks = (events[begin:end] for begin, end in pairwise([0, 1, 1, 2, 900, 5000]))
        assert write_events(path, (WIDTH, HEIGHT), blocks, name) == 5000
        with open_recording(path) as file:
            assert file.format in [kind.title for kind in formats()]
            assert not file.assumes_sensor
            assert all(isinstance(value, str) for value in file.details.values())
            assert file.t0_us == EPOCH_US
            assert_same(file.read().events, events)

    def test_windows_are_slices_of_the_whole(self, tmp_path: Path, name: str) -> None:
        path = tmp_path / "events"
        events = make_events(EPOCH_US + np.cumsum(np.random.default_rng(2).choice([0, 1, 30_000], 20_000, p=[0.5, 0.49, 0.01])))
        write_recording(Recording(events, WIDTH, HEIGHT), path, name)
        after_us = events.t_us - EPOCH_US
        last_us, some = int(after_us[-1]), after_us[[1, 5_000, 10_000, 19_999]].tolist()
        edges = [0, 1, *some, *(each + 1 for each in some), last_us // 3, last_us + 1, last_us * 2]
        with open_recording(path) as file:
            for from_us, to_us in product(edges, (*edges, None)):
                begin, end = np.searchsorted(after_us, (from_us, last_us * 3 if to_us is None else to_us))
                assert_same(Events.joined(file.blocks(from_us, to_us)), events[int(begin) : int(max(begin, end))])

    def test_a_given_sensor_wins_and_an_event_outside_it_is_named(self, tmp_path: Path, name: str) -> None:
        path = tmp_path / "events"
        events = STORIES["epoch"]
        write_recording(Recording(events, WIDTH, HEIGHT), path, name)
        assert read_recording(path, sensor=(200, 100)).width == 200
        first = int(np.flatnonzero(events.x >= 20)[0])
        assert refusal(path, sensor=(20, HEIGHT)) == f"event {first}: x = {events.x[first]}: must be below the sensor's 20"

    def test_what_breaks_the_rules_is_not_written(self, tmp_path: Path, name: str) -> None:
        path = tmp_path / "events"
        path.write_bytes(b"older")
        good, late = STORIES["epoch"][:10], steps((5, 1), start_us=EPOCH_US + 1000)
        wrong = Events(good.t_us + 1000, good.x + np.uint16(WIDTH), good.y, good.p)
        for blocks, message in (
            ([late, good], f"event 5: t = {EPOCH_US} us follows t = {EPOCH_US + 1004} us: time must not run back"),
            ([good, wrong], f"event 10: x = {wrong.x[0]}: must be below the sensor's {WIDTH}"),
        ):
            with refused(RecordingError, f"{path}: {message}"):
                write_events(path, (WIDTH, HEIGHT), blocks, name, force=True)
        with pytest.raises(RecordingError, match="sensor 0x48: each side must be from 1 to 65536 pixels"):
            write_events(path, (0, HEIGHT), [good], name, force=True)
        assert [each.read_bytes() for each in tmp_path.iterdir()] == [b"older"]

    def test_an_interrupt_or_a_missing_folder_leaves_nothing(self, tmp_path: Path, name: str) -> None:
        def interrupted() -> Iterator[Events]:
            yield STORIES["epoch"]
            raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            write_events(tmp_path / "events", (WIDTH, HEIGHT), interrupted(), name)
        with pytest.raises(OutputError, match="cannot be written: No such file or directory"):
            write_events(tmp_path / "absent" / "events", (WIDTH, HEIGHT), [STORIES["epoch"]], name)
        assert list(tmp_path.iterdir()) == []


def test_the_suffix_or_a_name_tells_the_format() -> None:
    for suffix in {kind.suffix for kind in WRITABLE.values()}:
        assert format_for(f"some.where/events{suffix.upper()}").suffix == suffix
    for name, kind in WRITABLE.items():
        assert format_for("events.jpeg", name) is kind
    with pytest.raises(
        ConfigError, match=r"^events\.jpeg: suffix '\.jpeg': must be one of \.npz, .*, or the format must be named$"
    ):
        format_for("events.jpeg")
    with pytest.raises(ConfigError, match=r"^format 'jpeg': must be one of npz, csv"):
        format_for("events.csv", "jpeg")


def test_the_smallest_sensor_that_fits_is_assumed_where_none_is_stated(tmp_path: Path) -> None:
    path = csv(tmp_path / "a.csv", "1,7,2,1", "2,3,9,0")
    with open_recording(path) as file:
        assert file.assumes_sensor
        assert file.sensor == (8, 10)
    with open_recording(path, (100, 50)) as file:
        assert not file.assumes_sensor
        assert file.sensor == (100, 50)
    assert refusal(path, sensor=(0, 50)) == "sensor 0x50: each side must be from 1 to 65536 pixels"


def test_an_open_file_can_be_read_again_and_twice_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(text, "_CHUNK_BYTES", 1000)
    write_events(tmp_path / "a.csv", (WIDTH, HEIGHT), [STORIES["epoch"]])
    with open_recording(tmp_path / "a.csv") as file:
        pairs = list(zip(file.blocks(), file.blocks(), strict=True))
    assert len(pairs) > 10
    for parts in zip(*pairs, strict=True):
        assert_same(Events.joined(parts), STORIES["epoch"])


def test_no_event_in_the_window(tmp_path: Path) -> None:
    path = csv(tmp_path / "a.csv", "1000,0,0,1", "2000,0,0,1")
    with pytest.raises(RecordingError, match=r"a\.csv: holds no events from 0.5 s$"):
        read_recording(path, from_us=500_000)
    with pytest.raises(RecordingError, match=r"a\.csv: holds no events from 0.0001 s to 0.0002 s$"):
        read_recording(path, from_us=100, to_us=200)
    with open_recording(path) as file:
        assert list(file.blocks(500_000)) == []


def test_damage_is_refused_or_left_out_and_counted(tmp_path: Path) -> None:
    path = csv(
        tmp_path / "a.csv",
        *("90010,1,1,1", "90011,9,1,1", "90012,1,1,2", "80009,1,1,0", "90012,1,8,0", "90020,2,1,0", "19,2,1,0", "90030,1,1,1"),
    )
    assert refusal(path, sensor=(9, 8)) == "event 1: x = 9: must be below the sensor's 9"
    with pytest.warns(RecordingWarning) as caught, open_recording(path, (9, 8), damage="skip") as file:
        events = file.read().events
    assert events.t_us.tolist() == [90_010, 90_020, 90_030]
    assert file.left_out == {"outside the sensor, or without a polarity": 3, "time runs back": 2}
    assert [str(each.message) for each in caught] == [
        f"{path}: 3 events left out: outside the sensor, or without a polarity",
        f"{path}: 2 events left out: time runs back",
    ]


def test_time_is_held_against_the_block_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(text, "_CHUNK_BYTES", 20)
    path = csv(tmp_path / "a.csv", "10,1,1,1", "10012,1,1,1", "11,1,1,1", "10013,1,1,1")
    assert refusal(path) == "event 2: t = 11 us follows t = 10012 us: time must not run back"
    with pytest.warns(RecordingWarning, match="1 events left out: time runs back"):
        assert read_recording(path, damage="skip").events.t_us.tolist() == [10, 10_012, 10_013]


@pytest.mark.parametrize("piece_bytes", [400, 1 << 18])
def test_time_that_restarts_goes_on_where_damage_is_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, piece_bytes: int
) -> None:
    monkeypatch.setattr(text, "_CHUNK_BYTES", piece_bytes)
    parts = [[*range(500, 50_000, 500)], [*range(10, 30_000, 300)], [*range(0, 90_000, 900)]]
    path = csv(tmp_path / "a.csv", *(f"{t_us},1,1,1" for part in parts for t_us in part))
    assert refusal(path) == "event 99: t = 10 us follows t = 49500 us: time must not run back"
    with open_recording(path, damage="skip") as file:
        with pytest.warns(RecordingWarning):
            t_us = file.read().events.t_us
        assert file.remarks == ["time restarts in 2 places: there, it goes on from the latest time before"]
        left_out = file.left_out["time runs back"]
        with pytest.warns(RecordingWarning):
            window = file.read(60_000, 70_000).events.t_us
    gone_on = [*parts[0], *(49_500 - 10 + each for each in parts[1]), *(49_500 - 10 + 29_710 + each for each in parts[2])]
    if left_out:  # a restart within the last events of a block is seen in the next
        assert left_out < 2 * 16
        assert len(t_us) == len(gone_on) - left_out
    else:
        assert t_us.tolist() == gone_on
    assert window.tolist() == [each for each in t_us.tolist() if 60_500 <= each < 70_500]


def test_events_that_come_late_are_no_restart(tmp_path: Path) -> None:
    rows = [*range(0, 100_000, 1000), *range(50_000, 70_000, 1000), *range(100_000, 110_000, 1000)]
    path = csv(tmp_path / "a.csv", *(f"{t_us},1,1,1" for t_us in rows))
    with pytest.warns(RecordingWarning, match="20 events left out: time runs back"):
        assert read_recording(path, damage="skip").events.t_us.tolist() == [*range(0, 110_000, 1000)]


BACK = "{} events run back in time, by at most {} us: each has the time of the latest before it"


@pytest.mark.parametrize("piece_bytes", [20, 1 << 18])
@pytest.mark.parametrize("damage", ["refuse", "skip"])
def test_a_time_that_runs_back_a_little_is_held_and_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, damage: Damage, piece_bytes: int
) -> None:
    monkeypatch.setattr(text, "_CHUNK_BYTES", piece_bytes)
    path = csv(tmp_path / "a.csv", "10,1,1,1", "20010,2,1,1", "10010,3,1,0", "20009,4,1,1", "20011,5,1,0", "20010,6,1,0")
    with pytest.warns(RecordingWarning) as caught, open_recording(path, damage=damage) as file:
        events = file.read().events
    assert (events.t_us.tolist(), events.x.tolist()) == ([10, 20_010, 20_010, 20_010, 20_011, 20_011], [1, 2, 3, 4, 5, 6])
    assert (file.remarks, file.left_out) == ([BACK.format(3, 10_000)], {})
    assert [str(each.message) for each in caught] == [f"{path}: {BACK.format(3, 10_000)}"]


def test_what_runs_back_a_little_and_what_runs_back_far_are_told_apart(tmp_path: Path) -> None:
    path = csv(tmp_path / "a.csv", "10,1,1,1", "20010,2,1,1", "20000,3,1,0", "10009,4,1,1", "20005,9,1,0", "20006,5,1,1")
    assert refusal(path, sensor=(9, 8)) == "event 3: t = 10009 us follows t = 20010 us: time must not run back"
    with pytest.warns(RecordingWarning) as caught, open_recording(path, (9, 8), damage="skip") as file:
        events = file.read().events
    assert (events.t_us.tolist(), events.x.tolist()) == ([10, 20_010, 20_010, 20_010], [1, 2, 3, 5])
    assert file.left_out == {"outside the sensor, or without a polarity": 1, "time runs back": 1}
    assert f"{path}: {BACK.format(2, 10)}" in [str(each.message) for each in caught]


def test_what_follows_a_place_that_cannot_be_read_is_left_out_if_asked_to(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = csv(tmp_path / "a.csv", "10,1,1,1", "11,1,2,1", "what?", "12,1,1,1")
    why = "line 3: 'what?': must have 4 cells, as the first event; it has 1"
    assert refusal(path) == why
    with pytest.warns(RecordingWarning) as caught:  # once, though finding the sensor takes a pass of its own
        assert read_recording(path, damage="skip").events.t_us.tolist() == [10, 11]
    assert [str(each.message) for each in caught] == [f"{path}: everything after 2 events left out: {why}"]
    assert refusal(csv(path, "10,1,1,1 x"), damage="skip").startswith("line 1: p = '1 x'")
    monkeypatch.setattr(text, "_CHUNK_BYTES", 20)
    csv(path, "10,1,1,1", "11,1,2,1", "12,1,2,1", "13,1,2,1", "14,1,1,1", "what?")
    assert read_recording(path, (5, 5), to_us=2).events.t_us.tolist() == [10, 11], (
        "a window before the damage, without a warning"
    )


def test_what_is_no_recording_is_refused(tmp_path: Path) -> None:
    formats_ = ", ".join(kind.title for kind in formats())
    assert refusal(tmp_path / "file", b"") == "is empty"
    assert refusal(tmp_path / "file", b"\x00\x01\x02\x03") == f"has an unknown format: must be one of {formats_}"
    assert refusal(tmp_path / "file", b"t,x,y,p\n") == "holds no events"
    assert refusal(tmp_path / "absent.raw") == "cannot be read: No such file or directory"
    assert refusal(tmp_path) == "is a directory, and no ROS 2 bag: has no metadata.yaml"
    os.mkfifo(tmp_path / "pipe")
    for path in (Path("/dev/null"), tmp_path / "pipe"):
        assert refusal(path) == "is a device or a pipe: must be a file"
    path = csv(tmp_path / "events.csv", "1,2,3,1")
    with open_recording(path) as file:
        path.chmod(0)
        if os.geteuid():  # root may read any file
            assert refusal(path) == "cannot be read: Permission denied"
        path.unlink()
        with pytest.raises(RecordingError, match=r"events\.csv: cannot be read: No such file or directory"):
            file.read()


PEAK = """
import resource, sys
from evcot.recordings.files import open_recording, write_events
with open_recording(sys.argv[1]) as file:
    count = write_events(sys.argv[2], file.sensor, file.blocks())
print(count, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


@pytest.mark.parametrize(
    ("source", "target", "counts"), [("npz", "npz", (1_000_000, 10_000_000)), ("csv", "csv", (250_000, 2_500_000))]
)
def test_memory_does_not_grow_with_the_recording(tmp_path: Path, source: str, target: str, counts: tuple[int, int]) -> None:
    peaks_kb = []
    for count in counts:
        path = tmp_path / f"{count}.{source}"
        block = make_events(np.arange(250_000))
        later = (Events(block.t_us + at, block.x, block.y, block.p) for at in range(0, count, 250_000))
        assert write_events(path, (WIDTH, HEIGHT), later) == count
        done = subprocess.run(
            [sys.executable, "-c", PEAK, path, tmp_path / f"out{count}.{target}"], capture_output=True, check=True
        )
        found, peak_kb = map(int, done.stdout.split())
        assert found == count
        peaks_kb.append(peak_kb)
    assert peaks_kb[1] - peaks_kb[0] < 10_000


def test_a_reader_is_imported_when_its_format_is_tried(tmp_path: Path) -> None:
    """And what Numba is imported without can be imported afterwards."""
    np.save(tmp_path / "rows.npy", np.array([[1, 2, 3, 1]]))
    program = """
import sys
from evcot.recordings.files import read_recording
read_recording(sys.argv[1])
loaded = {name.rpartition(".")[2] for name in sys.modules if name.startswith("evcot.recordings.formats.")}
print("numpy_files" in loaded, loaded & {"aedat4", "hdf5", "ros", "text"}, "scipy" in sys.modules)
import scipy.linalg
"""
    command = [sys.executable, "-c", program, str(tmp_path / "rows.npy")]
    subprocess.run(command, check=True)  # which compiles the kernels
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "True set() False\n"
