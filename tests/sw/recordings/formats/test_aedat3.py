# SPDX-License-Identifier: Apache-2.0
"""AEDAT 3.1, packet by packet, from files laid out here according to the specification."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import RecordingError, RecordingWarning
from evcot.events import Events
from evcot.recordings.files import open_recording
from evcot.recordings.formats.aedat3 import Aedat3File, _Piece
from evcot.recordings.formats.source import BLOCK_EVENTS

from .fuzzing import fuzz
from .reading import Row, read, refusal, rows_of

SPECIAL, POLARITY, FRAME, IMU6 = 0, 1, 2, 3
TURN = 1 << 31


def header(*sources: str, lines: str = "#Format: RAW\r\n") -> bytes:
    named = "".join(f"#Source {source}\r\n" for source in sources or ("1: DVS128",))
    started = "#-Source 0: FX2\r\n#Start-Time: 2016-05-01 12:00:00 (TZ+0200)\r\n"
    return f"#!AER-DAT3.1\r\n{lines}{named}{started}#!END-HEADER\r\n".encode()


def polarity_event(t: int, x: int, y: int, p: int, valid: int = 1) -> bytes:
    return struct.pack("<Ii", x << 17 | y << 2 | p << 1 | valid, t)


def packet(
    events: list[bytes], kind: int = POLARITY, source: int = 1, turns: int = 0, time_at: int = 4, size: int | None = None
) -> bytes:
    size = size or (len(events[0]) if events else 8)
    return struct.pack("<hh6i", kind, source, size, time_at, turns, len(events), len(events), len(events)) + b"".join(events)


def polarity(rows: list[Row], **options: int) -> bytes:
    return packet([polarity_event(*row) for row in rows], **options)


def make_rows(count: int, start_us: int = 0) -> list[Row]:
    random = np.random.default_rng(41)
    columns = (start_us + np.sort(random.integers(0, 3 * count, count)), *random.integers(0, 128, (2, count)))
    return list(zip(*(column.tolist() for column in (*columns, random.integers(0, 2, count))), strict=True))


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "events.aedat"


def test_polarity_events_are_read_and_other_packets_passed_over(path: Path) -> None:
    expected = make_rows(1000)
    content = header() + polarity(expected[:10])
    content += packet([struct.pack("<Ii", 1 | 2 << 1, 5)], kind=SPECIAL) + packet([bytes(36)], kind=IMU6)
    content += packet([bytes(5000)], kind=FRAME, time_at=12) + packet([]) + polarity(expected[10:])
    assert read(path, content) == expected


def test_every_bit_of_an_event(path: Path) -> None:
    content = header("1: something new") + struct.pack("<hh6i", 1, 1, 8, 4, 0, 3, 3, 3)
    content += struct.pack("<IiIiIi", 0b1, 1, 0b11, 2, 0xFFFFFFFF, TURN - 1)
    assert read(path, content) == [(1, 0, 0, 0), (2, 0, 0, 1), (TURN - 1, 32767, 32767, 1)]


@pytest.mark.parametrize(
    ("source", "sensor"),
    [
        ("DVS128", (128, 128)),
        ("DAVIS240C", (240, 180)),
        ("DAVIS346 Red", (346, 260)),
        ("DAVIS640", (640, 480)),
        ("eDVS", (3, 5)),
    ],
)
def test_the_source_line_names_the_sensor_else_it_is_the_smallest(path: Path, source: str, sensor: tuple[int, int]) -> None:
    path.write_bytes(header(f"1: {source}") + polarity([(1, 2, 3, 1), (2, 0, 4, 0)]))
    with open_recording(path) as file:
        assert file.sensor == sensor
        assert file.details == {"source": source, "other sources": "none"}


def test_events_come_from_the_source_that_sends_the_first(path: Path) -> None:
    ours, others = make_rows(20), make_rows(9)
    content = header("0: File", "1: DVS128", "2: DAVIS240C") + packet([bytes(8)], kind=SPECIAL, source=0)
    content += polarity(ours[:7], source=2) + polarity(others, source=1) + polarity(ours[7:], source=2)
    assert read(path, content) == ours
    with open_recording(path) as file:
        assert file.sensor == (240, 180)
        assert file.details == {"source": "DAVIS240C", "other sources": "source 0 (File), source 1 (DVS128): not read"}


def test_time_has_31_bits_and_a_count_of_turns(path: Path) -> None:
    content = header() + polarity([(TURN - 2, 1, 1, 1)]) + polarity([(3, 1, 1, 0)], turns=1) + polarity([(5, 1, 1, 1)], turns=3)
    assert [row[0] for row in read(path, content)] == [TURN - 2, TURN + 3, 3 * TURN + 5]
    content = header() + polarity([(100, 1, 1, 1), (20_200, 1, 1, 1)]) + polarity([(0, 1, 1, 1)])
    assert refusal(path, content) == "event 2: t = 0 us follows t = 20200 us: time must not run back"


def test_events_marked_invalid_are_counted(path: Path) -> None:
    events = [polarity_event(1, 1, 1, 1), polarity_event(2, 2, 2, 0, valid=0), polarity_event(3, 3, 3, 1)]
    with pytest.warns(RecordingWarning, match="1 events left out: marked as not valid"):
        assert read(path, header() + packet(events)) == [(1, 1, 1, 1), (3, 3, 3, 1)]


def test_a_window_reads_no_packet_that_ends_before_it(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = make_rows(1000)
    path.write_bytes(header() + b"".join(polarity(expected[at : at + 100]) for at in range(0, 1000, 100)))
    decode, read_at = Aedat3File._decode, []

    def counting(self: Aedat3File, read: list[_Piece]) -> tuple[Events, RecordingError | None]:
        read_at.extend(piece.at for piece in read)
        return decode(self, read)

    source = Aedat3File(path)
    monkeypatch.setattr(Aedat3File, "_decode", counting)
    assert rows_of(Events.joined(source.blocks(expected[750][0]))) == expected[700:]
    assert len(read_at) == 3
    last = [row for row in expected[900:] if row[0] == expected[-1][0]]
    assert rows_of(Events.joined(source.blocks(expected[-1][0])))[-len(last) :] == last


def test_small_packets_come_in_blocks_and_a_large_one_too(path: Path) -> None:
    event = polarity_event(7, 1, 2, 1)
    path.write_bytes(header() + 5 * packet(1000 * [event]) + packet((BLOCK_EVENTS + 10) * [event]))
    assert [len(block) for block in Aedat3File(path).blocks()] == [5000 + BLOCK_EVENTS, 10]


def test_the_packets_before_a_damaged_one_are_given(path: Path) -> None:
    expected = make_rows(30)
    content = header() + polarity(expected[:10]) + polarity(expected[10:20]) + polarity(expected[20:])
    with pytest.warns(RecordingWarning, match=r"everything after 20 events left out: packet at byte \d+ goes beyond byte"):
        assert read(path, content[:-1], damage="skip") == expected[:20]


GOOD = polarity([(1, 1, 1, 1)])
START = len(header())


def packet_head(*fields: int) -> bytes:
    """Fields of a packet's header behind type and source."""
    return header() + struct.pack("<hh6i", 1, 1, *fields)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (header(), "holds no events"),
        (header().replace(b"3.1", b"3.0", 1), "AEDAT version '3.0': must be 3.1"),
        (header(lines="#Format: Serial-TS\r\n"), "header: format 'Serial-TS': must be RAW"),
        (header().replace(b"#Source", b"#Sauce"), "header: has no line #Source <ID>: <DESCRIPTION>"),
        (header()[:-1], "header line at byte 108: must start with # and end in a newline; is it cut off?"),
        (header()[:30], "header line at byte 28: must start with # and end in a newline; is it cut off?"),
        (header()[:28] + GOOD, "header line at byte 28: must start with # and end in a newline; is it cut off?"),
        (header() + GOOD[:20], f"ends within the header of a packet, at byte {START + 20}; is it cut off?"),
        (header() + GOOD[:-1],
         f"packet at byte {START} goes beyond byte {START + 35}, the file's end; is it cut off or damaged?"),
        (packet_head(8, 4, 0, 1 << 30, 1 << 30, 1),
         f"packet at byte {START} goes beyond byte {START + 28}, the file's end; is it cut off or damaged?"),
        (packet_head(8, 4, 0, 1, -1, 1),
         f"packet at byte {START}: 1 valid events of -1 of at most 1, 8 bytes each, after 0 turns of time: "
         "must not be negative, and valid <= events <= capacity"),
        (packet_head(0, 4, 0, 1, 1, 1),
         f"packet at byte {START}: 1 valid events of 1 of at most 1, 0 bytes each, after 0 turns of time: "
         "must not be negative, and valid <= events <= capacity"),
        (header() + polarity([(1, 1, 1, 1)], source=5),
         f"packet at byte {START}: type 1, source 5: must be 0 or more, and one of [1]"),
        (header() + packet([bytes(16)]),
         f"packet at byte {START}: polarity events of 16 bytes with their time at byte 4: must be of 8 with it at 4"),
        (header() + polarity([(1, 1, 1, 1), (-2, 1, 1, 1)]), f"event at byte {START + 36}: t = -2: must not be negative"),
        (header() + polarity([(1, 1, 1, 1)] * 9 + [(-2, 1, 1, 1)]),
         f"event at byte {START + 100}: t = -2: must not be negative"),
        (header() + polarity([(1, 1, 128, 1)]), "event 0: y = 128: must be below the sensor's 128"),
    ],
)  # fmt: skip
def test_what_is_no_whole_recording_is_refused_by_rule(path: Path, content: bytes, message: str) -> None:
    assert refusal(path, content) == message


def test_damage(path: Path) -> None:
    expected = make_rows(50)
    special = packet([struct.pack("<Ii", 3, 5)], kind=SPECIAL)
    content = header() + special + b"".join(polarity(expected[at : at + 25]) for at in (0, 25))
    outcomes = fuzz(path, content, seed=42)
    assert outcomes.refused > 2_000
    assert outcomes.lossy > 50
    assert fuzz(path, content, corruptions=2000, seed=43, damage="skip").lossy > 500
