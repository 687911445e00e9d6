# SPDX-License-Identifier: Apache-2.0
"""Prophesee's files: as other packages read them, seeking in them, their headers, and their damage."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import RecordingError, RecordingWarning
from evcot.events import Events, Recording
from evcot.recordings.files import Damage, open_recording, read_recording, write_recording
from evcot.recordings.formats.prophesee import FORMATS
from evcot.recordings.formats.words import WordFile, Words

from .fuzzing import fuzz
from .reading import assert_same, by_others, refusal, rows_of, shared
from .reference_evt import (
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
    packed,
)


@pytest.mark.parametrize("reader", ["faery", "evt3", "expelliarmus", "eventcv"])
@pytest.mark.parametrize(
    ("name", "sensor"), [("fixture_evt2_640x480.raw", (640, 480)), ("fixture_evt3_1280x720.raw", (1280, 720))], ids=["2", "3"]
)
def test_a_camera_s_file_is_read_as_other_packages_read_it(name: str, sensor: tuple[int, int], reader: str) -> None:
    path, is_evt3 = shared(name), sensor == (1280, 720)
    if reader == "evt3" and not is_evt3:
        return
    found = read_recording(path)
    assert (found.width, found.height) == sensor
    events = by_others(reader, path, **({"encoding": "evt3" if is_evt3 else "evt2"} if reader == "expelliarmus" else {}))
    later_us = events.t_us - found.events.t_us
    assert_same(found.events, Events(found.events.t_us, events.x, events.y, events.p))
    if is_evt3 and reader == "faery":  # moves events up to a time mark that runs ahead of them
        assert (np.count_nonzero(later_us), later_us.min(), later_us.max()) == (1455, 0, 11)
    elif is_evt3 and reader == "expelliarmus":  # adds turns of the time mark that are none
        assert set(np.unique(later_us % 4096).tolist()) == {0}
    else:
        assert not later_us.any()


@pytest.mark.parametrize("reader", ["faery", "expelliarmus", "eventcv"])
def test_dat_and_evt2_with_triggers_are_read_as_other_packages_read_them(tmp_path: Path, reader: str) -> None:
    random = np.random.default_rng(4)
    times = np.sort(random.integers(0, 1 << 31, 3000)).tolist()
    dat = [dat_event(t, *(int(each) for each in random.integers(0, (640, 480, 2)))) for t in times]
    evt2 = []
    for mark in range(1000, 3000):
        x, y, p = (int(each) for each in random.integers(0, (640, 480, 2)))
        evt2 += [evt2_high(mark), evt2_event(p, mark % 64, x, y)] + ([10 << 28 | 63 << 22 | 1] if mark % 9 == 0 else [])
    for path, content in (
        (tmp_path / "events.dat", packed("dat2", dat, b"% Version 2\n% Width 640\n% Height 480\n\x0c\x08")),
        (tmp_path / "events.raw", packed("evt2", evt2, b"% evt 2.0\n% geometry 640x480\n% end\n")),
    ):
        path.write_bytes(content)
        options = {"encoding": {".dat": "dat", ".raw": "evt2"}[path.suffix]} if reader == "expelliarmus" else {}
        assert_same(read_recording(path).events, by_others(reader, path, **options))


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


HEADERS = {
    "evt2": b"% evt 2.0\n% format EVT2;height=240;width=320\n% geometry 320x240\n% end\n",
    "evt21": b"% evt 2.1\n% format EVT21;endianness=little;height=240;width=320\n% end\n",
    "evt21-legacy": b"% evt 2.1\n% endianness legacy\n% geometry 320x240\n% end\n",
    "evt3": b"% evt 3.0\n% format EVT3;height=240;width=320\n% geometry 320x240\n% t0 1718925184590631\n% end\n",
    "dat1": b"% Version 1\n% Width 304\n% Height 240\n\x00\x08",
    "dat2": b"% Version 2\n% Width 320\n% Height 240\n\x0c\x08",
}


def small_file(kind: str) -> bytes:
    """About 50 events with marks, vectors, triggers and vendors' words among them."""
    random = np.random.default_rng(7)
    words: list[int] = []
    for step in range(16):
        x, y, p, low = (int(each) for each in random.integers(0, (280, 240, 2, 60)))
        match kind:
            case "evt2":
                words += [evt2_high(5 + step), *(evt2_event(p, low + each, x + each, y) for each in range(3))]
                words += [0xA0000001] if step % 5 == 0 else []
            case "evt21" | "evt21-legacy":
                words += [evt21_high(5 + step), evt21_event(p, low, x, y, 0b10011 << step)]
                words += [0xE << 60 | 20] if step % 5 == 0 else []
            case "evt3":
                words += [evt3_high(4090 + step if step < 6 else step - 6), evt3_low(40 * low), evt3_row(y)]
                words += [evt3_event(p, x)] if step % 3 else [evt3_base(p, x), *[evt3_vector12(0x409)] * 2, evt3_vector8(0x81)]
                words += [0xA001, 0xE014, 0xF001, 0x7001] if step % 5 == 0 else []
            case _:
                words += [dat_event(1000 * step + low + each, x, y, p, int(kind[-1])) for each in range(3)]
    return packed(kind, words, HEADERS[kind])


@pytest.mark.parametrize("damage", ["refuse", "skip"])
@pytest.mark.parametrize("kind", HEADERS)
def test_every_cut_and_many_corruptions_are_answered_by_the_rules(tmp_path: Path, kind: str, damage: Damage) -> None:
    refuses = damage == "refuse"
    corruptions = 10_000 if refuses else 1_000
    outcomes = fuzz(tmp_path / "events", small_file(kind), corruptions=corruptions, seed=11, damage=damage)
    assert outcomes.refused > (1000 if refuses else 50)
    assert outcomes.read > 100
    assert outcomes.lossy > 100 or (refuses and kind.startswith("dat"))  # DAT has no reserved words, and a time in every word


def test_what_stands_before_a_word_that_is_cut_off_can_be_had(tmp_path: Path) -> None:
    path, content = tmp_path / "events", packed("evt2", [evt2_high(1), evt2_event(1, 2, 3, 4), evt2_event(1, 2, 4, 4)])[:-1]
    assert refusal(path, content) == f"ends within a word of 4 bytes, at byte {len(content)}; is it cut off?"
    with pytest.warns(RecordingWarning, match="everything after 1 events left out: ends within a word of 4 bytes"):
        assert len(read_recording(path, damage="skip").events) == 1


def test_a_file_that_shrinks_while_it_is_read_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "events"
    content = packed("dat2", [dat_event(each, 1, 1, 1) for each in range(10)])
    path.write_bytes(content)
    with open_recording(path, (2, 2)) as file:
        path.write_bytes(content[:-20])
        with pytest.raises(RecordingError, match=f"ends at byte {len(content) - 20}, earlier than when it was opened"):
            file.read()


@pytest.mark.parametrize("sensor", [b"", b"% geometry 1280x720\n"])
def test_events_beyond_the_sensor_are_refused_with_and_without_a_stated_one(tmp_path: Path, sensor: bytes) -> None:
    path, header = tmp_path / "events", b"% evt 3.0\n" + sensor + b"% end\n"
    start, message = [evt3_high(0), evt3_row(4), evt3_base(1, 1275)], "x = 1280: must be below the sensor's 1280"
    assert refusal(path, packed("evt3", [*start, evt3_vector12(0x21)], header)) == f"event 1: {message}"
    endless = [*start, *[evt3_vector12(0)] * 6000, evt3_vector12(1)]
    assert "must be below the sensor's 1280" in refusal(path, packed("evt3", endless, header))
    row = packed("evt3", [evt3_high(0), evt3_row(720), evt3_event(1, 5)], header)
    assert refusal(path, row) == "event 0: y = 720: must be below the sensor's 720"
    words = [evt21_high(0), evt21_event(1, 0, 1279, 4, 0b11)]
    assert refusal(path, packed("evt21", words, header.replace(b"3.0", b"2.1"))) == f"event 1: {message}"


@pytest.mark.parametrize(
    ("header", "rule"),
    [
        (b"% evt 2.0\n% format EVT3;height=720;width=1280\n", "header: EVT version 2 and 3: evt and format must say the same"),
        (b"% evt 3.0\n% geometry 0x720\n", "sensor 0x720: each side must be from 1 to 65536 pixels"),
        (b"% evt 2.1\n% endianness big\n", "header: endianness = big: must be little or legacy"),
        *(
            (f"% evt 3.0\n% t0 {t0}\n".encode(), f"header: t0 = {t0[:40]}: must be a whole number of microseconds below 2^62")
            for t0 in ("4611686018427387904", "-5", "9" * 5000)
        ),
        (b"% evt 3.0\n% " + b"a" * 70_000, "ends within its header, at byte 65536: a header line must end in a newline"),
        (b"% evt 9\x1b[2J\n", "EVT version 9?[2J: must be 2.0, 2.1 or 3.0"),
    ],
)  # fmt: skip
def test_a_header_that_makes_no_sense_is_refused_by_rule(tmp_path: Path, header: bytes, rule: str) -> None:
    content = header + b"% end\n" + np.array([0x8000, 1, 0x2001, 0], "<u2").tobytes()
    assert refusal(tmp_path / "events", content) == rule


NEWER = b"""% camera_integrator_name Prophesee
% date 2023-03-29 16:37:46
% evt 3.0
% format EVT3;height=720;width=1280;sensorname=IMX636
% generation 4.2
% geometry 1280x720
% plugin_name hal_plugin_imx636_evk4
% sensor_generation 4.2
% serial_number 00050423
% system_ID 49
"""


@pytest.mark.parametrize("end", [b"% end\n", b"% END\r\n", b""], ids=["end", "END", "no end"])
@pytest.mark.parametrize("without", [b"", b"% evt 3.0\n", b"% geometry 1280x720\n"], ids=["all", "no evt", "no geometry"])
def test_a_newer_camera_s_file_is_read_without_a_word(tmp_path: Path, end: bytes, without: bytes) -> None:
    """Headers as of an IMX636, whose stream has repeated marks, triggers, and counts of its own in vendors' words."""
    words = [
        *(evt3_high(7), evt3_low(0xFF0), 0xE01A, 0xF123, 0xF456, 0x7008),  # a vendor's word and what continues it
        *(evt3_row(10), evt3_base(1, 100), evt3_vector12(0b1), evt3_vector8(0b10), evt3_vector12(1 << 11)),
        *(evt3_high(7), evt3_low(0xFF8), 0xA001, 0xA000, evt3_event(0, 5)),  # a trigger's two edges
        *(evt3_high(8), evt3_low(2), evt3_row(719), evt3_event(1, 1279), evt3_vector8(1)),  # the base is kept
    ]
    path = tmp_path / "events.raw"
    path.write_bytes(packed("evt3", words, NEWER.replace(without, b"") + end))
    with open_recording(path) as file:
        t_us = 7 << 12 | 0xFF0
        assert rows_of(file.read().events) == [
            *((t_us, 100, 10, 1), (t_us, 113, 10, 1), (t_us, 131, 10, 1)),
            *((t_us + 8, 5, 10, 0), (t_us + 18, 1279, 719, 1), (t_us + 18, 132, 719, 1)),
        ]
        assert (file.sensor, file.left_out) == ((1280, 720), {})


def test_of_two_sensors_in_a_header_the_larger_is_taken_and_told(tmp_path: Path) -> None:
    path, words = tmp_path / "events.raw", [evt3_high(0), evt3_row(700), evt3_event(1, 1200)]
    for geometry, sensor in (("640x480", (1280, 720)), ("1920x1080", (1920, 1080))):
        header = f"% evt 3.0\n% format EVT3;height=720;width=1280\n% geometry {geometry}\n".encode()
        path.write_bytes(packed("evt3", words, header))
        with pytest.warns(RecordingWarning) as caught:
            recording = read_recording(path)
        assert (recording.width, recording.height) == sensor
        message = f"{path}: header: sensor {geometry} and 1280x720: the larger is taken"
        assert [str(each.message) for each in caught] == [message]


def test_what_a_header_says_is_told_and_a_long_one_is_read_to_its_end(tmp_path: Path) -> None:
    path = tmp_path / "events.raw"
    header = b"% Date 2023-03-29 16:37:46\n% evt 2.1\n% plugin_name hal_plugin_imx636_evk4\n% serial_number 00ca0009\n"
    path.write_bytes(packed("evt21", [evt21_high(1), evt21_event(1, 2, 3, 4, 1)], header + b"% geometry 1280x720\n% end\n"))
    with open_recording(path) as file:
        assert (file.format, file.sensor, file.t0_us) == ("Prophesee RAW, EVT 2.1", (1280, 720), 66)
        assert file.details == {
            "camera": "hal_plugin_imx636_evk4", "serial": "00ca0009", "date": "2023-03-29 16:37:46",
            "words": "2 of 64 bits", "order": "little",
        }  # fmt: skip
    for length in range(900, 1200):
        comment = b"% note " + b"x" * length + b"\n"
        path.write_bytes(packed("evt3", [evt3_high(1), evt3_row(2), evt3_event(1, 3)], comment + b"% evt 3.0\n"))
        assert len(read_recording(path).events) == 1
