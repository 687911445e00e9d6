# SPDX-License-Identifier: Apache-2.0
"""AEDAT 4.0: every event of every packet, seeking to every time, and the claims of damaged files."""

from __future__ import annotations

import struct
from itertools import pairwise
from pathlib import Path
from typing import Any

import faery
import lz4.frame
import numpy as np
import pytest
import zstandard

from evcot.errors import RecordingError, RecordingWarning
from evcot.events import Events, Recording
from evcot.recordings.files import open_recording, read_recording, write_events, write_recording
from evcot.recordings.formats import aedat4
from evcot.recordings.formats.aedat4 import EVENT, Aedat4File
from evcot.recordings.formats.aedat4_sink import PACKET_EVENTS
from evcot.recordings.formats.packing import TooLarge
from evcot.recordings.formats.source import BLOCK_EVENTS
from shared import SHARED

from .fuzzing import fuzz

SENSOR = (64, 48)
EPOCH_US = 1_718_925_184_590_631
FAERY_COMPRESSIONS = {"lz4": ("lz4", 1), "zstd": ("zstd", 3), "plain": None}
FIELDS = ("t_us", "x", "y", "p")


def make_events(count: int, start_us: int = EPOCH_US) -> Events:
    random = np.random.default_rng(11)
    return Events(
        t_us=start_us + np.sort(random.integers(0, 3 * count + 1, count)),
        x=random.integers(0, SENSOR[0], count).astype(np.uint16),
        y=random.integers(0, SENSOR[1], count).astype(np.uint16),
        p=random.integers(0, 2, count).astype(np.uint8),
    )


def written(path: Path, events: Events) -> Path:
    write_events(path, SENSOR, [events])
    return path


def written_by_faery(path: Path, events: Events, compression: str = "lz4") -> Path:
    packet = np.zeros(len(events), faery.EVENTS_DTYPE)
    packet["t"], packet["x"], packet["y"], packet["on"] = events.t_us, events.x, events.y, events.p
    faery.events_stream_from_array(packet, SENSOR).to_file(path, compression=FAERY_COMPRESSIONS[compression])
    return path


def table_place(content: bytes) -> int:
    """Where the header keeps the table's place: the same in every file of evcot's and faery's."""
    return content.index(b"IOHE") - 4 + 36


def unclosed(content: bytes) -> bytes:
    """The file as its writer had left it before it wrote the table."""
    at = table_place(content)
    (table_at,) = struct.unpack_from("<q", content, at)
    return content[:at] + struct.pack("<q", -1) + content[at + 8 : table_at]


def event_buffer(events: Events, identifier: bytes = b"EVTS") -> bytes:
    """An EventPacket with its length in front, fields and vtables from the schema; another identifier for other elements."""
    elements = b"".join(struct.pack("<qhhB3x", *row) for row in zip(*(getattr(events, field) for field in FIELDS), strict=True))
    vtable = struct.pack("<3H", 6, 8, 4)
    table = struct.pack("<iI", len(vtable), 4)
    buffer = struct.pack("<I4s2x", 16, identifier) + vtable + table + struct.pack("<I", len(events)) + elements
    return struct.pack("<I", len(buffer)) + buffer


def stream_node(number: object, kind: str = "EVTS", info: str = "") -> str:
    return (
        f"<node name='{number}'><attr key='typeIdentifier'>{kind}</attr>"
        f"<node name='info'><attr key='sizeX'>64</attr><attr key='sizeY'>48</attr>{info}</node></node>"
    )


def plain_file(streams: str, *packets: tuple[int, bytes], compression: int = 0) -> bytes:
    """An unclosed file, its header laid out another way than evcot's or faery's: vtable behind the table, default left out."""
    text = f"<dv><node name='outInfo'>{streams}</node></dv>".encode()
    vtable = struct.pack("<5H", 10, 12, 4, 0, 8)
    header = struct.pack("<I4s", 8, b"IOHE") + struct.pack("<iiI", -12, compression, 4 + len(vtable)) + vtable
    header += struct.pack("<I", len(text)) + text
    body = b"".join(struct.pack("<ii", stream, len(buffer)) + buffer for stream, buffer in packets)
    return b"#!AER-DAT4.0\r\n" + struct.pack("<I", len(header)) + header + body


def assert_same(got: Events, wanted: Events) -> None:
    for field in FIELDS:
        values, expected = getattr(got, field), getattr(wanted, field)
        assert values.dtype == expected.dtype
        np.testing.assert_array_equal(values, expected)


def refusal(path: Path, content: bytes | None = None) -> str:
    """The line with which a file is refused, without its name."""
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(RecordingError) as caught:
        read_recording(path)
    return str(caught.value).removeprefix(f"{path}: ")


@pytest.mark.parametrize("compression", FAERY_COMPRESSIONS)
def test_what_faery_wrote_is_read(tmp_path: Path, compression: str) -> None:
    events = make_events(20_000)
    recording = read_recording(written_by_faery(tmp_path / "events.aedat4", events, compression))
    assert_same(recording.events, events)
    assert (recording.width, recording.height) == SENSOR


@pytest.mark.parametrize("name", ["hand_dvs128.aedat4", "traffic_outbound.aedat4"])
def test_a_camera_s_file_is_read_as_the_aedat_package_reads_it(name: str) -> None:
    aedat = pytest.importorskip("aedat")
    path = SHARED / name
    if not path.is_file():
        pytest.skip(f"{name} is not on this machine")
    expected = np.concatenate([packet["events"] for packet in aedat.Decoder(path) if "events" in packet])
    got = read_recording(path).events
    for values, field in zip((getattr(got, each) for each in FIELDS), ("t", "x", "y", "on"), strict=True):
        np.testing.assert_array_equal(values, expected[field].astype(values.dtype))


@pytest.mark.parametrize("count", [1, 2, PACKET_EVENTS, 3 * PACKET_EVENTS + 7])
def test_what_is_written_is_read_here_and_by_others(tmp_path: Path, count: int) -> None:
    events = make_events(count)
    path = tmp_path / "events.aedat4"
    write_recording(Recording(events, *SENSOR), path)
    assert_same(read_recording(path).events, events)

    stream = faery.events_stream_from_file(path)
    assert stream.dimensions() == SENSOR
    array = stream.to_array()
    assert_same(Events(array["t"].astype(np.int64), array["x"], array["y"], array["on"].astype(np.uint8)), events)

    aedat = pytest.importorskip("aedat")
    decoder = aedat.Decoder(path)
    assert decoder.id_to_stream() == {0: {"type": "events", "width": SENSOR[0], "height": SENSOR[1]}}
    array = np.concatenate([packet["events"] for packet in decoder])
    assert_same(Events(array["t"].astype(np.int64), array["x"], array["y"], array["on"].astype(np.uint8)), events)

    eventcv = pytest.importorskip("eventcv")
    loaded = eventcv.load(str(path))
    assert loaded.sensor_size == SENSOR
    x, y, t_us, p = loaded.numpy().T
    assert_same(Events(*(v.astype(getattr(events, f).dtype) for v, f in zip((t_us, x, y, p), FIELDS, strict=True))), events)


def test_small_blocks_make_the_same_file_as_one_large_one(tmp_path: Path) -> None:
    events = make_events(2 * PACKET_EVENTS)
    whole, parts = written(tmp_path / "whole.aedat4", events), tmp_path / "parts.aedat4"
    cuts = [0, 1, 10, PACKET_EVENTS - 1, PACKET_EVENTS + 5, len(events)]
    write_events(parts, SENSOR, [events[begin:end] for begin, end in pairwise(cuts)])
    assert parts.read_bytes() == whole.read_bytes()


def test_a_file_without_events_is_whole_but_no_recording(tmp_path: Path) -> None:
    path = tmp_path / "none.aedat4"
    assert write_events(path, SENSOR, []) == 0
    assert len(faery.events_stream_from_file(path).to_array()) == 0
    with open_recording(path) as file:
        assert file.sensor == SENSOR
    assert refusal(path) == "holds no events"


def test_an_address_beyond_the_format_s_15_bits_is_refused(tmp_path: Path) -> None:
    events = make_events(10)
    x = events.x.copy()
    x[7] = 32_768
    blocks = [events[:4], Events(events.t_us, x, events.y, events.p)[4:]]
    path = tmp_path / "wide.aedat4"
    with pytest.raises(RecordingError) as caught:
        write_events(path, (40_000, 48), blocks)
    assert str(caught.value) == f"{path}: event 7: x = 32768: must be at most 32767 in AEDAT4"
    assert not path.exists()


def test_a_window_reads_one_packet_before_it_to_check_the_table_and_none_before_that(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    events = make_events(10 * PACKET_EVENTS)
    path = written(tmp_path / "events.aedat4", events)
    source = Aedat4File(path)
    place = {int(at): row for row, at in enumerate(source._table.at)}  # type: ignore[union-attr]
    decoded: list[int] = []
    decode = Aedat4File._decode

    def counting(self: Aedat4File, read: Any) -> Any:
        decoded.extend(place[packet.at] for packet, _ in read)
        return decode(self, read)

    monkeypatch.setattr(Aedat4File, "_decode", counting)
    from_us = int(events.t_us[7 * PACKET_EVENTS + 5])
    got = Events.joined(source.blocks(from_us))
    assert sorted(decoded) == [6, 7, 8, 9]
    assert_same(got, events[7 * PACKET_EVENTS :])
    decoded.clear()
    assert_same(Events.joined(source.blocks(int(events.t_us[-1]))), events[9 * PACKET_EVENTS :])
    assert sorted(decoded) == [8, 9]
    decoded.clear()
    assert not len(Events.joined(source.blocks(int(events.t_us[-1]) + 1)))
    assert decoded == [9]


def test_a_packet_larger_than_a_block_comes_in_blocks(tmp_path: Path) -> None:
    events = make_events(BLOCK_EVENTS + 10)
    path = tmp_path / "large.aedat4"
    path.write_bytes(plain_file(stream_node(0), (0, event_buffer(events))))
    blocks = list(Aedat4File(path).blocks())
    assert [len(block) for block in blocks] == [BLOCK_EVENTS, 10]
    assert_same(Events.joined(blocks), events)


def test_a_file_that_was_never_closed_is_read_to_its_end(tmp_path: Path) -> None:
    events = make_events(2 * PACKET_EVENTS + 10)
    content = unclosed(written(tmp_path / "closed.aedat4", events).read_bytes())
    path = tmp_path / "unclosed.aedat4"
    path.write_bytes(content)
    with open_recording(path) as file:
        assert file.details["packet table"] == "none: the writer never closed the file"
        assert_same(file.read().events, events)
    path.write_bytes(content[:-1])
    assert refusal(path).endswith(f"goes beyond byte {len(content) - 1}, their end; is it cut off or damaged?")
    with pytest.warns(
        RecordingWarning, match=rf"everything after {2 * PACKET_EVENTS} events left out: packet at byte \d+ goes beyond"
    ):
        assert_same(read_recording(path, damage="skip").events, events[: 2 * PACKET_EVENTS])


def test_other_streams_are_passed_over_and_named(tmp_path: Path) -> None:
    events = make_events(30)
    path = tmp_path / "events.aedat4"
    trigger = event_buffer(Events.empty(), b"TRIG")
    path.write_bytes(
        plain_file(
            stream_node(4, "TRIG") + stream_node(2, info="<attr key='source'>DVS128_0279</attr>") + stream_node(3),
            (4, trigger),
            (2, event_buffer(events[:10])),
            (3, event_buffer(events[:20])),
            (4, trigger),
            (2, event_buffer(events[10:])),
        )
    )
    with open_recording(path) as file:
        assert_same(file.read().events, events)
        assert file.details == {
            "source": "DVS128_0279",
            "compression": "none",
            "packet table": "none: the writer never closed the file",
            "other streams": "stream 4 (TRIG), stream 3 (EVTS): not read",
        }


def test_a_packet_of_another_stream_is_not_lost_in_silence(tmp_path: Path) -> None:
    path = tmp_path / "events.aedat4"
    streams = stream_node(0) + stream_node(1, "TRIG")
    good = (0, event_buffer(make_events(3)))
    first = len(plain_file(streams))
    second = len(plain_file(streams, good))
    assert refusal(path, plain_file(streams, (7, good[1]))) == f"packet at byte {first}: stream 7: must be one of [0, 1]"
    assert refusal(path, plain_file(streams, good, (1, good[1]))) == (
        f"packet at byte {second}: holds events: stream 1 must not"
    )
    assert refusal(path, plain_file(streams, (0, event_buffer(Events.empty(), b"TRIG")))) == (
        f"packet at byte {first}: is marked b'TRIG': must be b'EVTS'"
    )


def test_time_that_runs_back_is_named_by_its_event(tmp_path: Path) -> None:
    events = make_events(3)
    back = Events(np.array([100, 20_200, 150]), events.x, events.y, events.p)
    message = refusal(tmp_path / "back.aedat4", plain_file(stream_node(0), (0, event_buffer(back))))
    assert message == "event 2: t = 150 us follows t = 20200 us: time must not run back"


def changed(content: bytes, at: int, layout: str, value: int) -> bytes:
    return content[:at] + struct.pack(layout, value) + content[at + struct.calcsize(layout) :]


def test_a_packet_s_own_head_is_believed_and_its_damage_is_loss(tmp_path: Path) -> None:
    content = written_by_faery(tmp_path / "events.aedat4", make_events(3, start_us=1000), "plain").read_bytes()
    (table_at,) = struct.unpack_from("<q", content, table_place(content))
    packet = content.index(b"EVTS", content.index(b"</dv>")) - 16
    path = tmp_path / "changed.aedat4"
    for damaged, message in (
        (changed(content, packet, "<i", 1), f"packet at byte {packet}: stream 1: must be one of [0]"),
        (changed(content, packet + 4, "<i", 8), f"packet at byte {packet}: "),
        (
            changed(content, packet + 4, "<i", 1 << 20),
            f"packet at byte {packet} goes beyond byte {table_at}, their end; is it cut off or damaged?",
        ),
    ):
        assert refusal(path, damaged).startswith(message)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (plain_file(stream_node(0))[:16], "ends within its header, at byte 16"),
        (plain_file(stream_node(0))[:40], "ends within its header, at byte 40"),
        (plain_file(stream_node(0)).replace(b"IOHE", b"IOHX"), "header: is marked b'IOHX': must be b'IOHE'"),
        (plain_file(stream_node(0)).replace(b"EVTS", b"\xffVTS"), "header: text at offset 101: must be UTF-8"),
        (plain_file(stream_node(0), compression=5), "header: compression 5: must be from 0 to 4"),
        (plain_file(stream_node(0, "TRIG")), "has no stream of events: its streams are ['TRIG']"),
        (plain_file(""), "has no stream of events: its streams are []"),
        (
            plain_file(stream_node(0)).replace(b">64<", b">6x<"),
            "header: sizeX, sizeY = ('6x', '48'): must be whole numbers",
        ),
        (plain_file(stream_node(0)).replace(b">64<", b">00<"), "sensor 0x48: each side must be from 1 to 65536 pixels"),
        (
            plain_file(stream_node("a")),
            "header: description of streams: invalid literal for int() with base 10: 'a': "
            "must be XML with numbered nodes under outInfo",
        ),
        (
            plain_file("<!ENTITY a 'aaaa'>" + stream_node(0)),
            "header: description of streams: must be XML without declarations",
        ),
        (
            plain_file(stream_node(0)).replace(b"</dv>", b"</dw>"),
            "header: description of streams: mismatched tag: line 1, column 173: must be XML with numbered nodes under outInfo",
        ),
        (plain_file(stream_node(0)), "holds no events"),
    ],
)
def test_a_damaged_header_is_refused_by_rule(tmp_path: Path, content: bytes, message: str) -> None:
    assert refusal(tmp_path / "file.aedat4", content) == message


def test_no_length_is_believed(tmp_path: Path) -> None:
    path = tmp_path / "file.aedat4"
    buffer = event_buffer(make_events(4))
    head = len(plain_file(stream_node(0)))
    count_at = len(buffer) - 4 * EVENT.itemsize - 4
    many = buffer[:count_at] + b"\xff\xff\xff\xff" + buffer[count_at + 4 :]
    assert refusal(path, plain_file(stream_node(0), (0, many))) == (
        f"packet at byte {head}: 4294967295 items of 16 bytes at offset 28: must lie within {len(buffer) - 4} bytes"
    )
    assert refusal(path, plain_file(stream_node(0), (0, changed(buffer, 20, "<i", 100)))) == (
        f"packet at byte {head}: offset -84: must lie within {len(buffer) - 4} bytes"
    )
    short = struct.pack("<I", 1 << 31) + buffer[4:]
    assert refusal(path, plain_file(stream_node(0), (0, short))) == (
        f"packet at byte {head}: {len(buffer) - 4} bytes, {1 << 31} by its own length: must be the same"
    )


@pytest.mark.parametrize("compression", ["LZ4", "Zstandard"])
def test_no_more_than_the_bound_is_unpacked_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compression: str) -> None:
    buffer = event_buffer(make_events(1000))
    packed = lz4.frame.compress(buffer) if compression == "LZ4" else zstandard.compress(buffer)
    content = plain_file(stream_node(0), (0, packed), compression=1 if compression == "LZ4" else 3)
    path = tmp_path / "file.aedat4"
    path.write_bytes(content)
    assert_same(read_recording(path).events, make_events(1000))
    # A packet beyond what is unpacked at once comes piece by piece, and is the same.
    whole: list[TooLarge] = []
    monkeypatch.setattr(aedat4, "_WHOLE_BYTES_MAX", len(buffer) - 1)
    monkeypatch.setattr(TooLarge, "__init__", lambda self, *_: whole.append(self))
    assert_same(read_recording(path).events, make_events(1000))
    assert whole


def test_nothing_may_follow_a_packet_s_frame(tmp_path: Path) -> None:
    packed = lz4.frame.compress(event_buffer(make_events(10))) + b"more"
    message = refusal(tmp_path / "file.aedat4", plain_file(stream_node(0), (0, packed), compression=1))
    assert message.endswith("4 bytes follow the LZ4 frame: must be none")


def test_a_zstandard_frame_that_claims_a_huge_size_is_not_believed(tmp_path: Path) -> None:
    buffer = event_buffer(make_events(100))
    frame = zstandard.ZstdCompressor(write_content_size=False).compress(buffer)
    window = 31 - 10 << 3  # the window descriptor of 2 GiB
    huge = frame[:5] + bytes([window]) + frame[6:]
    message = refusal(tmp_path / "file.aedat4", plain_file(stream_node(0), (0, huge), compression=3))
    assert "is no Zstandard frame: Unable to decompress Zstandard data: Frame requires too much memory for decoding" in message


@pytest.mark.parametrize("compression", FAERY_COMPRESSIONS)
def test_damage_to_faery_s_files(tmp_path: Path, compression: str) -> None:
    content = written_by_faery(tmp_path / "whole.aedat4", make_events(50), compression).read_bytes()
    (table_at,) = struct.unpack_from("<q", content, table_place(content))
    outcomes = fuzz(tmp_path / "cut", content, corruptions=0, seed=20)
    assert (outcomes.refused, outcomes.read) == (table_at, len(content) - table_at)  # every cut, but of the table
    fuzz(tmp_path / "damaged", content, cuts=False, corruptions=300, seed=21)


def test_damage_to_evcot_s_files(tmp_path: Path) -> None:
    content = written(tmp_path / "whole.aedat4", make_events(50)).read_bytes()
    assert fuzz(tmp_path / "damaged", content, seed=22).refused > 3_200


@pytest.mark.parametrize("damage", ["refuse", "skip"])
def test_damage_to_unclosed_files(tmp_path: Path, damage: str) -> None:
    content = plain_file(stream_node(0), *[(0, event_buffer(make_events(50)[at : at + 10])) for at in range(0, 50, 10)])
    outcomes = fuzz(tmp_path / "damaged", content, corruptions=1000, seed=23, damage=damage)  # type: ignore[arg-type]
    assert (outcomes.lossy > 0) == (damage == "skip")
