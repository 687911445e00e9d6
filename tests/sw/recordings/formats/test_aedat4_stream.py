# SPDX-License-Identifier: Apache-2.0
"""AEDAT 4.0 over TCP: from a test server that can misbehave, and from dv-processing's."""

from __future__ import annotations

import io
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import RecordingError
from evcot.events import Events
from evcot.recordings.formats.aedat4 import MAGIC
from evcot.recordings.formats.aedat4_sink import Aedat4Sink
from evcot.recordings.formats.aedat4_stream import Aedat4Stream
from support.refusals import refused

from .reading import assert_same

SENSOR = (346, 260)


def some_events(count: int, seed: int = 3) -> Events:
    random = np.random.default_rng(seed)
    t_us = 1_700_000_000_000_000 + np.sort(random.integers(0, 100_000, count))
    x, y = (random.integers(side, size=count).astype(np.uint16) for side in SENSOR)
    return Events(t_us, x, y, random.integers(2, size=count).astype(np.uint8))


def sent(events: Events, packets: int = 4) -> bytes:
    """What a server sends: a file without its version line and its table, in so many packets."""
    file = io.BytesIO()
    sink = Aedat4Sink(file, SENSOR)
    for part in np.array_split(np.arange(len(events)), packets):
        sink.write(events[part[0] : part[-1] + 1])
        sink.flush()
    return file.getvalue()[len(MAGIC) :]


@contextmanager
def server(data: bytes, *, then_stay: bool = False) -> Iterator[int]:
    """A port on which the first client gets the data, in small pieces; then the connection is closed, or stays idle."""
    done = threading.Event()
    with socket.create_server(("127.0.0.1", 0)) as listening:

        def serve() -> None:
            with listening.accept()[0] as connection:
                try:
                    for begin in range(0, len(data), 10_007):
                        connection.sendall(data[begin : begin + 10_007])
                except OSError:
                    return
                done.wait(10 if then_stay else 0)

        thread = threading.Thread(target=serve)
        thread.start()
        try:
            yield listening.getsockname()[1]
        finally:
            done.set()
            thread.join()


def received(port: int) -> list[Events]:
    with Aedat4Stream("127.0.0.1", port) as stream:
        return list(stream.packets())


@pytest.mark.parametrize("version_line", [b"", MAGIC])
def test_every_packet_comes_as_it_was_sent(version_line: bytes) -> None:
    events = some_events(50_000)
    with server(version_line + sent(events)) as port, Aedat4Stream("127.0.0.1", port) as stream:
        assert (stream.sensor, stream.name) == (SENSOR, "evcot")
        packets = list(stream.packets())
    assert len(packets) == 4
    assert_same(Events.joined(packets), events)


def test_a_silent_connection_is_left_when_it_is_not_wanted_any_more() -> None:
    begin_s = time.monotonic()
    with server(sent(some_events(100), 1), then_stay=True) as port, Aedat4Stream("127.0.0.1", port) as stream:
        assert len(list(stream.packets(lambda: time.monotonic() < begin_s + 0.5))) == 1
    assert 0.5 <= time.monotonic() - begin_s < 3


def test_a_stream_that_is_cut_is_an_error_wherever_it_is_cut() -> None:
    data = sent(some_events(300), 3)
    header = 4 + int.from_bytes(data[:4], "little")
    ends = [header]
    while ends[-1] < len(data):
        ends.append(ends[-1] + 8 + struct.unpack_from("<i", data, ends[-1] + 4)[0])
    assert ends[-1] == len(data)
    for cut in [*range(0, header, 97), *range(header, len(data), 211), *(end - 1 for end in ends)]:
        with server(data[:cut]) as port:
            if cut in ends:
                assert len(received(port)) == ends.index(cut)
                continue
            where = "ends within its header" if cut < header else "ends within a packet"
            with pytest.raises(RecordingError, match=f"{where}, at byte {cut}$"):
                received(port)


def test_whatever_is_damaged_ends_in_an_error_or_in_events() -> None:
    data = bytearray(sent(some_events(200), 2))
    random = np.random.default_rng(8)
    errors: list[str] = []
    for _ in range(150):
        damaged = data.copy()
        damaged[random.integers(len(data))] ^= 1 << random.integers(8)
        with server(bytes(damaged)) as port:
            try:
                received(port)
            except RecordingError as error:
                errors.append(str(error))
    assert len(errors) > 50
    assert not any("\n" in error for error in errors)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"HTTP/1.1 400 Bad Request\r\n\r\n", "header of 1347703880 bytes: must be at most 1048576; is it AEDAT4?"),
        (struct.pack("<I", 8) + b"\x08\0\0\0IOHX", "header: is marked b'IOHX': must be b'IOHE'"),
        (b"", "ends within its header, at byte 0"),
    ],
)
def test_what_is_no_such_stream_is_refused(data: bytes, message: str) -> None:
    with server(data) as port, refused(RecordingError, message):
        received(port)


def test_a_length_that_nobody_can_mean_is_refused_before_any_of_it_is_awaited() -> None:
    data = sent(some_events(10), 1)
    header = 4 + int.from_bytes(data[:4], "little")
    for stream, length in ((0, -1), (0, 1 << 30), (7, 100)):
        said = f"byte {header}: packet of stream {stream}, {length} bytes: must be one of [0] and at most 134217728"
        wrong = data[:header] + struct.pack("<ii", stream, length)
        with server(wrong, then_stay=True) as port, refused(RecordingError, said):
            received(port)


def test_nobody_there_is_said() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    with refused(RecordingError, "cannot be reached: Connection refused"):
        Aedat4Stream("127.0.0.1", port)


# In a process of its own, which is killed: the writer may wait for ever when it is taken down after its client has gone.
DV_SERVER = """
import sys, time
import dv_processing as dv
import numpy as np

port, path = int(sys.argv[1]), sys.argv[2]
with np.load(path) as stored:
    columns = [stored[name].tolist() for name in ("t_us", "x", "y", "p")]
writer = dv.io.NetworkWriter("127.0.0.1", port, dv.io.Stream.EventStream(0, "events", "PRESSED", (346, 260)))
print("listening", flush=True)
while not writer.getClientCount():
    time.sleep(0.01)
for begin in range(0, len(columns[0]), 1000):
    store = dv.EventStore()
    for t_us, x, y, p in zip(*(column[begin : begin + 1000] for column in columns)):
        store.push_back(t_us, x, y, bool(p))
    writer.writeEvents(store)
time.sleep(60)
"""


def test_dv_processing_s_own_writer(tmp_path: Path) -> None:
    pytest.importorskip("dv_processing", reason="dv-processing is not installed")
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    events = some_events(3_000)
    np.savez(tmp_path / "events.npz", t_us=events.t_us, x=events.x, y=events.y, p=events.p)
    command = [sys.executable, "-c", DV_SERVER, str(port), str(tmp_path / "events.npz")]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as sender:
        try:
            assert sender.stdout is not None
            assert sender.stdout.readline() == b"listening\n"
            got = _until(Aedat4Stream("127.0.0.1", port), len(events))
        finally:
            sender.kill()
    assert_same(Events.joined(got), events)


def _until(stream: Aedat4Stream, count: int) -> list[Events]:
    """Packets until so many events have come."""
    got: list[Events] = []
    deadline_s = time.monotonic() + 10
    with stream:
        assert (stream.sensor, stream.name) == (SENSOR, "PRESSED")
        for packet in stream.packets(lambda: time.monotonic() < deadline_s):
            got.append(packet)
            if sum(map(len, got)) == count:
                break
    return got
