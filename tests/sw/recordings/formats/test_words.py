# SPDX-License-Identifier: Apache-2.0
"""Formats of fixed words, read and written: EVT 2, EVT 2.1, EVT 3, N-MNIST."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import closing
from itertools import chain, pairwise
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import RecordingError
from evcot.events import Events, Recording
from evcot.recordings.files import open_recording, read_recording, write_events, write_recording
from evcot.recordings.formats import nmnist
from evcot.recordings.formats.prophesee import FORMATS
from evcot.recordings.formats.prophesee_header import parse_header
from evcot.recordings.formats.source import BLOCK_EVENTS
from evcot.recordings.formats.words import WordFile
from support.refusals import refused

from .fuzzing import fuzz
from .reading import Row, assert_same, by_others, read, refusal, rows_of
from .reference_evt import (
    FILES,
    dat_event,
    evt2_event,
    evt2_high,
    evt3_base,
    evt3_event,
    evt3_high,
    evt3_low,
    evt3_row,
    evt3_vector8,
    evt3_vector12,
    evt21_event,
    evt21_high,
    reference,
    write,
)


def opened(path: Path, piece_words: int | None = None) -> WordFile:
    source = next(each for each in FORMATS if each.matches(path.read_bytes()[:1024], path)).open(path)
    assert isinstance(source, WordFile)
    if piece_words is not None:
        source._piece_words = piece_words
    return source


def rows(source: WordFile, from_us: int | None = None) -> list[Row]:
    return [row for block in source.blocks(from_us) for row in rows_of(block)]


def decoded(path: Path, kind: str, words: Iterable[int], header: bytes | None = None) -> tuple[list[Row], int]:
    """The events, and how many events and words were left out."""
    with closing(opened(write(path, kind, [*words], header))) as source:
        return rows(source), sum(source.left_out.values())


START3 = (evt3_high(0), evt3_row(4), evt3_base(1, 100))
TURNS3 = (0, 2000, 4000, 0, 2000, 4000, 4095, 1)
STORIES: dict[str, tuple[str, tuple[int, ...], list[Row], int]] = {  # kind, words, the events, how many were left out
    "evt2: the time mark counts 64 us, an event has 6 bits more": (
        "evt2", (evt2_high(3), evt2_event(1, 5, 639, 479), evt2_event(0, 63, 0, 2047)),
        [(3 * 64 + 5, 639, 479, 1), (3 * 64 + 63, 0, 2047, 0)], 0),
    "evt2: time goes on where the mark wraps around": (
        "evt2", (evt2_high((1 << 28) - 1), evt2_event(0, 63, 1, 1), evt2_high(0), evt2_event(0, 0, 1, 1)),
        [((1 << 34) - 1, 1, 1, 0), (1 << 34, 1, 1, 0)], 0),
    "evt2: time that runs back is left for the recording to refuse": (
        "evt2", (evt2_high(10), evt2_event(0, 0, 1, 1), evt2_high(9), evt2_event(0, 0, 1, 1)),
        [(640, 1, 1, 0), (576, 1, 1, 0)], 0),
    "evt2: events before the first mark are left out": (
        "evt2", (evt2_event(0, 1, 1, 1), evt2_event(1, 2, 2, 2), evt2_high(0), evt2_event(1, 3, 3, 3)), [(3, 3, 3, 1)], 2),
    **{
        f"{kind}: an event per set bit, from left to right": (
            kind, (evt21_high(3), evt21_event(1, 5, 64, 9, 1 << 31 | 0b101), evt21_event(0, 6, 0, 2047, 0)),
            [(197, 64, 9, 1), (197, 66, 9, 1), (197, 95, 9, 1)], 0)
        for kind in ("evt21", "evt21-legacy")
    },
    "evt21: events before the first mark are left out": (
        "evt21", (evt21_event(0, 1, 0, 1, 0b1101), evt21_high(0), evt21_event(1, 3, 3, 3, 1)), [(3, 3, 3, 1)], 3),
    "evt3: single events share row and time": (
        "evt3", (evt3_high(2), evt3_low(7), evt3_row(719), evt3_event(1, 1279), evt3_event(0, 0)),
        [(2 * 4096 + 7, 1279, 719, 1), (2 * 4096 + 7, 0, 719, 0)], 0),
    "evt3: vectors move their base on": (
        "evt3", (*START3, evt3_vector12(0x801), evt3_vector12(0), evt3_vector8(0x80)),
        [(0, 100, 4, 1), (0, 111, 4, 1), (0, 100 + 24 + 7, 4, 1)], 0),
    "evt3: a vector of eight has no ninth event": ("evt3", (*START3, evt3_vector8(0xF01)), [(0, 100, 4, 1)], 0),
    "evt3: a single event leaves a vector's base and polarity alone": (
        "evt3", (*START3, evt3_event(0, 7), evt3_vector8(1)), [(0, 7, 4, 0), (0, 100, 4, 1)], 0),
    "evt3: a camera's periodic mark that runs ahead moves no event": (
        "evt3", (evt3_high(1), evt3_low(799), evt3_row(0), evt3_event(1, 1), evt3_low(811), evt3_low(800), evt3_event(1, 2)),
        [(4096 + 799, 1, 0, 1), (4096 + 800, 2, 0, 1)], 0),
    "evt3: a new upper part clears the lower, a repeated one changes nothing": (
        "evt3", (evt3_row(0), evt3_high(1), evt3_low(9), evt3_high(1), evt3_event(0, 1), evt3_high(2), evt3_event(0, 2),
                 evt3_low(3), evt3_event(0, 3)),
        [(4096 + 9, 1, 0, 0), (8192, 2, 0, 0), (8192 + 3, 3, 0, 0)], 0),
    "evt3: time goes on where the mark wraps around": (
        "evt3", (evt3_row(0), *chain(*((evt3_high(mark), evt3_event(0, 1)) for mark in TURNS3))),
        [(4096 * mark, 1, 0, 0) for mark in (0, 2000, 4000, 4096, 6096, 8096, 8191, 8193)], 0),
    "evt3: events before time and base are left out": (
        "evt3", (evt3_row(5), evt3_event(1, 1), evt3_high(0), evt3_vector12(0b111), evt3_event(1, 2)), [(0, 2, 5, 1)], 4),
    "evt3: events before the row are left out": (
        "evt3", (evt3_high(0), evt3_event(1, 1), evt3_row(5), evt3_event(1, 2)), [(0, 2, 5, 1)], 1),
    "evt3: a row of another camera's events is no row for these": (
        "evt3", (evt3_high(1), evt3_row(3), 1 << 12 | 4, evt3_event(1, 9), evt3_row(5), evt3_event(0, 8)),
        [(4096, 8, 5, 0)], 2),
    "dat2: a time in every word, which wraps around": (
        "dat2", (dat_event((1 << 32) - 1, 16383, 16383, 1), dat_event(3, 0, 1, 0)),
        [((1 << 32) - 1, 16383, 16383, 1), ((1 << 32) + 3, 0, 1, 0)], 0),
    "dat1: other widths; time that runs back is left for the recording to refuse": (
        "dat1", (dat_event(8, 511, 255, 1, version=1), dat_event(7, 0, 1, 0, version=1)), [(8, 511, 255, 1), (7, 0, 1, 0)], 0),
}  # fmt: skip


@pytest.mark.parametrize("story", STORIES)
def test_words_mean_what_the_format_says(tmp_path: Path, story: str) -> None:
    kind, words, events, lost = STORIES[story]
    assert decoded(tmp_path / "events", kind, words) == (events, lost)


@pytest.mark.parametrize("kind", ["evt2", "evt3"])
def test_the_header_s_t0_is_added_to_every_time(tmp_path: Path, kind: str) -> None:
    words = {
        "evt2": (evt2_high(3), evt2_event(1, 5, 6, 4)),
        "evt3": (evt3_high(0), evt3_low(197), evt3_row(4), evt3_event(1, 6)),
    }
    header = f"% evt {kind[3]}.0\n% t0 1000\n% end\n".encode()
    assert decoded(tmp_path / "events", kind, words[kind], header) == ([(1197, 6, 4, 1)], 0)


@pytest.mark.parametrize("kind", ["evt21", "evt21-legacy"])
def test_time_marks_show_the_order_of_evt21_where_the_header_leaves_it_out(tmp_path: Path, kind: str) -> None:
    words = (evt21_high(3), evt21_event(1, 5, 64, 9, 0x80000001), evt21_event(0, 5, 0, 8, 0x80000000), evt21_high(4))
    expected = [(197, 64, 9, 1), (197, 95, 9, 1), (197, 31, 8, 0)]
    assert decoded(tmp_path / "events", kind, words, b"% evt 2.1\n% end\n") == (expected, 0)


@pytest.mark.parametrize("code", range(2, 16))
def test_words_of_other_kinds_are_passed_over_and_reserved_ones_counted(tmp_path: Path, code: int) -> None:
    known = {"evt2": (10, 14, 15), "evt21": (10, 14, 15), "evt3": (7, 10, 14, 15)}
    words = {
        "evt2": (evt2_high(1), code << 28 | 12345, evt2_event(1, 0, 7, 8)),
        "evt21": (evt21_high(1), code << 60 | 12345 << 20, evt21_event(1, 0, 7, 8, 1)),
        "evt3": (evt3_high(0), evt3_low(64), evt3_row(8), code << 12 | 1234, evt3_event(1, 7)),
    }
    for kind in ("evt2", "evt21", "evt3") if code >= 7 else ("evt2", "evt21"):
        if code != 8:
            assert decoded(tmp_path / "events", kind, words[kind]) == ([(64, 7, 8, 1)], int(code not in known[kind])), kind


def test_evt3_a_base_that_vectors_move_on_for_ever_never_comes_back_inside(tmp_path: Path) -> None:
    found, _ = decoded(
        tmp_path / "events", "evt3", (evt3_high(0), evt3_row(4), evt3_base(1, 2040), *[evt3_vector12(1)] * 20_000)
    )
    assert [event[1] for event in found[:3]] == [2040, 2052, 2064]
    assert min(event[1] for event in found[1:]) > 2047


def random_words(kind: str, count: int, seed: int) -> list[int]:
    """Words of every kind in any order, time marks that rise, repeat, fall and wrap among them."""
    random = np.random.default_rng(seed)
    mark = int(random.integers(1 << 28))
    words = []
    for raw in random.integers(0, 1 << 63, count, dtype=np.uint64).tolist():
        share = random.random()
        mark += int(random.choice([0, 1, 2, 700, 1 << 20, -1 if share < 0.5 else 1]))
        if kind.startswith("dat"):
            words.append(raw >> 32 << 32 | mark * 997 % (1 << 32))
        elif kind == "evt3":
            word = raw % (1 << 16)
            words.append(evt3_high(mark % 4096) if share < 0.1 else word % (1 << 15) if share < 0.9 else word)
        elif kind == "evt2":
            word = raw % (1 << 32)
            words.append(evt2_high(mark % (1 << 28)) if share < 0.1 else word % (1 << 29) if share < 0.9 else word)
        else:
            sparse = raw & int(random.integers(1 << 62)) & int(random.integers(1 << 62))
            dense = sparse if random.random() < 0.9 else raw
            other = dense | int(random.integers(16)) << 60 if share > 0.9 else dense % (1 << 61)
            words.append(evt21_high(mark % (1 << 28)) if share < 0.1 else other)
    return words


@pytest.mark.parametrize("kind", FILES)
@pytest.mark.parametrize("seed", range(4))
def test_random_words_mean_what_the_tables_say_wherever_the_pieces_are_cut(tmp_path: Path, kind: str, seed: int) -> None:
    words = random_words(kind, 3000, seed)
    expected = reference(kind, words)
    assert len(expected.rows) > 1000
    path = write(tmp_path / "events", kind, words)
    for piece_words in (1, 2, 7, 1000, 1 << 18):
        with closing(opened(path, piece_words)) as source:
            assert rows(source) == expected.rows
            assert sum(source.left_out.values()) == expected.untimed + expected.strange


@pytest.mark.parametrize("kind", [kind for kind in FILES if kind.startswith("evt")])
@pytest.mark.parametrize("seed", range(4))
def test_from_any_time_on_random_words_mean_the_same(tmp_path: Path, kind: str, seed: int) -> None:
    random = np.random.default_rng(seed)
    mark_bits = 12 if kind == "evt3" else 28
    words, mark = [], 0
    for word in random_words(kind, 2000, seed):
        if word >> {"evt2": 28, "evt3": 12}.get(kind, 60) == 8:
            mark += int(random.choice([0, 1, 5, 900]))
            word = {"evt2": evt2_high, "evt3": evt3_high}.get(kind, evt21_high)(mark % (1 << mark_bits))
        words.append(word)
    low_bits = 12 if kind == "evt3" else 6
    with closing(opened(write(tmp_path / "events", kind, words), 100)) as source:
        full = rows(source)
        assert full == reference(kind, words).rows
        for from_us in [*random.integers(0, mark << low_bits, 40).tolist(), 0, mark << low_bits]:
            part = rows(source, from_us)
            rest = full[: len(full) - len(part)]
            assert rest + part == full
            assert all(event[0] < from_us for event in rest)
            assert len(part) < len(full) or from_us < full[0][0] + (1 << low_bits)


@pytest.mark.parametrize(
    ("kind", "start", "word", "most"),
    [
        ("evt21", [evt21_high(0)], evt21_event(0, 0, 0, 0, 0xFFFFFFFF), 32),
        ("evt3", [evt3_high(0), evt3_row(1), evt3_base(1, 7)], evt3_vector12(0xFFF), 12),
    ],
)
def test_a_block_is_given_whenever_one_is_full(tmp_path: Path, kind: str, start: list[int], word: int, most: int) -> None:
    with closing(opened(write(tmp_path / "events", kind, start + [word] * 60_000))) as source:
        counts = [len(block) for block in source.blocks()]
    assert sum(counts) == most * 60_000
    assert max(counts) <= BLOCK_EVENTS + most
    assert len(counts) == -(-sum(counts) // BLOCK_EVENTS)


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
    [(0, 10), (0, 1), (123, 5000), ((1 << 24) - 5, 100), (5 << 30, 700_000), ((1 << 34) - 2, 9), (EPOCH_US, 300),
     ((1 << 62) - 60, 50)],
)  # fmt: skip
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
        *((name, [(-3, 1, 1, 1)], "event 0: t = -3: must not be negative") for name in NAMES),
        *((name, [(1 << 62, 1, 1, 1)], f"event 0: t = {1 << 62}: must be below 2^62 at the start") for name in NAMES),
        (
            "evt2", [(0, 1, 1, 1), ((1 << 34) - 1, 1, 1, 1), (1 << 34, 1, 1, 1)],
            "event 2: t = 17179869184: must be below 17179869184: EVT 2.0 lasts for 2^34 us from 0 us on",
        ),
        (
            "evt2", [(1 << 40, 1, 1, 1), ((1 << 40) + (1 << 34), 1, 1, 1)],
            "event 1: t = 1116691496960: must be below 1116691496960: EVT 2.0 lasts for 2^34 us from 1099511627776 us on",
        ),
        (
            "evt3", [(0, 1, 1, 1), ((1 << 44) + 1, 1, 1, 1)],
            "event 1: t = 17592186044417: must follow the event before within 2^44 us (203 days) in EVT 3.0",
        ),
    ],
)  # fmt: skip
def test_what_the_words_cannot_hold_is_refused_by_event_value_and_rule(
    tmp_path: Path, name: str, rows: list[Row], rule: str
) -> None:
    for split in ([as_events([row]) for row in rows], [as_events(rows)]):
        with refused(RecordingError, f"{tmp_path / 'events.raw'}: {rule}"):
            write_events(tmp_path / "events.raw", (4096, 4096), split, name)
        assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("reader", "name", "start_us"),
    [("faery", "evt3", 0), ("faery", "evt2", 0), ("faery", "evt3", EPOCH_US), ("faery", "evt2", EPOCH_US),
     ("expelliarmus", "evt2", 0), ("evt3", "evt3", 0)],
)  # fmt: skip
def test_other_packages_read_what_was_written(tmp_path: Path, reader: str, name: str, start_us: int) -> None:
    events = make_events(5, start_us=start_us, longest_us=20_000)
    assert events.t_us[-1] - events.t_us[0] > 1 << 23  # on the way time turns in EVT 3.0
    path = tmp_path / "events.raw"
    write_recording(Recording(events, *SENSOR), path, name)
    assert_same(by_others(reader, path, **({"encoding": "evt2"} if reader == "expelliarmus" else {})), events)


def packed(t_us: int, x: int, y: int, p: int) -> bytes:
    return bytes([x, y]) + (p << 23 | t_us).to_bytes(3, "big")


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "00002.bin"


def test_bytes_and_overflows(path: Path) -> None:
    content = [(5, 1, 33, 0), (8_000, 33, 0, 1), (0, 0, 240, 0), (100, 2, 3, 1), (8_388_607, 239, 239, 0)]
    path.write_bytes(b"".join(packed(*event) for event in content))
    with open_recording(path) as file:
        assert file.format == "N-MNIST bin"
        found = rows_of(file.read().events)
    assert found == [(5, 1, 33, 0), (8_000, 33, 0, 1), (8_292, 2, 3, 1), (8_396_799, 239, 239, 0)]


def made(count: int) -> tuple[bytes, list[tuple[int, ...]]]:
    random = np.random.default_rng(7)
    t_us = np.cumsum(random.integers(0, 90, count))
    content, wanted, over = [], [], 0
    for t, (x, y, p) in zip(t_us.tolist(), random.integers(0, (34, 34, 2), (count, 3)).tolist(), strict=True):
        while t - over >= 1 << 13:
            content.append(packed(0, 0, 240, 0))
            over += 1 << 13
        content.append(packed(t - over, x, y, p))
        wanted.append((t, x, y, p))
    return b"".join(content), wanted


@pytest.mark.parametrize("block_events", [3, 1 << 15])
def test_blocks_change_nothing(path: Path, monkeypatch: pytest.MonkeyPatch, block_events: int) -> None:
    monkeypatch.setattr(nmnist, "BLOCK_EVENTS", block_events)
    content, wanted = made(1_000)
    assert read(path, content) == wanted


@pytest.mark.parametrize("rest", range(1, 5))
def test_the_events_before_a_cut_are_given(path: Path, rest: int) -> None:
    content, wanted = made(50)
    assert refusal(path, content + content[:rest]) == f"ends within the event at byte {len(content)}; is it cut off?"
    with pytest.warns(match="cut off"):
        assert rows_of(read_recording(path, damage="skip").events) == wanted


def test_other_files_of_that_suffix_are_not_taken_for_it(path: Path) -> None:
    assert refusal(path, np.random.default_rng(1).bytes(5_000)).startswith("has an unknown format")


def test_damage(path: Path) -> None:
    content = made(50)[0]
    assert fuzz(path, content, seed=54).refused > 100
    assert fuzz(path, content, corruptions=2000, seed=55, damage="skip").lossy > 50
