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
from support.refusals import refused

from .fuzzing import fuzz
from .reading import assert_same, by_others, refusal, rows_of, shared, written_by_faery

SENSOR = (64, 48)
EPOCH_US = 1_718_925_184_590_631
FAERY_COMPRESSIONS = {"lz4": ("lz4", 1), "zstd": ("zstd", 3), "plain": None}


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


def by_faery(path: Path, events: Events, compression: str) -> Path:
    return written_by_faery(path, events, SENSOR, compression=FAERY_COMPRESSIONS[compression])


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
    elements = b"".join(struct.pack("<qhhB3x", *row) for row in rows_of(events))
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


@pytest.mark.parametrize("compression", FAERY_COMPRESSIONS)
def test_what_faery_wrote_is_read(tmp_path: Path, compression: str) -> None:
    events = make_events(20_000)
    recording = read_recording(by_faery(tmp_path / "events.aedat4", events, compression))
    assert_same(recording.events, events)
    assert (recording.width, recording.height) == SENSOR


@pytest.mark.parametrize(("name", "sensor"), [("hand_dvs128.aedat4", (128, 128)), ("traffic_outbound.aedat4", (346, 260))])
def test_a_camera_s_file_is_read_as_other_packages_read_it(name: str, sensor: tuple[int, int]) -> None:
    recording = read_recording(shared(name))
    assert (recording.width, recording.height) == sensor
    for reader in ("aedat", "faery"):
        assert_same(recording.events, by_others(reader, shared(name)))


@pytest.mark.parametrize("count", [1, 2, PACKET_EVENTS, 3 * PACKET_EVENTS + 7])
def test_what_is_written_is_read_here_and_by_others(tmp_path: Path, count: int) -> None:
    events, path = make_events(count), tmp_path / "events.aedat4"
    write_recording(Recording(events, *SENSOR), path)
    assert_same(read_recording(path).events, events)
    for reader in ("faery", "aedat", "eventcv"):
        assert_same(by_others(reader, path), events)
    assert faery.events_stream_from_file(path).dimensions() == SENSOR
    stream = {"type": "events", "width": SENSOR[0], "height": SENSOR[1]}
    assert pytest.importorskip("aedat").Decoder(path).id_to_stream() == {0: stream}


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
    events, path = make_events(10), tmp_path / "wide.aedat4"
    wide = Events(events.t_us, np.where(np.arange(10) == 7, 32_768, events.x).astype(np.uint16), events.y, events.p)
    with refused(RecordingError, f"{path}: event 7: x = 32768: must be at most 32767 in AEDAT4"):
        write_events(path, (40_000, 48), [wide[:4], wide[4:]])
    assert not path.exists()
    widest = Events(events.t_us, np.full(10, 32_767, np.uint16), np.full(10, 32_767, np.uint16), events.p)
    assert write_events(path, (32_768, 32_768), [widest]) == 10


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
    path, streams, good = tmp_path / "events.aedat4", stream_node(0) + stream_node(1, "TRIG"), event_buffer(make_events(3))
    first, second = (f"packet at byte {len(plain_file(streams, *before))}" for before in ((), [(0, good)]))
    for packets, said in (
        ([(7, good)], f"{first}: stream 7: must be one of [0, 1]"),
        ([(0, good), (1, good)], f"{second}: holds events: stream 1 must not"),
        ([(0, event_buffer(Events.empty(), b"TRIG"))], f"{first}: is marked b'TRIG': must be b'EVTS'"),
    ):
        assert refusal(path, plain_file(streams, *packets)) == said


def test_time_that_runs_back_is_named_by_its_event(tmp_path: Path) -> None:
    events = make_events(3)
    back = Events(np.array([100, 20_200, 150]), events.x, events.y, events.p)
    message = refusal(tmp_path / "back.aedat4", plain_file(stream_node(0), (0, event_buffer(back))))
    assert message == "event 2: t = 150 us follows t = 20200 us: time must not run back"


def changed(content: bytes, at: int, layout: str, value: int) -> bytes:
    return content[:at] + struct.pack(layout, value) + content[at + struct.calcsize(layout) :]


def test_a_packet_s_own_head_is_believed_and_its_damage_is_loss(tmp_path: Path) -> None:
    content = by_faery(tmp_path / "events.aedat4", make_events(3, start_us=1000), "plain").read_bytes()
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


GOOD = plain_file(stream_node(0))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (GOOD[:16], "ends within its header, at byte 16"),
        (GOOD[:40], "ends within its header, at byte 40"),
        (GOOD.replace(b"IOHE", b"IOHX"), "header: is marked b'IOHX': must be b'IOHE'"),
        (GOOD.replace(b"EVTS", b"\xffVTS"), "header: text at offset 101: must be UTF-8"),
        (plain_file(stream_node(0), compression=5), "header: compression 5: must be from 0 to 4"),
        (plain_file(stream_node(0, "TRIG")), "has no stream of events: its streams are ['TRIG']"),
        (plain_file(""), "has no stream of events: its streams are []"),
        (GOOD.replace(b">64<", b">6x<"), "header: sizeX, sizeY = ('6x', '48'): must be whole numbers"),
        (GOOD.replace(b">64<", b">00<"), "sensor 0x48: each side must be from 1 to 65536 pixels"),
        (plain_file(stream_node("a")), "header: description of streams: invalid literal for int() with base 10: 'a': "
         "must be XML with numbered nodes under outInfo"),
        (plain_file("<!ENTITY a 'aaaa'>" + stream_node(0)),
         "header: description of streams: must be XML without declarations"),
        (GOOD.replace(b"</dv>", b"</dw>"), "header: description of streams: mismatched tag: line 1, column 173: "
         "must be XML with numbered nodes under outInfo"),
        (GOOD, "holds no events"),
    ],
)  # fmt: skip
def test_a_damaged_header_is_refused_by_rule(tmp_path: Path, content: bytes, message: str) -> None:
    assert refusal(tmp_path / "file.aedat4", content) == message


def test_no_length_is_believed(tmp_path: Path) -> None:
    buffer, held = event_buffer(make_events(4)), len(event_buffer(make_events(4))) - 4
    count_at = len(buffer) - 4 * EVENT.itemsize - 4
    for damaged, said in (
        (
            changed(buffer, count_at, "<I", 2**32 - 1),
            f"4294967295 items of 16 bytes at offset 28: must lie within {held} bytes",
        ),
        (changed(buffer, 20, "<i", 100), f"offset -84: must lie within {held} bytes"),
        (changed(buffer, 0, "<I", 1 << 31), f"{held} bytes, {1 << 31} by its own length: must be the same"),
    ):
        message = refusal(tmp_path / "file.aedat4", plain_file(stream_node(0), (0, damaged)))
        assert message == f"packet at byte {len(GOOD)}: {said}"


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


def test_nothing_may_follow_a_packet_s_frame_and_its_size_is_not_believed(tmp_path: Path) -> None:
    buffer, path = event_buffer(make_events(100)), tmp_path / "file.aedat4"
    packed = lz4.frame.compress(buffer) + b"more"
    message = refusal(path, plain_file(stream_node(0), (0, packed), compression=1))
    assert message.endswith("4 bytes follow the LZ4 frame: must be none")
    frame = zstandard.ZstdCompressor(write_content_size=False).compress(buffer)
    huge = changed(frame, 5, "<B", 31 - 10 << 3)  # the window descriptor of 2 GiB
    message = refusal(path, plain_file(stream_node(0), (0, huge), compression=3))
    assert "is no Zstandard frame: Unable to decompress Zstandard data: Frame requires too much memory for decoding" in message


@pytest.mark.parametrize("compression", FAERY_COMPRESSIONS)
def test_damage_to_faery_s_files(tmp_path: Path, compression: str) -> None:
    content = by_faery(tmp_path / "whole.aedat4", make_events(50), compression).read_bytes()
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
