# SPDX-License-Identifier: Apache-2.0
"""The page's server, tested with a WebSocket client: access control, messages, and isolation from slow clients."""

from __future__ import annotations

import json
import socket
import struct
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import pytest

from evcot.errors import ConfigError, OutputError
from evcot_cosim.live.server import Server
from evcot_cosim.live.session import Session

from .stories import EveryTenth, Played, parts_of, random_events, wait_until

pytest.importorskip("websockets", reason="websockets is not installed")
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

HELLO = {"name": "test", "engine": "rct", "preset": "plain", "width": 64, "height": 48, "speed": 1.0}


@pytest.fixture
def session() -> Iterator[Session]:
    """30 events every 10 ms, for a long time."""
    session = Session(Played(parts_of(random_events(300_000, 1), 30), lambda _: time.sleep(0.01)), EveryTenth())
    session.start()
    yield session
    session.stop()


@pytest.fixture
def server(session: Session) -> Iterator[Server]:
    with Server(session, HELLO, port=0) as server:
        yield server


def look(server: Server, **more: Any) -> ClientConnection:
    return connect(server.url.replace("http", "ws") + "events", compression=None, **{"origin": server.url.rstrip("/"), **more})


def next_frame(connection: ClientConnection) -> bytes:
    while isinstance(message := connection.recv(timeout=10), str):
        pass
    return message


def number_of(frame: bytes) -> int:
    number: int = struct.unpack_from("<I", frame, 4)[0]
    return number


def answer(connection: ClientConnection, frame: bytes) -> None:
    connection.send(struct.pack("<B3xI", 2, number_of(frame)))


def test_it_says_who_it_is_then_sends_frames_and_figures(server: Server, session: Session) -> None:
    with look(server) as connection:
        assert json.loads(connection.recv(timeout=10)) == {"type": "hello", **HELLO}
        texts, frames = [], []
        while len(frames) < 10 or not texts or json.loads(texts[-1])["drawn_ms"]["p50"] is None:
            message = connection.recv(timeout=10)
            (texts if isinstance(message, str) else frames).append(message)
            if isinstance(message, bytes):
                answer(connection, message)
    assert [number_of(frame) for frame in frames] == list(range(len(frames)))
    result = json.loads(texts[-1])
    assert result["type"] == "figures"
    assert result["running"]
    assert result["drawn_ms"]["p50"] > 0
    figures = session.figures()
    assert 0 < figures["tracked_ms"]["p50"] < figures["drawn_ms"]["p50"] < 2_000


def test_who_does_not_answer_gets_no_more_and_the_next_frame_has_all_in_it(server: Server, session: Session) -> None:
    with look(server) as connection:
        first, second = next_frame(connection), next_frame(connection)
        before = session.figures()["events"]
        while session.figures()["events"] < before + 300:
            assert isinstance(connection.recv(timeout=10), str), "figures alone go on"
        answer(connection, first)
        third = next_frame(connection)
        assert number_of(third) == number_of(second) + 1
        events = struct.unpack_from("<II", third, 8)
        assert sum(events) > 200, "what came in the meantime"


def test_only_its_own_page_may_connect(server: Server) -> None:
    port = int(server.url.rsplit(":", 1)[1].strip("/"))
    for origin in (f"http://127.0.0.1:{port}", f"http://localhost:{port}"):
        with look(server, origin=origin):
            pass
    for origin in ("http://evil.example", f"http://127.0.0.1:{port + 1}", f"https://127.0.0.1:{port}", "null", None):
        with pytest.raises(InvalidStatus) as error, look(server, origin=origin):
            pass
        assert error.value.response.status_code == 403


def test_the_page_is_one_document_that_may_fetch_nothing(server: Server) -> None:
    with urllib.request.urlopen(server.url, timeout=10) as response:
        page, headers = response.read().decode(), response.headers
    assert headers["Content-Type"] == "text/html; charset=utf-8"
    assert "default-src 'none'" in headers["Content-Security-Policy"]
    assert page.startswith("<!DOCTYPE html>")
    assert not any(outside in page for outside in ("http://", "https://", "src=", "@import", "import "))
    with pytest.raises(urllib.error.HTTPError, match="404"):
        urllib.request.urlopen(server.url + "other", timeout=10)


def test_no_more_than_eight_look_at_once(server: Server) -> None:
    with ExitStack() as open_pages:
        for _ in range(8):
            next_frame(open_pages.enter_context(look(server)))
        with look(server) as ninth:
            wait_until(lambda: _ended(ninth))
            assert ninth.close_code == 1013
    with look(server) as connection:
        next_frame(connection)


def _ended(connection: ClientConnection) -> bool:
    try:
        connection.recv(timeout=0.1)
    except ConnectionClosed:
        return True
    except TimeoutError:
        pass
    return False


def test_a_message_that_is_too_long_ends_the_connection_only(server: Server) -> None:
    with look(server) as connection:
        next_frame(connection)
        connection.send(b"x" * 100_000)
        wait_until(lambda: _ended(connection))
    with look(server) as connection:
        next_frame(connection)


def test_addresses_that_cannot_be(session: Session) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(OutputError, match=rf"^127\.0\.0\.1:{port}: cannot listen there: Address already in use$"):
            Server(session, HELLO, port)
    for bind, message in (("0.0.0.0", "must be one address"), ("::", "must be one address"), ("here", "must be an IP address")):
        with pytest.raises(ConfigError, match=f"^--bind {bind}: {message}"):
            Server(session, HELLO, 0, bind)
    with pytest.raises(ConfigError, match=r"^--web 70000: must be from 0 to 65535$"):
        Server(session, HELLO, 70_000)
