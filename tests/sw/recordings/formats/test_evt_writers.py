# SPDX-License-Identifier: Apache-2.0
"""Events written as EVT 2.0 or EVT 3.0 are read back unchanged by evcot, by the reference tables, and by other decoders."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from evcot.errors import RecordingError
from evcot.events import Events, Recording
from evcot.recordings.files import open_recording, read_recording, write_events, write_recording
from evcot.recordings.formats.prophesee_header import parse_header

from .reference_evt import FILES, reference

SENSOR = (1280, 720)
EPOCH_US = 1_718_925_184_590_631
NAMES = ("evt3", "evt2")


def as_events(rows: list[tuple[int, int, int, int]]) -> Events:
    t_us, x, y, p = np.array(rows, np.int64).T
    return Events(t_us.copy(), x.astype(np.uint16), y.astype(np.uint16), p.astype(np.uint8))


def make_events(seed: int, count: int = 20_000, start_us: int = 0, longest_us: int = 10) -> Events:
    """Scattered events, and runs of neighbours of which some go left, skip pixels, or stay."""
    random = np.random.default_rng(seed)
    run = np.repeat(np.arange(count), random.integers(1, 60, count))[:count]
    fresh = np.diff(run, prepend=-1) > 0
    step = np.where(fresh, 0, random.choice([1, 1, 1, 1, 2, 5, 0, -1], count))
    path = np.cumsum(step)
    x = random.integers(0, SENSOR[0], count)[run] + path - path[np.flatnonzero(fresh)][np.cumsum(fresh) - 1]
    wait_us = np.where(fresh | (random.random(count) < 0.02), random.integers(0, longest_us, count), 0)
    return Events(
        t_us=start_us + np.cumsum(wait_us),
        x=(x % SENSOR[0]).astype(np.uint16),
        y=random.integers(0, SENSOR[1], count)[run].astype(np.uint16),
        p=(random.integers(0, 2, count)[run] ^ (random.random(count) < 0.02)).astype(np.uint8),
    )


def assert_same(got: Events, wanted: Events) -> None:
    for name in ("t_us", "x", "y", "p"):
        np.testing.assert_array_equal(getattr(got, name), getattr(wanted, name))


def by_the_tables(path: Path, name: str) -> Events:
    content = path.read_bytes()
    header = parse_header(content)
    size, _ = FILES[name]
    words = np.frombuffer(content, f"<u{size}", offset=header.length).tolist()
    read = reference(name, words, header.t0_us)
    assert (read.untimed, read.strange) == (0, 0)
    return as_events(read.rows)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    ("start_us", "longest_us"),
    [
        (0, 10),
        (0, 1),
        (123, 5000),
        ((1 << 24) - 5, 100),
        (5 << 30, 700_000),
        ((1 << 34) - 2, 9),
        (EPOCH_US, 300),
        ((1 << 62) - 60, 50),
    ],
)
def test_what_was_written_is_read_back(tmp_path: Path, name: str, start_us: int, longest_us: int) -> None:
    events = make_events(start_us % 1000, start_us=start_us, longest_us=longest_us)
    path = tmp_path / "events.raw"
    write_recording(Recording(events, *SENSOR), path, name)
    recording = read_recording(path)
    assert_same(recording.events, events)
    assert (recording.width, recording.height) == SENSOR
    assert_same(by_the_tables(path, name), events)


@pytest.mark.parametrize("name", NAMES)
def test_blocks_of_any_size_give_the_same_events(tmp_path: Path, name: str) -> None:
    events = make_events(2, 3000)
    for size in (1, 7, 1000):
        path = tmp_path / f"blocks_of_{size}.raw"
        assert write_events(path, SENSOR, [events[at : at + size] for at in range(0, len(events), size)], name) == len(events)
        assert_same(read_recording(path).events, events)


def test_the_suffix_raw_means_evt3(tmp_path: Path) -> None:
    write_recording(Recording(make_events(1, 10), *SENSOR), tmp_path / "events.raw")
    with open_recording(tmp_path / "events.raw") as file:
        assert file.format == "Prophesee RAW, EVT 3.0"


@pytest.mark.parametrize("name", NAMES)
def test_the_header_is_as_a_camera_s(tmp_path: Path, name: str) -> None:
    path = tmp_path / "events.raw"
    write_recording(Recording(make_events(1, 10), *SENSOR), path, name)
    number = name[-1]
    lines = f"% evt {number}.0\n% format EVT{number};height=720;width=1280\n% geometry 1280x720\n% end\n"
    assert path.read_bytes().startswith(lines.encode())
    write_recording(Recording(make_events(1, 10, start_us=EPOCH_US), *SENSOR), path, name, force=True)
    header = parse_header(path.read_bytes())
    assert 0 < header.t0_us <= EPOCH_US
    assert list(header.fields) == ["evt", "format", "geometry", "t0", "end"][:4]


@pytest.mark.parametrize("name", NAMES)
def test_a_file_of_no_events_has_its_header(tmp_path: Path, name: str) -> None:
    path = tmp_path / "events.raw"
    assert write_events(path, (346, 260), [], name) == 0
    with open_recording(path) as file, pytest.raises(RecordingError, match="holds no events"):
        file.read()
    assert parse_header(path.read_bytes()).sensor == (346, 260)


def words_of(path: Path) -> list[int]:
    content = path.read_bytes()
    return np.frombuffer(content, "<u2", offset=parse_header(content).length).tolist()


@pytest.mark.parametrize("silence_us", [1 << 23, (1 << 23) + 1, 1 << 24, 123_456_789_012, 1 << 44])
def test_evt3_a_silence_is_filled_with_marks_lest_a_turn_is_missed(tmp_path: Path, silence_us: int) -> None:
    events = as_events([(5, 1, 2, 1), (5 + silence_us, 1, 2, 1), (6 + silence_us, 1, 2, 0)])
    path = tmp_path / "events.raw"
    write_recording(Recording(events, *SENSOR), path)
    assert_same(read_recording(path).events, events)
    marks = [word & 4095 for word in words_of(path) if word >> 12 == 8]
    assert max((later - earlier) % 4096 for earlier, later in pairwise(marks)) < 2048
    assert len(marks) < 3 + silence_us / (2000 * 4096)


def test_evt3_neighbours_are_a_vector_from_five_on(tmp_path: Path) -> None:
    path = tmp_path / "events.raw"

    def written(*x: int) -> list[int]:
        write_recording(Recording(as_events([(0, each, 3, 1) for each in x]), *SENSOR), path, force=True)
        assert read_recording(path).events.x.tolist() == list(x)
        return words_of(path)[3:]

    single = 2 << 12 | 1 << 11
    assert written(64, 65, 66, 67) == [single | 64, single | 65, single | 66, single | 67]
    vector = [3 << 12 | 1 << 11 | 64, 4 << 12 | 0b11, 4 << 12 | 1 << 11, 5 << 12 | 0x81]
    assert written(64, 65, 87, 88, 95) == vector
    assert written(64, 65, 87, 88, 95, 96) == [*vector, single | 96]
    assert written(64, 65, 87, 88, 95, 64) == [*vector, single | 64]
    assert written(64, 65, 87, 88, 88) == [single | each for each in (64, 65, 87, 88, 88)]
    assert written(68, 67, 66, 65, 64) == [single | each for each in (68, 67, 66, 65, 64)]


@pytest.mark.parametrize(
    ("name", "rows", "rule"),
    [
        ("evt2", [(0, 1, 1, 1), (1, 2048, 1, 1)], "event 1: x = 2048: must be below 2048 in EVT 2.0"),
        ("evt3", [(0, 1, 2100, 1)], "event 0: y = 2100: must be below 2048 in EVT 3.0"),
        ("evt3", [(-3, 1, 1, 1)], "event 0: t = -3: must not be negative"),
        ("evt2", [(-3, 1, 1, 1)], "event 0: t = -3: must not be negative"),
        (
            "evt2",
            [(0, 1, 1, 1), ((1 << 34) - 1, 1, 1, 1), (1 << 34, 1, 1, 1)],
            "event 2: t = 17179869184: must be below 17179869184: EVT 2.0 lasts for 2^34 us from 0 us on",
        ),
        (
            "evt2",
            [(1 << 40, 1, 1, 1), ((1 << 40) + (1 << 34), 1, 1, 1)],
            "event 1: t = 1116691496960: must be below 1116691496960: EVT 2.0 lasts for 2^34 us from 1099511627776 us on",
        ),
        (
            "evt3",
            [(0, 1, 1, 1), ((1 << 44) + 1, 1, 1, 1)],
            "event 1: t = 17592186044417: must follow the event before within 2^44 us (203 days) in EVT 3.0",
        ),
        ("evt3", [(1 << 62, 1, 1, 1)], "event 0: t = 4611686018427387904: must be below 2^62 at the start"),
        ("evt2", [(1 << 62, 1, 1, 1)], "event 0: t = 4611686018427387904: must be below 2^62 at the start"),
    ],
)
def test_what_the_words_cannot_hold_is_refused_by_event_value_and_rule(
    tmp_path: Path, name: str, rows: list[tuple[int, int, int, int]], rule: str
) -> None:
    path = tmp_path / "events.raw"
    blocks = [as_events([row]) for row in rows]
    for split in (blocks, [as_events(rows)]):
        with pytest.raises(RecordingError) as caught:
            write_events(path, (4096, 4096), split, name)
        assert str(caught.value) == f"{path}: {rule}"
        assert list(tmp_path.iterdir()) == []


def other_decoders() -> dict[str, Any]:
    """Decoder -> (path -> t, x, y, p), for those that are installed."""

    def by_faery(path: Path) -> list[Any]:
        import faery

        events = faery.events_stream_from_file(path).to_array()
        return [events[name] for name in ("t", "x", "y", "on")]

    def by_expelliarmus(path: Path) -> list[Any]:
        wizard = pytest.importorskip("expelliarmus").Wizard(encoding="evt2")
        events = wizard.read(path)
        return [events[name] for name in ("t", "x", "y", "p")]

    def by_evt3(path: Path) -> list[Any]:
        events = pytest.importorskip("evt3").decode_file(str(path))
        return [events.t, events.x, events.y, events.p]

    return {"faery": by_faery, "expelliarmus": by_expelliarmus, "evt3": by_evt3}


@pytest.mark.parametrize(
    ("decoder", "name", "start_us"),
    [
        ("faery", "evt3", 0),
        ("faery", "evt2", 0),
        ("faery", "evt3", EPOCH_US),
        ("faery", "evt2", EPOCH_US),
        ("expelliarmus", "evt2", 0),
        ("evt3", "evt3", 0),
    ],
)
def test_other_decoders_read_what_was_written(tmp_path: Path, decoder: str, name: str, start_us: int) -> None:
    events = make_events(5, start_us=start_us, longest_us=20_000)
    assert events.t_us[-1] - events.t_us[0] > 1 << 23  # on the way time turns in EVT 3.0
    path = tmp_path / "events.raw"
    write_recording(Recording(events, *SENSOR), path, name)
    t_us, x, y, p = other_decoders()[decoder](path)
    for got, wanted in ((t_us, events.t_us), (x, events.x), (y, events.y), (p, events.p)):
        np.testing.assert_array_equal(got.astype(np.int64), wanted.astype(np.int64))
