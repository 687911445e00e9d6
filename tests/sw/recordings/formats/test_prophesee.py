# SPDX-License-Identifier: Apache-2.0
"""Prophesee's files: those of other programs, and seeking."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import faery
import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.events import Events, Recording
from evcot.recordings.files import open_recording, read_recording, write_recording
from evcot.recordings.formats.prophesee import FORMATS
from evcot.recordings.formats.words import WordFile, Words
from shared import SHARED

from .reference_evt import dat_event, evt2_event, evt2_high, evt21_event, evt21_high, packed

FIXTURES = {"evt2": "fixture_evt2_640x480.raw", "evt3": "fixture_evt3_1280x720.raw"}

Columns = list[NDArray[Any]]


def by_faery(path: Path, _: str) -> Columns:
    events = faery.events_stream_from_file(path).to_array()
    return [events[name] for name in ("t", "x", "y", "on")]


def by_evt3(path: Path, _: str) -> Columns:
    events = pytest.importorskip("evt3").decode_file(str(path))
    return [events.t, events.x, events.y, events.p]


def by_expelliarmus(path: Path, kind: str) -> Columns:
    events = pytest.importorskip("expelliarmus").Wizard(encoding=kind).read(path)
    return [events[name] for name in ("t", "x", "y", "p")]


def by_eventcv(path: Path, _: str) -> Columns:
    x, y, t, p = pytest.importorskip("eventcv").load(str(path)).numpy().T
    return [t, x, y, p]


def shared(kind: str) -> Path:
    path = SHARED / FIXTURES[kind]
    if not path.is_file():
        pytest.skip(f"{path.name} is not on this machine")
    return path


def differences(columns: Columns, events: Events) -> dict[str, NDArray[np.int64]]:
    """Theirs less ours, per column that differs."""
    assert len(columns[0]) == len(events)
    names = ("t_us", "x", "y", "p")
    found = {name: theirs.astype(np.int64) - getattr(events, name) for name, theirs in zip(names, columns, strict=True)}
    return {name: values for name, values in found.items() if values.any()}


@pytest.mark.parametrize(
    ("decode", "kind"),
    [(by_faery, "evt2"), (by_evt3, "evt3"), (by_expelliarmus, "evt2"), (by_eventcv, "evt2"), (by_eventcv, "evt3")],
)
def test_every_event_of_a_camera_s_file_is_as_others_read_it(decode: Callable[[Path, str], Columns], kind: str) -> None:
    path = shared(kind)
    assert differences(decode(path, kind), read_recording(path).events) == {}


def test_faery_moves_events_of_evt3_up_to_a_mark_that_runs_ahead() -> None:
    path = shared("evt3")
    later = differences(by_faery(path, "evt3"), read_recording(path).events)
    assert list(later) == ["t_us"]
    assert (np.count_nonzero(later["t_us"]), later["t_us"].min(), later["t_us"].max()) == (1455, 0, 11)


def test_expelliarmus_adds_turns_to_evt3_that_are_none() -> None:
    path = shared("evt3")
    later = differences(by_expelliarmus(path, "evt3"), read_recording(path).events)
    assert list(later) == ["t_us"]
    assert later["t_us"].min() == 0
    assert set(np.unique(later["t_us"] % 4096).tolist()) == {0}


def evt21_file(path: Path) -> Path:
    random = np.random.default_rng(3)
    words = []
    for mark in range(2000):
        x, y, p, low, valid = (int(each) for each in random.integers(0, (10, 320, 2, 64, 1 << 32)))
        words += [evt21_high(mark), evt21_event(p, low, 32 * x, y, valid)]
    header = b"% evt 2.1\n% format EVT21;endianness=little;height=320;width=320\n% geometry 320x320\n% end\n"
    path.write_bytes(packed("evt21", words, header))
    return path


def test_eventcv_reads_evt21_as_something_else(tmp_path: Path) -> None:
    path = evt21_file(tmp_path / "events.raw")
    events = read_recording(path).events
    columns = by_eventcv(path, "evt21")
    assert len(columns[0]) != len(events) or differences(columns, events)


@pytest.mark.parametrize("decode", [by_faery, by_expelliarmus, by_eventcv])
def test_dat_is_as_others_read_it(tmp_path: Path, decode: Callable[[Path, str], Columns]) -> None:
    random = np.random.default_rng(4)
    times = np.sort(random.integers(0, 1 << 31, 3000)).tolist()
    words = [dat_event(t, *(int(each) for each in random.integers(0, (640, 480, 2)))) for t in times]
    path = tmp_path / "events.dat"
    path.write_bytes(packed("dat2", words, b"% Version 2\n% Width 640\n% Height 480\n\x0c\x08"))
    assert differences(decode(path, "dat"), read_recording(path).events) == {}


@pytest.mark.parametrize("decode", [by_faery, by_expelliarmus, by_eventcv])
def test_evt2_with_triggers_is_as_others_read_it(tmp_path: Path, decode: Callable[[Path, str], Columns]) -> None:
    random = np.random.default_rng(5)
    words = []
    for mark in range(1000, 3000):
        x, y, p = (int(each) for each in random.integers(0, (640, 480, 2)))
        words += [evt2_high(mark), evt2_event(p, mark % 64, x, y)] + ([10 << 28 | 63 << 22 | 1] if mark % 9 == 0 else [])
    path = tmp_path / "events.raw"
    path.write_bytes(packed("evt2", words, b"% evt 2.0\n% format EVT2;height=480;width=640\n% geometry 640x480\n% end\n"))
    assert differences(decode(path, "evt2"), read_recording(path).events) == {}


KINDS = ("evt2", "evt21", "evt21-legacy", "evt3", "dat")
SENSOR = (640, 480)
T0_US = 5_000_003


def make_events(count: int, duration_us: int, seed: int) -> Events:
    random = np.random.default_rng(seed)
    bursts = np.sort(random.integers(0, duration_us, 20))
    t_us = np.concatenate((random.integers(0, duration_us, count // 2), random.choice(bursts, count - count // 2)))
    return Events(
        t_us=T0_US + np.sort(t_us),
        x=random.integers(0, SENSOR[0], count).astype(np.uint16),
        y=random.integers(0, SENSOR[1], count).astype(np.uint16),
        p=random.integers(0, 2, count).astype(np.uint8),
    )


def write(path: Path, kind: str, events: Events) -> Path:
    if kind == "evt3":
        write_recording(Recording(events, *SENSOR), path, kind)
        return path
    t_us, x, y, p = (values.astype(np.uint64) for values in (events.t_us, events.x, events.y, events.p))
    if kind == "dat":
        words = (t_us & np.uint64(0xFFFFFFFF)) | (x | y << 14 | p << 28) << 32
        path.write_bytes(b"% Version 2\n% Width 640\n% Height 480\n\x0c\x08" + words.tobytes())
        return path
    heads = np.stack((8 << 28 | t_us >> 6 & 0xFFFFFFF, p << 28 | (t_us & 63) << 22 | x << 11 | y), 1)
    if kind == "evt2":
        path.write_bytes(b"% evt 2.0\n% geometry 640x480\n% end\n" + heads.astype("<u4").tobytes())
        return path
    valid = np.stack((0 * x, 1 + 0 * x), 1)
    words = (heads << 32 | valid) if kind == "evt21" else (valid << 32 | heads)
    order = "little" if kind == "evt21" else "legacy"
    header = f"% evt 2.1\n% format EVT21;endianness={order};width=640;height=480\n% end\n"
    path.write_bytes(header.encode() + words.tobytes())
    return path


def joined(path: Path, from_us: int = 0, to_us: int | None = None) -> Events:
    with open_recording(path) as file:
        return Events.joined(file.blocks(from_us, to_us))


def assert_same(got: Events, wanted: Events) -> None:
    for name in ("t_us", "x", "y", "p"):
        np.testing.assert_array_equal(getattr(got, name), getattr(wanted, name))


@pytest.mark.parametrize("kind", KINDS)
def test_a_window_is_what_a_full_read_has_in_it(tmp_path: Path, kind: str) -> None:
    duration_us = 60_000_000  # three and a half turns of EVT 3.0
    events = make_events(100_000, duration_us, seed=1)
    path = write(tmp_path / "events", kind, events)
    assert_same(joined(path), events)
    after_us = events.t_us - events.t_us[0]
    random = np.random.default_rng(2)
    edges = [(0, 1), (1, 2), (duration_us - 9, None), (duration_us * 2, None), (int(after_us[50_000]), int(after_us[50_001]))]
    for _ in range(30):
        begin, end = np.sort(random.integers(0, duration_us, 2)).tolist()
        edges += [(begin, end), (int(random.choice(after_us)), None)]
    for from_us, to_us in edges:
        begin = int(np.searchsorted(after_us, from_us))
        end = len(events) if to_us is None else int(np.searchsorted(after_us, to_us))
        assert_same(joined(path, from_us, to_us), events[begin:end])


@pytest.mark.parametrize("kind", KINDS)
def test_most_of_a_long_file_stays_unread_or_undecoded(tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    count = 2_000_000
    path = write(tmp_path / "events", kind, make_events(count, 60_000_000, seed=3))
    read = decoded = 0

    def counted_read(words: Words, window: slice) -> np.ndarray:  # type: ignore[type-arg]
        nonlocal read
        piece = original(words, window)
        read += len(piece)
        return piece

    original = Words.__getitem__
    monkeypatch.setattr(Words, "__getitem__", counted_read)
    source = next(each for each in FORMATS if each.matches(path.read_bytes()[:1024], path)).open(path)
    assert isinstance(source, WordFile)
    fill = source._layout.fill

    def counted_fill(words, *rest):  # type: ignore[no-untyped-def]
        nonlocal decoded
        decoded += len(words)
        return fill(words, *rest)

    source._layout = replace(source._layout, fill=counted_fill)
    with closing(source):
        block = next(source.blocks(T0_US + 55_000_000))
        assert abs(int(block.t_us[0]) - (T0_US + 55_000_000)) < 5000
        piece = source._piece_words
        assert decoded <= piece
        if kind == "evt3":
            assert read > len(source._words) // 2  # its 24 bits of time turn: every upper mark up to there must be seen
        else:
            assert read <= piece + len(source._words) // 4


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "evt3"])
@pytest.mark.parametrize("turns", [0.01, 2.8])
def test_where_time_turns_on_the_way_all_is_read_through(tmp_path: Path, kind: str, turns: float) -> None:
    turn_us = 1 << (32 if kind == "dat" else 34)
    duration_us = int(turns * turn_us)
    events = make_events(300_000, duration_us, seed=4)  # enough to be searched and not read through anyway
    t_us = events.t_us - events.t_us[0] + turn_us - duration_us // 3
    path = write(tmp_path / "events", kind, Events(t_us % turn_us, events.x, events.y, events.p))
    full = joined(path)
    assert_same(full, Events(t_us, events.x, events.y, events.p))
    for from_us in (duration_us * np.linspace(0, 0.99, 12)).astype(np.int64).tolist():
        assert_same(joined(path, from_us), full[int(np.searchsorted(t_us, t_us[0] + from_us)) :])


def test_the_state_of_the_words_before_goes_along(tmp_path: Path) -> None:
    """Row, base and polarity of EVT 3.0 may be far behind: the window has the events of a full read all the same."""
    words = [0x8000, 0x6000, 7, 0x3000 | 1 << 11 | 100]
    for mark in range(1, 3000):
        words += [0x8000 | mark % 4096, 0x4001] if mark % 50 else [0x8000 | mark % 4096, 0x2000 | 9, 0x3000 | 40]
    path = tmp_path / "events"
    path.write_bytes(b"% evt 3.0\n% geometry 1280x720\n% end\n" + np.array(words, "<u2").tobytes())
    full = joined(path)
    for begin in range(0, len(full), 97):
        from_us = int(full.t_us[begin] - full.t_us[0])
        assert_same(joined(path, from_us), full[int(np.searchsorted(full.t_us, full.t_us[begin])) :])
