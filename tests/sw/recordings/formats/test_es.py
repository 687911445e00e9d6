# SPDX-License-Identifier: Apache-2.0
"""Event Stream 2: byte by byte, against faery, and truncated anywhere."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evcot.errors import RecordingWarning
from evcot.events import Events
from evcot.recordings.files import open_recording, read_recording
from evcot.recordings.formats import es
from evcot.recordings.formats.es import EsFile

from .fuzzing import fuzz
from .reading import assert_same, by_others, read, refusal, written_by_faery

WIDTH, HEIGHT = 64, 48
DVS, ATIS = 1, 2


def header(kind: int = DVS) -> bytes:
    return b"Event Stream" + bytes([2, 0, 0, kind]) + WIDTH.to_bytes(2, "little") + HEIGHT.to_bytes(2, "little")


def place(x: int, y: int) -> bytes:
    """Address bytes of a pixel counted from the top left; the format counts y from the bottom."""
    return x.to_bytes(2, "little") + (HEIGHT - 1 - y).to_bytes(2, "little")


def make_events(count: int, longest_us: int) -> Events:
    random = np.random.default_rng(51)
    steps = random.integers(0, longest_us, count)
    steps[0] = 0  # faery's writer keeps no absolute time
    return Events(
        t_us=np.cumsum(steps),
        x=random.integers(0, WIDTH, count).astype(np.uint16),
        y=random.integers(0, HEIGHT, count).astype(np.uint16),
        p=random.integers(0, 2, count).astype(np.uint8),
    )


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "events.es"


def test_dvs_bytes(path: Path) -> None:
    reset, overflow = b"\xfe", b"\xff"
    content = header() + bytes([5 << 1 | 1]) + place(1, 2) + reset + 2 * overflow + bytes([126 << 1]) + place(63, 47)
    content += 5 * reset + bytes([0]) + place(0, 0)
    assert read(path, content) == [(5, 1, 2, 1), (5 + 2 * 127 + 126, 63, 47, 0), (5 + 2 * 127 + 126, 0, 0, 0)]


def test_atis_bytes_and_its_exposure_times_passed_over(path: Path) -> None:
    reset, one, three = b"\xfc", b"\xfd", b"\xff"
    exposure_begin, exposure_end = bytes([7 << 2 | 0b01]) + place(3, 3), bytes([9 << 2 | 0b11]) + place(3, 3)
    content = header(ATIS) + bytes([5 << 2 | 0b10]) + place(1, 2) + exposure_begin + reset + one + three + exposure_end
    content += bytes([62 << 2]) + place(63, 47)
    assert read(path, content) == [(5, 1, 2, 1), (5 + 7 + 63 + 189 + 9 + 62, 63, 47, 0)]


@pytest.mark.parametrize("longest_us", [3, 127, 20_000])
def test_what_faery_wrote_is_read_as_faery_reads_it(path: Path, longest_us: int) -> None:
    events = make_events(5000, longest_us)
    recording = read_recording(written_by_faery(path, events, (WIDTH, HEIGHT)))
    assert (recording.width, recording.height) == (WIDTH, HEIGHT)
    assert_same(recording.events, events)
    assert_same(by_others("faery", path), events)


@pytest.mark.parametrize("block_events", [1, 7, 100])
def test_events_across_the_reader_s_pieces(path: Path, monkeypatch: pytest.MonkeyPatch, block_events: int) -> None:
    events = make_events(300, 1000)
    written_by_faery(path, events, (WIDTH, HEIGHT))
    monkeypatch.setattr(es, "BLOCK_EVENTS", block_events)
    blocks = list(EsFile(path).blocks())
    assert max(map(len, blocks)) <= block_events
    assert_same(Events.joined(blocks), events)


def test_an_address_beyond_the_sensor_is_named(path: Path) -> None:
    good = bytes([1]) + place(0, 0)
    assert refusal(path, header() + good + b"\0\0\0\x30\0") == "event 1: y = 48: must be below the sensor's 48"
    assert refusal(path, header() + good + b"\0\x40\0\0\0") == "event 1: x = 64: must be below the sensor's 64"


@pytest.mark.parametrize("rest", range(1, 5))
def test_the_events_before_a_cut_are_given(path: Path, rest: int) -> None:
    content = header() + bytes([1]) + place(1, 1) + (bytes([3]) + place(2, 2))[:rest]
    message = f"ends within an event, at byte {len(content)}; is it cut off?"
    assert refusal(path, content) == message
    with pytest.warns(RecordingWarning, match=f"everything after 1 events left out: {message}"):
        assert read(path, content, damage="skip") == [(0, 1, 1, 1)]


def test_the_file_says_what_it_is(path: Path) -> None:
    path.write_bytes(header(ATIS) + bytes([0]) + place(0, 0))
    with open_recording(path) as file:
        assert (file.format, file.details) == ("Event Stream", {"events": "ATIS", "version": "2.0.0"})


def test_damage(path: Path) -> None:
    content = written_by_faery(path, make_events(50, 300), (WIDTH, HEIGHT)).read_bytes()
    assert fuzz(path, content, seed=52).refused > 2_000
    atis = content.replace(bytes([2, 0, 0, DVS]), bytes([2, 0, 0, ATIS]))
    assert fuzz(path, atis, corruptions=2000, seed=53, damage="skip").lossy > 500
