# SPDX-License-Identifier: Apache-2.0
"""The table of packets in AEDAT 4.0: where it says nothing, or is not there, the packets are read all the same; where it says
something else, they are read with a warning; and it never makes a window lose events."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import lz4.frame
import numpy as np
import pytest
import zstandard

from evcot.errors import RecordingError, RecordingWarning
from evcot.events import Events
from evcot.recordings.files import open_recording, read_recording
from evcot.recordings.formats import aedat4
from evcot.recordings.formats.aedat4 import Aedat4File

from .reading import assert_same, refusal
from .test_aedat4 import event_buffer, make_events, stream_node

PACKETS, IN_EACH = 6, 50
COMPRESSIONS: dict[int, Callable[[bytes], bytes]] = {0: bytes, 1: lz4.frame.compress, 3: zstandard.compress}
ROW_FIELDS = ("at", "head", "count", "first", "last")
Row = dict[str, Any]


def flat_table(rows: list[Row]) -> bytes:
    """A FileDataTable with its length in front; a field of a row that is None is left out, which stands for zero."""
    tables = b""
    links = []
    begin = 28 + 4 * len(rows)
    for row in rows:
        fields, places = b"", []
        for name in ROW_FIELDS:
            value = row[name]
            places.append(0 if value is None else 4 + len(fields))
            if value is not None:
                fields += struct.pack("<ii", *value) if name == "head" else struct.pack("<q", value)
        vtable = struct.pack("<7H", 14, 4 + len(fields), *places)
        links.append(begin + len(tables) + len(vtable))
        tables += vtable + struct.pack("<i", len(vtable)) + fields
    offsets = b"".join(struct.pack("<I", link - (28 + 4 * i)) for i, link in enumerate(links))
    head = struct.pack("<I4s3H2xiII", 16, b"FTAB", 6, 8, 4, 8, 4, len(rows))
    buffer = head + offsets + tables
    return struct.pack("<I", len(buffer)) + buffer


def closed_file(
    parts: list[tuple[int, Events]], change: Callable[[list[Row]], list[Row]] = list, compression: int = 1, streams: str = ""
) -> tuple[bytes, int]:
    """A file of packets (stream, events) with a table, changed by `change`; and the table's place."""
    pack = COMPRESSIONS[compression]
    text = f"<dv><node name='outInfo'>{streams or stream_node(0)}</node></dv>".encode()
    vtable = struct.pack("<5H2x", 10, 20, 4, 8, 16)

    def header(table_at: int) -> bytes:
        head = struct.pack("<I4s", 8, b"IOHE") + struct.pack("<iiqI", -20, compression, table_at, 4 + len(vtable)) + vtable
        head += struct.pack("<I", len(text)) + text
        return b"#!AER-DAT4.0\r\n" + struct.pack("<I", len(head)) + head

    at = len(header(0))
    packets, rows = b"", []
    for stream, events in parts:
        packed = pack(event_buffer(events))
        times = (int(events.t_us[0]), int(events.t_us[-1])) if len(events) else (0, 0)
        place = at + len(packets) + 8
        rows.append({"at": place, "head": (stream, len(packed)), "count": len(events), "first": times[0], "last": times[1]})
        packets += struct.pack("<ii", stream, len(packed)) + packed
    table_at = at + len(packets)
    return header(table_at) + packets + pack(flat_table(change(rows))), table_at


EVENTS = make_events(PACKETS * IN_EACH)
PARTS = [(0, EVENTS[at : at + IN_EACH]) for at in range(0, len(EVENTS), IN_EACH)]


def every(**values: Any) -> Callable[[list[Row]], list[Row]]:
    return lambda rows: [row | values for row in rows]


def one(number: int, **values: Any) -> Callable[[list[Row]], list[Row]]:
    return lambda rows: [row | values if i == number else row for i, row in enumerate(rows)]


def packet_places(content: bytes) -> list[int]:
    """Where the packets begin, by following their lengths."""
    at = 18 + int.from_bytes(content[14:18], "little")
    (table_at,) = struct.unpack_from("<q", content, 34)
    places = []
    while at < table_at:
        places.append(at)
        at += 8 + struct.unpack_from("<i", content, at + 4)[0]
    return places


def assert_read_whole(path: Path) -> None:
    """All events, in each mode, and in windows; a warning is an error in these tests, unless it is expected."""
    for damage in ("refuse", "skip"):
        assert_same(read_recording(path, damage=damage).events, EVENTS)  # type: ignore[arg-type]
    for first in (1, IN_EACH - 1, 3 * IN_EACH, len(EVENTS) - 1):
        from_us = int(EVENTS.t_us[first] - EVENTS.t_us[0])
        wanted = EVENTS[int(np.searchsorted(EVENTS.t_us, EVENTS.t_us[first])) :]
        assert_same(read_recording(path, from_us=from_us).events, wanted)


NOTHING = {
    "whole": list,
    "zeros": every(count=0, first=0, last=0),
    "absent": every(count=None, first=None, last=None),
    "no counts": every(count=0),
    "absent counts": every(count=None),
    "no times": every(first=0, last=0),
    "one row of zeros": one(2, count=0, first=0, last=0),
    "one without times": one(2, first=0, last=0),
}


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("change", NOTHING)
def test_a_table_that_says_nothing_is_no_damage(tmp_path: Path, change: str, compression: int) -> None:
    path = tmp_path / "events.aedat4"
    path.write_bytes(closed_file(PARTS, NOTHING[change], compression)[0])
    assert_read_whole(path)
    kind = {"whole": "whole", "zeros": "without numbers of events and times"}.get(change)
    with open_recording(path) as file:
        assert kind is None or file.details["packet table"] == kind


def last(number: int) -> int:
    return int(PARTS[number][1].t_us[-1])


def first(number: int) -> int:
    return int(PARTS[number][1].t_us[0])


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize(
    ("change", "wrong", "stated"),
    [
        (one(2, count=49), [2], f"49 events from t = {first(2)} to {last(2)} us"),
        (one(3, first=first(3) - 7), [3], f"50 events from t = {first(3) - 7} to {last(3)} us"),
        (one(0, last=1 << 62), [0], f"50 events from t = {first(0)} to {1 << 62} us"),
        (every(count=17), [0, 1, 2, 3, 4, 5], f"17 events from t = {first(0)} to {last(0)} us"),
        (every(first=1, last=2), [0, 1, 2, 3, 4, 5], "50 events from t = 1 to 2 us"),
        (every(first=1 << 61, last=1 << 62), [0, 1, 2, 3, 4, 5], f"50 events from t = {1 << 61} to {1 << 62} us"),
        (lambda rows: rows[:4], [4, 5], "nothing"),
        (one(5, at=77), [5], "nothing"),
    ],
    ids=["count", "first", "last", "counts", "early", "late", "short", "lost"],
)
def test_a_table_that_disagrees_is_a_warning_and_the_packets_are_believed(
    tmp_path: Path, change: Any, wrong: list[int], stated: str, compression: int
) -> None:
    path = tmp_path / "events.aedat4"
    content, table_at = closed_file(PARTS, change, compression)
    path.write_bytes(content)
    packets, number = "a packet, which is" if len(wrong) == 1 else f"{len(wrong)} packets, which are", wrong[0]
    found = f"50 events from t = {first(number)} to {last(number)} us, {stated} by the table"
    place = packet_places(content)[number]
    message = f"packet table at byte {table_at}: differs from {packets} believed; packet at byte {place}: {found}"
    for damage in ("refuse", "skip"):
        with pytest.warns(RecordingWarning) as caught, open_recording(path, damage=damage) as file:  # type: ignore[arg-type]
            assert_same(file.read().events, EVENTS)
        assert [str(warning.message) for warning in caught] == [f"{path}: {message}"]
        assert (file.remarks, file.left_out) == ([message], {})


@pytest.mark.parametrize("change", [lambda rows: rows[::-1], one(1, head=(0, 3))], ids=["backwards", "length"])
def test_the_order_of_the_table_and_its_lengths_are_not_asked_for(tmp_path: Path, change: Any) -> None:
    path = tmp_path / "events.aedat4"
    path.write_bytes(closed_file(PARTS, change)[0])
    assert_read_whole(path)


@pytest.mark.filterwarnings("ignore::evcot.errors.RecordingWarning")
@pytest.mark.parametrize(
    "change",
    [
        every(first=1, last=2),
        every(first=1 << 61, last=1 << 62),
        lambda rows: [row | {"first": row["first"] - 500, "last": row["last"] - 500} for row in rows],
        lambda rows: [row | {"at": row["at"] + 4} for row in rows],
        lambda rows: [row | {"at": row["at"] - (1 << 40)} for row in rows],
        lambda rows: [row | {"at": 1 << 60} for row in rows],
        every(head=(0, -8)),
        every(head=(0, 1 << 30)),
        lambda rows: rows[2:],
        one(5, first=1, last=1),
    ],
)
def test_a_table_that_disagrees_loses_no_event_of_a_window(tmp_path: Path, change: Any) -> None:
    path = tmp_path / "events.aedat4"
    path.write_bytes(closed_file(PARTS, change)[0])
    assert_read_whole(path)


@pytest.mark.parametrize(
    ("change", "packet", "reads"), [(every(count=0), 4, 3), (one(5, count=0, first=0, last=0), 5, 2), (list, 0, 6)]
)
def test_a_table_without_some_numbers_still_finds_the_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, change: Any, packet: int, reads: int
) -> None:
    """One packet more is read than the window needs: the one before it."""
    path = tmp_path / "events.aedat4"
    path.write_bytes(closed_file(PARTS, change)[0])
    decoded: list[int] = []
    elements = aedat4._elements
    monkeypatch.setattr(aedat4, "_elements", lambda data: decoded.append(1) or elements(data))
    list(Aedat4File(path).blocks(first(packet)))
    assert len(decoded) == reads


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_a_table_that_cannot_be_read_is_a_warning(tmp_path: Path, compression: int) -> None:
    content, table_at = closed_file(PARTS, list, compression)
    path = tmp_path / "events.aedat4"
    begin = packet_places(content)[0]
    for damaged, what in (
        (content[:table_at], ""),
        (content[:-1], ""),
        (content[:table_at] + b"\xee" * 300, ""),
        (
            content[:34] + struct.pack("<q", -2) + content[42:table_at],
            f"must begin behind the header, at byte {begin} or later",
        ),
        (content[:34] + struct.pack("<q", 0) + content[42:table_at], f"must begin behind the header, at byte {begin} or later"),
    ):
        path.write_bytes(damaged)
        with pytest.warns(RecordingWarning) as caught:
            assert_same(read_recording(path).events, EVENTS)
        (message,) = {str(warning.message) for warning in caught}
        (place,) = struct.unpack_from("<q", damaged, 34)
        assert message.startswith(f"{path}: packet table at byte {place}: {what}")
        assert message.endswith("; the packets are read without it")
        with open_recording(path) as file:
            assert file.details["packet table"] == "cannot be read"


def test_a_file_that_ends_before_its_table_has_lost_something(tmp_path: Path) -> None:
    content, table_at = closed_file(PARTS)
    places = packet_places(content)
    path = tmp_path / "cut.aedat4"
    for length, whole in ((places[4], 4), (places[4] + 3, 4), (places[4] + 20, 4), (places[5], 5), (table_at - 1, 5)):
        path.write_bytes(content[:length])
        with pytest.raises(RecordingError, match=r"is it cut off"):
            read_recording(path)
        with pytest.warns(RecordingWarning, match=f"everything after {whole * IN_EACH} events left out: "):
            assert_same(read_recording(path, damage="skip").events, EVENTS[: whole * IN_EACH])


def test_packets_without_events_agree_with_zeros_and_differ_from_a_number(tmp_path: Path) -> None:
    path = tmp_path / "events.aedat4"
    parts = [*PARTS[:2], (0, Events.empty()), *PARTS[2:]]
    path.write_bytes(closed_file(parts)[0])
    assert_read_whole(path)
    content, table_at = closed_file(parts, one(2, count=3))
    path.write_bytes(content)
    place = packet_places(content)[2]
    message = f"table at byte {table_at}: differs from a packet, which is believed; packet at byte {place}: 0 events, 3"
    with pytest.warns(RecordingWarning, match=message):
        assert_same(read_recording(path).events, EVENTS)


def test_a_packet_beyond_what_is_unpacked_at_once_is_compared_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(aedat4, "_WHOLE_BYTES_MAX", 600)
    path = tmp_path / "events.aedat4"
    path.write_bytes(closed_file(PARTS)[0])
    assert_read_whole(path)
    for change in (one(3, count=51), one(3, first=5), one(3, last=5)):
        content, _ = closed_file(PARTS, change)
        path.write_bytes(content)
        with pytest.warns(
            RecordingWarning, match=f"differs from a packet, .* at byte {packet_places(content)[3]}: 50 events from"
        ):
            assert_same(read_recording(path).events, EVENTS)


def test_events_in_a_stream_of_others_are_missed_by_the_table(tmp_path: Path) -> None:
    content, _ = closed_file(PARTS, streams=stream_node(0) + stream_node(1, "TRIG"))
    place = packet_places(content)[3]
    content = content[:place] + struct.pack("<i", 1) + content[place + 4 :]
    assert refusal(tmp_path / "events.aedat4", content) == f"packet at byte {place}: holds events: stream 1 must not"
