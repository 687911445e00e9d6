# SPDX-License-Identifier: Apache-2.0
"""ROS bags, written here with the library rosbags, are read event by event as by that library."""

from __future__ import annotations

import itertools
import sqlite3
from collections.abc import Iterator
from contextlib import nullcontext
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from evcot.errors import RecordingError, RecordingWarning
from evcot.events import Events
from evcot.recordings.files import open_recording, read_recording
from evcot.recordings.formats import ros
from evcot.recordings.formats.ros_messages import _Fields, read_stamped
from support.refusals import refused

from .fuzzing import cut_lengths, fuzz, sample_of
from .reading import Row, assert_same, by_others, refusal, rows_of
from .reference_evt import evt3_base, evt3_event, evt3_high, evt3_low, evt3_row, evt3_vector12, reference

WIDTH, HEIGHT = 64, 48
COUNT = 100
RANDOM = np.random.default_rng(17)
T_NS = 1_718_925_184 * 10**9 + np.sort(RANDOM.integers(0, 10**8, COUNT))
X, Y, P = (RANDOM.integers(0, limit, COUNT) for limit in (WIDTH, HEIGHT, 2))
CORRUPTIONS = sample_of(10_000, 200)

DVS, PACKET = "dvs_msgs/msg/EventArray", "event_camera_msgs/msg/EventPacket"
EVENT_FIELDS = "uint16 x\nuint16 y\n{time} ts\nbool polarity\n"
DVS_FIELDS = "std_msgs/Header header\nuint32 height\nuint32 width\ndvs_msgs/Event[] events\n"
PACKET_FIELDS = (
    "std_msgs/Header header\nuint32 height\nuint32 width\nuint64 seq\nuint64 time_base\n"
    "string encoding\nbool is_bigendian\nuint8[] events\n"
)
KINDS = ["ros1", "ros1-bz2", "ros1-lz4", "ros2-sqlite3", "ros2-mcap", "sqlite3", "mcap"]

Message = tuple[str, str, int, Any]


class Maker:
    """Makes messages of one generation, and bags of them."""

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self.is_ros1 = kind.startswith("ros1")
        self.store = get_typestore(Stores.ROS1_NOETIC if self.is_ros1 else Stores.ROS2_HUMBLE)
        time = "time" if self.is_ros1 else "builtin_interfaces/Time"
        self.store.register(get_types_from_msg(EVENT_FIELDS.format(time=time), "dvs_msgs/msg/Event"))
        self.store.register(get_types_from_msg(DVS_FIELDS, DVS))
        self.store.register(get_types_from_msg(PACKET_FIELDS, PACKET))

    def header(self, name: str) -> Any:
        time = self.store.types["builtin_interfaces/msg/Time"](7, 8)
        header = self.store.types["std_msgs/msg/Header"]
        return header(3, time, name) if self.is_ros1 else header(time, name)

    def array(self, begin: int, end: int, frame: str = "camera", sensor: tuple[int, int] = (WIDTH, HEIGHT)) -> Any:
        types = self.store.types
        time, event = types["builtin_interfaces/msg/Time"], types["dvs_msgs/msg/Event"]
        events = [
            event(int(X[i]), int(Y[i]), time(int(T_NS[i] // 10**9), int(T_NS[i] % 10**9)), bool(P[i]))
            for i in range(begin, end)
        ]
        return types[DVS](self.header(frame), sensor[1], sensor[0], events)

    def arrays(self, topic: str = "/dvs/events", step: int = 17) -> Iterator[Message]:
        """Messages of 17 events, each with a name of another length before it; one is empty."""
        yield topic, DVS, int(T_NS[0]), self.array(0, 0)
        for number, begin in enumerate(range(0, COUNT, step)):
            end = min(begin + step, COUNT)
            yield topic, DVS, int(T_NS[end - 1]), self.array(begin, end, "c" * number)

    def packets(self, payloads: list[bytes], encoding: str, *, base_ns: int = 0, big: bool = False) -> Iterator[Message]:
        kind = self.store.types[PACKET]
        for number, payload in enumerate(payloads):
            content = np.frombuffer(payload, np.uint8)
            header = self.header("c" * number)
            yield "/camera/events", PACKET, 1000 + number, kind(header, HEIGHT, WIDTH, number, base_ns, encoding, big, content)

    def write(self, directory: Path, messages: Iterator[Message]) -> Path:
        if self.is_ros1:
            path = directory / "events.bag"
            writer: Any = Writer1(path)
            if self.kind != "ros1":
                writer.set_compression(Writer1.CompressionFormat[self.kind.removeprefix("ros1-").upper()])
        else:
            path = directory / "bag"
            plugin = StoragePlugin.MCAP if "mcap" in self.kind else StoragePlugin.SQLITE3
            writer = Writer2(path, version=9, storage_plugin=plugin)
        connections: dict[str, Any] = {}
        serialize = self.store.serialize_ros1 if self.is_ros1 else self.store.serialize_cdr
        with writer:
            for topic, kind, time_ns, message in messages:
                if topic not in connections:
                    connections[topic] = writer.add_connection(topic, kind, typestore=self.store)
                writer.write(connections[topic], time_ns, serialize(message, kind))
        if self.is_ros1 or self.kind.startswith("ros2"):
            return path
        return next(each for each in path.iterdir() if each.name != "metadata.yaml").rename(directory / "bare.bin")

    def string(self, text: str) -> Any:
        return self.store.types["std_msgs/msg/String"](text)


def assert_events(events: Events, begin: int = 0, end: int = COUNT) -> None:
    assert_same(events, [column[begin:end] for column in (T_NS // 1000, X, Y, P)])


@pytest.mark.parametrize("kind", KINDS)
def test_stamped_events_and_every_window_of_them_are_read_from_every_kind_of_bag(
    tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    maker = Maker(kind)
    path = maker.write(tmp_path, maker.arrays())
    with open_recording(path) as file:
        assert_events(file.read().events)
        assert file.sensor == (WIDTH, HEIGHT)
        assert file.details == {"topic": "/dvs/events"}
    monkeypatch.setattr(ros, "BLOCK_EVENTS", 20)
    t_us = T_NS // 1000
    for at in (1, 17, 50, COUNT - 1):
        assert_events(read_recording(path, from_us=int(t_us[at] - t_us[0])).events, at)


@pytest.mark.parametrize("kind", ["ros1", "ros2-sqlite3", "ros2-mcap"])
def test_the_library_s_own_deserialisation_agrees_and_another_reader(tmp_path: Path, kind: str) -> None:
    maker = Maker(kind)
    path = maker.write(tmp_path, maker.arrays())
    with AnyReader([path], default_typestore=maker.store) as reader:
        rows = [
            (event.ts.sec * 10**6 + event.ts.nanosec // 1000, event.x, event.y, int(event.polarity))
            for connection, _, data in reader.messages()
            for event in reader.deserialize(data, connection.msgtype).events
        ]
    events = read_recording(path).events
    assert rows_of(events) == rows
    if kind == "ros1":
        assert_same(by_others("eventcv", path, topic="/dvs/events"), events)


def test_messages_that_end_before_the_window_are_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    maker = Maker("ros1")
    converted: list[int] = []
    events_of = ros.events_of
    monkeypatch.setattr(ros, "events_of", lambda batch: converted.extend(map(len, batch)) or events_of(batch))
    with open_recording(maker.write(tmp_path, maker.arrays())) as file:
        _ = file.t0_us
        converted.clear()
        assert_events(file.read(int(T_NS[60] // 1000 - T_NS[0] // 1000)).events, 60)
    assert converted == [17, 17, 15]


def evt3_words() -> tuple[np.ndarray[Any, Any], list[tuple[int, int, int, int]]]:
    words: list[int] = []
    for number in range(40):
        words += [evt3_high(number // 4), evt3_low(number * 100), evt3_row(number), evt3_event(number % 2, number)]
        words += [evt3_base(1, number), evt3_vector12(0b100000000101)]
    return np.array(words, "<u2"), reference("evt3", words).rows


@pytest.mark.parametrize("big", [False, True], ids=["little", "big"])
@pytest.mark.parametrize("kind", ["ros1", "mcap", "sqlite3"])
def test_packets_of_evt3_are_one_stream_wherever_they_are_cut(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, big: bool
) -> None:
    monkeypatch.setattr(ros, "BLOCK_EVENTS", 3)
    words, wanted = evt3_words()
    content = words.astype(">u2" if big else "<u2").tobytes()
    cuts = [0, 2, 14, 14, 16, 100, 102, len(content)]
    payloads = [content[begin:end] for begin, end in pairwise(cuts)]
    maker = Maker(kind)
    with open_recording(maker.write(tmp_path, maker.packets(payloads, "evt3", big=big))) as file:
        events = file.read().events
        assert file.details == {"topic": "/camera/events", "encoding": "evt3"}
    assert rows_of(events) == wanted


def test_events_before_the_first_time_mark_are_counted(tmp_path: Path) -> None:
    maker = Maker("ros1")
    words = np.array([evt3_row(1), evt3_event(1, 2), evt3_high(1), evt3_event(0, 3)], "<u2")
    with pytest.warns(RecordingWarning, match="1 events left out: they precede any time mark or address"):
        assert read_recording(maker.write(tmp_path, maker.packets([words.tobytes()], "evt3"))).events.x.tolist() == [3]


@pytest.mark.parametrize("kind", ["ros1", "mcap"])
def test_mono_and_libcaer_packets_count_from_their_time_base(tmp_path: Path, kind: str) -> None:
    since_ns = (T_NS - T_NS[0]).astype("u8")
    words = P.astype("u8") << np.uint64(63) | Y.astype("u8") << np.uint64(48) | X.astype("u8") << np.uint64(32) | since_ns
    start_us = (1 << 31) - 50_000  # of libcaer, whose 31 bits wrap around
    pairs = np.empty((COUNT, 2), "<u4")
    pairs[:, 0] = X << 17 | Y << 2 | P << 1 | 1
    pairs[:, 1] = (start_us + T_NS // 1000 - T_NS[0] // 1000) & 0x7FFFFFFF
    assert pairs[0, 1] > pairs[-1, 1]
    maker = Maker(kind)
    for name, content, base_ns in (
        ("mono", words, int(T_NS[0])),
        ("libcaer", pairs, int(T_NS[0]) // 1000 * 1000 - start_us * 1000),
    ):
        (tmp_path / name).mkdir()
        path = maker.write(tmp_path / name, maker.packets([content.tobytes()], name, base_ns=base_ns))
        assert_events(read_recording(path).events)


# libcaer_cmp, by its table of words: what a word's upper four bits say about the lower twelve.
CMP_TIME_HIGH, CMP_TIME_LOW, CMP_X, CMP_Y, CMP_BASE_Y, CMP_VECTOR_8 = range(6)


def cmp_words(rows: list[Row], base_us: int) -> list[int]:
    """Encode (t, x, y, p), as libcaer_driver does it: of the time, only what changes; of a column, eight rows at a time."""
    words: list[int] = []
    high = low = 0
    column = -1
    for i, (t_us, x, y, p) in enumerate(rows):
        since = t_us - base_us
        if since >> 12 & 15 != high:
            high = since >> 12 & 15
            words.append(CMP_TIME_HIGH << 12 | high)
        if since & 4095 != low:
            low = since & 4095
            words.append(CMP_TIME_LOW << 12 | low)
        if x != column:
            column = x
            words.append(CMP_X << 12 | x)
        group = [row for row in rows if row[:2] == (t_us, x) and (row[2] >> 3, row[3]) == (y >> 3, p)]
        if group[0] != rows[i]:
            continue
        if len(group) == 1:
            words.append(CMP_Y << 12 | p << 11 | y)
        else:
            words.append(CMP_BASE_Y << 12 | p << 11 | y & ~7)
            words.append(CMP_VECTOR_8 << 12 | sum(1 << (row[2] & 7) for row in group))
    return words


def cmp_rows() -> list[Row]:
    """Columns of events over 0.3 s, in the order in which the encoding holds them; pixels of a column next to each other."""
    random = np.random.default_rng(29)
    rows: list[Row] = []
    for t_us in 1_702_669_729_854_452 + np.cumsum(random.integers(0, 3000, 200)):
        x = int(random.integers(0, WIDTH))
        y = random.choice(HEIGHT, int(random.integers(1, 12)), replace=False)
        rows += [
            (int(t_us), x, int(each), int(random.integers(0, 2)) if each < 8 else int(each >> 3 & 1)) for each in sorted(y)
        ]
    order = {row[:2]: i for i, row in reversed(list(enumerate(rows)))}
    # Within a column, rows by groups of eight and polarity, in the order of the first of each group.
    groups = {(row[:2], row[2] >> 3, row[3]): i for i, row in reversed(list(enumerate(rows)))}
    rows.sort(key=lambda row: (order[row[:2]], groups[row[:2], row[2] >> 3, row[3]], row[2]))
    return list(dict.fromkeys(rows))


@pytest.mark.parametrize("block_events", [1, 9, 1 << 15])
@pytest.mark.parametrize("big", [False, True], ids=["little", "big"])
@pytest.mark.parametrize("kind", ["ros1", "mcap"])
def test_libcaer_cmp_packets_count_from_their_time_base_and_hold_columns(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, big: bool, block_events: int
) -> None:
    monkeypatch.setattr(ros, "BLOCK_EVENTS", block_events)
    rows = cmp_rows()
    assert rows[-1][0] - rows[0][0] > 4 << 16  # the four bits of the upper part wrap around, many times
    maker = Maker(kind)

    def messages() -> Iterator[Message]:
        for begin in (0, 300, 700):
            part = rows[begin : {0: 300, 300: 700, 700: len(rows)}[begin]]
            words = np.array(cmp_words(part, part[0][0]), ">u2" if big else "<u2")
            yield from maker.packets([words.tobytes()], "libcaer_cmp", base_ns=1000 * part[0][0] + 999, big=big)

    with open_recording(maker.write(tmp_path, messages())) as file:
        assert rows_of(file.read().events) == rows
        assert file.details == {"topic": "/camera/events", "encoding": "libcaer_cmp"}


def test_libcaer_cmp_by_hand(tmp_path: Path) -> None:
    """Worked out from the published decoder: two vectors after one base are one column; the upper time keeps the lower."""
    words = [
        *(CMP_X << 12 | 5, CMP_Y << 12 | 1 << 11 | 7),  # (0, 5, 7, 1)
        *(CMP_TIME_LOW << 12 | 30, CMP_BASE_Y << 12 | 8, CMP_VECTOR_8 << 12 | 0b1000_0001),  # (30, 5, 8 and 15, 0)
        CMP_VECTOR_8 << 12 | 0xF00 | 0b10,  # (30, 5, 17, 0), with four bits that mean nothing
        *(CMP_TIME_HIGH << 12 | 2, CMP_X << 12 | 1 << 11 | 6, CMP_Y << 12 | 9),  # (2 << 12 | 30, 6, 9, 0), and one such bit
        *(CMP_TIME_HIGH << 12 | 1, CMP_Y << 12 | 10),  # a little earlier: no turn of the time
    ]
    maker = Maker("mcap")
    content = np.array(words, "<u2").tobytes()
    path = maker.write(tmp_path, maker.packets([content], "libcaer_cmp", base_ns=10**15 + 1))
    t0_us = 10**12
    with pytest.warns(RecordingWarning, match="1 events run back in time, by at most 4096 us"):
        rows = rows_of(read_recording(path).events)
    assert rows == [
        *((t0_us, 5, 7, 1), (t0_us + 30, 5, 8, 0), (t0_us + 30, 5, 15, 0), (t0_us + 30, 5, 17, 0)),
        *((t0_us + 8222, 6, 9, 0), (t0_us + 8222, 6, 10, 0)),
    ]


def test_what_libcaer_cmp_does_not_define_is_counted(tmp_path: Path) -> None:
    maker = Maker("mcap")
    first = [CMP_Y << 12 | 1, CMP_X << 12 | 2, CMP_VECTOR_8 << 12 | 7, 6 << 12, 15 << 12, CMP_Y << 12 | 3]
    second = [CMP_Y << 12 | 4, CMP_BASE_Y << 12, CMP_VECTOR_8 << 12 | 1, CMP_X << 12 | 5, CMP_Y << 12 | 6]  # begins anew
    payloads = [np.array(words, "<u2").tobytes() for words in (first, second)]
    path = maker.write(tmp_path, maker.packets(payloads, "libcaer_cmp"))
    with pytest.warns(RecordingWarning) as caught:
        assert rows_of(read_recording(path).events) == [(0, 2, 3, 0), (0, 5, 6, 0)]
    assert [str(each.message).removeprefix(f"{path}: ") for each in caught] == [
        "6 events left out: they precede any address",
        "2 events left out: words of a type that libcaer_cmp does not define",
    ]
    (tmp_path / "odd").mkdir()
    path = maker.write(tmp_path / "odd", maker.packets([payloads[1] + b"\1"], "libcaer_cmp"))
    assert refusal(path) == "has 11 bytes of events: must be a multiple of 2"


def test_libcaer_cmp_far_down_a_column_is_outside_and_never_wraps_around(tmp_path: Path) -> None:
    maker = Maker("mcap")
    words = [CMP_X << 12, CMP_Y << 12, CMP_BASE_Y << 12, *[CMP_VECTOR_8 << 12] * 8190, CMP_VECTOR_8 << 12 | 1]
    path = maker.write(tmp_path, maker.packets([np.array(words, "<u2").tobytes()], "libcaer_cmp"))
    assert refusal(path) == f"event 1: y = {1 << 15}: must be below the sensor's {HEIGHT}"


@pytest.mark.parametrize("kind", KINDS)
def test_the_first_topic_with_events_is_read_and_the_others_are_named(tmp_path: Path, kind: str) -> None:
    maker = Maker(kind)

    def messages() -> Iterator[Message]:
        yield "/a", "std_msgs/msg/String", int(T_NS[0]), maker.string("text")
        yield "/b", DVS, int(T_NS[0]), maker.array(0, 0)
        yield "/c", DVS, int(T_NS[0]), maker.array(0, 3)
        yield from maker.arrays("/d")

    with open_recording(maker.write(tmp_path, messages())) as file:
        assert_events(file.read().events, 0, 3)
        assert file.details == {"topic": "/c", "also holds": "/b, /d"}


def test_what_is_no_bag_of_events_is_refused(tmp_path: Path) -> None:
    maker = Maker("mcap")
    for number, (messages, said) in enumerate((
        (iter([("/a", "std_msgs/msg/String", 1, maker.string("text"))]),
         "EventPacket, event_array_msgs/EventArray): holds std_msgs/String"),
        (maker.packets([b"abcd"], "zip"),
         "topic /camera/events, message 0: encoding 'zip': must be one of evt3, libcaer_cmp, mono, libcaer"),
        (maker.packets([b""], "evt3"), "holds no events in /camera/events"),
    )):  # fmt: skip
        (tmp_path / str(number)).mkdir()
        assert refusal(maker.write(tmp_path / str(number), messages)).endswith(said)
    assert refusal(tmp_path / "a.db3", b"SQLite format 3\0").startswith("cannot be opened as a ROS 2 bag: ")


@pytest.mark.parametrize("kind", ["ros1", "mcap"])
def test_messages_that_break_a_rule_are_named(tmp_path: Path, kind: str) -> None:
    maker = Maker(kind)
    broken = maker.array(5, 9)
    broken.events[2].ts.nanosec = 10**9
    for name, arrays, said in (
        ("time", [broken], "event 2 of its message: nanoseconds = 1000000000: must be below 10^9"),
        (
            "sensor", [maker.array(0, 3), maker.array(3, 6, sensor=(5, 5))],
            "topic /d, message 1: sensor and encoding are ((5, 5), 'stamped'): must be ((64, 48), 'stamped'), as before",
        ),
    ):  # fmt: skip
        (tmp_path / name).mkdir()
        assert refusal(maker.write(tmp_path / name, (("/d", DVS, i, each) for i, each in enumerate(arrays, 1)))) == said


@pytest.mark.parametrize(
    ("start", "said"),
    [
        *((start, f"is encoded as {start}: must be little-endian CDR, 0001") for start in ("", "0001", "000100", "00000000")),
        ("00010000", "of 4 bytes has a field that needs 8; is it cut off?"),
    ],
)
def test_a_message_shorter_than_its_encoding_is_refused(start: str, said: str) -> None:
    with refused(RecordingError, said):
        read_stamped(bytes.fromhex(start), is_cdr=True)


def test_a_bag_that_was_cut_off_gives_every_whole_message_before_the_cut(tmp_path: Path) -> None:
    maker = Maker("ros1")
    path = maker.write(tmp_path, maker.arrays())
    content = path.read_bytes()
    index_at = int.from_bytes(content[content.index(b"index_pos=") + 10 :][:8], "little")
    last = content.rindex(b"ccccc")  # the header of the last message with events
    for length, count in ((index_at - 1, COUNT), (last + 20, 85)):
        assert refusal(path, content[:length]).endswith("is it cut off?")
        with pytest.warns(RecordingWarning, match=f"everything after {count} events left out: .*is it cut off"):
            assert_events(read_recording(path, damage="skip").events, 0, count)


def test_of_a_packed_chunk_that_was_cut_off_whole_blocks_are_read(tmp_path: Path) -> None:
    maker = Maker("ros1-lz4")
    noise = np.random.default_rng(18).integers(32, 127, 300_000, np.uint8).tobytes().decode()  # several blocks of 64 kB
    path = maker.write(
        tmp_path, itertools.chain(maker.arrays(), [("/log", "std_msgs/msg/String", int(T_NS[-1]), maker.string(noise))])
    )
    path.write_bytes(path.read_bytes()[:200_000])
    assert refusal(path).endswith("is it cut off?")
    with pytest.warns(RecordingWarning, match=f"everything after {COUNT} events left out: .*is it cut off"):
        assert_events(read_recording(path, damage="skip").events)


def test_an_index_that_counts_too_many_is_damage_and_one_that_counts_too_few_a_warning(tmp_path: Path) -> None:
    maker = Maker("ros1")
    path = maker.write(tmp_path, maker.arrays())
    content = path.read_bytes()
    last = content.rindex((7).to_bytes(4, "little"))
    more, fewer = (content[:last] + count.to_bytes(4, "little") + content[last + 4 :] for count in (8, 6))
    assert refusal(path, more) == "topic /dvs/events: 7 messages in the chunks, 8 in the index: must not be fewer"
    path.write_bytes(fewer)
    with pytest.warns(RecordingWarning) as caught:
        assert_events(read_recording(path).events)
    said = f"{path}: topic /dvs/events: 7 messages in the chunks, 6 in the index: all are read"
    assert [str(each.message) for each in caught] == [said]


def test_a_bag_that_counts_too_few_messages_is_a_warning_and_one_that_counts_none_says_nothing(tmp_path: Path) -> None:
    maker = Maker("ros2-sqlite3")
    path = maker.write(tmp_path, maker.arrays())
    metadata, content = path / "metadata.yaml", (path / "metadata.yaml").read_text()
    assert content.count("message_count: 7") == 3
    for count in (0, 5, 8):
        metadata.write_text(content.replace("message_count: 7", f"message_count: {count}"))
        told = f"topic /dvs/events: 7 messages, of which the bag counts {count}: "
        if count == 8:
            assert refusal(path) == told + "must not be fewer"
        else:
            with pytest.warns(RecordingWarning, match=told + "all are read") if count else nullcontext():
                assert_events(read_recording(path).events)


def test_a_table_that_holds_no_bytes_is_refused(tmp_path: Path) -> None:
    maker = Maker("sqlite3")
    path = maker.write(tmp_path, maker.arrays())
    with sqlite3.connect(path) as database:
        database.execute("UPDATE messages SET data = 7 WHERE id = 3")
    database.close()
    assert refusal(path).startswith("topic /dvs/events: is damaged after message 2: ")


@pytest.mark.parametrize("damage", ["refuse", "skip"])
@pytest.mark.parametrize("kind", ["ros1", "ros1-lz4", "mcap", "sqlite3"])
def test_damage_is_told_or_does_not_matter(tmp_path: Path, kind: str, damage: Any) -> None:
    """The files are too long to cut at every byte: at one in a hundred."""
    maker = Maker(kind)
    path = maker.write(tmp_path, maker.arrays())
    content = path.read_bytes()
    outcomes = fuzz(path, content, cuts=False, corruptions=CORRUPTIONS, seed=41, damage=damage)
    assert outcomes.refused
    assert outcomes.read
    cut = tmp_path / "cut"
    for length in cut_lengths(content[:-20], 100):
        cut.write_bytes(content[:length])
        refusal(cut)


@pytest.mark.parametrize(("is_cdr", "most"), [(False, 0), (True, 3)])
def test_a_message_ends_with_its_last_field_and_the_padding_of_cdr(is_cdr: bool, most: int) -> None:
    for left in range(5):
        fields = _Fields(memoryview(b"\0\1\0\0" + bytes(4 + left))[0 if is_cdr else 4 :], is_cdr)
        fields.number(4)
        if left <= most:
            fields.end()
        else:
            size = 4 + left + (4 if is_cdr else 0)
            with refused(RecordingError, f"of {size} bytes ends {left} bytes early: is it another version of this message?"):
                fields.end()
