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
from evcot_cosim.live.player import Begin, Player, Run, Wish
from evcot_cosim.live.server import Server
from evcot_cosim.live.session import Session

from .stories import HELLO, EveryTenth, Played, parts_of, playing, random_events, wait_until

pytest.importorskip("websockets", reason="websockets is not installed")
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect


@pytest.fixture
def session() -> Session:
    """30 events every 10 ms, for a long time."""
    return Session(Played(parts_of(random_events(300_000, 1), 30), lambda _: time.sleep(0.01)), EveryTenth())


@pytest.fixture
def player(session: Session) -> Iterator[Player]:
    player = playing(session)
    player.start()
    yield player
    player.stop()


@pytest.fixture
def server(player: Player) -> Iterator[Server]:
    with Server(player, port=0) as server:
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
        assert json.loads(connection.recv(timeout=10)) == {
            "type": "hello",
            **HELLO,
            "labels": ["", "?"],
            "changes": True,
            "fixed": "",
        }
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


def test_short_messages_are_not_held_back(player: Player) -> None:
    seen = []

    class Seen(Server):
        async def _read(self, connection: Any, *more: Any) -> None:
            side = connection.transport.get_extra_info("socket")
            seen.append(side.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY))
            await super()._read(connection, *more)

    with Seen(player, port=0) as server, look(server) as connection:
        next_frame(connection)
    assert seen == [1]


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


def test_a_request_for_another_host_is_refused(server: Server) -> None:
    """A name of somebody else's can be made to lead to this machine."""
    port = int(server.url.rsplit(":", 1)[1].strip("/"))
    upgrade = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
    upgrade += "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
    for host, status in ((f"localhost:{port}", 200), (f"evil.example:{port}", 421), ("127.0.0.1", 421), (None, 421)):
        lines = "" if host is None else f"Host: {host}\r\n"
        assert status_of(port, f"GET / HTTP/1.1\r\n{lines}\r\n") == status
        if status != 200:
            origin = f"Origin: http://127.0.0.1:{port}\r\n"
            assert status_of(port, f"GET /events HTTP/1.1\r\n{lines}{origin}{upgrade}\r\n") == status


def status_of(port: int, request: str) -> int:
    with socket.create_connection(("127.0.0.1", port), timeout=10) as connection:
        connection.sendall(request.encode())
        return int(connection.recv(100).split()[1])


def test_the_page_may_not_be_framed(server: Server) -> None:
    with urllib.request.urlopen(server.url, timeout=10) as response:
        headers = response.headers
    assert headers["X-Frame-Options"] == "DENY"
    assert "frame-ancestors 'none'" in headers["Content-Security-Policy"]


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


def play(**more: Any) -> str:
    return json.dumps({"type": "play", "engine": "rct", "preset": None, "hardware": False, "at_s": 0, **more})


class Wishes:
    """Prepares a new session for every wish."""

    def __init__(self) -> None:
        self.asked: list[Wish] = []

    def prepare(self, wish: Wish) -> Begin:
        self.asked.append(wish)
        source = Played(parts_of(random_events(300_000, 1), 30), lambda _: time.sleep(0.01))
        return lambda: Run(Session(source, EveryTenth()), {**HELLO, "engine": wish.engine})


@pytest.fixture
def wishes() -> Wishes:
    return Wishes()


@pytest.fixture
def open_server(wishes: Wishes) -> Iterator[Server]:
    """A server whose pages may choose."""
    player = Player(wishes.prepare, Wish("adaptive"))
    player.start()
    with Server(player, 0, "127.0.0.2") as server:
        yield server
    player.stop()


def next_hello(connection: ClientConnection) -> dict[str, Any]:
    while isinstance(message := connection.recv(timeout=10), bytes) or json.loads(message)["type"] != "hello":
        pass
    told: dict[str, Any] = json.loads(message)
    return told


def test_a_page_chooses_what_is_played_and_all_pages_see_it(open_server: Server, wishes: Wishes) -> None:
    with look(open_server) as connection, look(open_server) as other:
        assert next_hello(connection)["engine"] == next_hello(other)["engine"] == "adaptive"
        first = [next_frame(connection), next_frame(connection)]
        connection.send(play(engine="rct", preset="discs", hardware=True, at_s=1.5))
        assert next_hello(connection)["engine"] == next_hello(other)["engine"] == "rct"
        assert wishes.asked == [Wish("adaptive"), Wish("rct", "discs", True, 1.5)]
        then = next_frame(connection)
        assert number_of(then) > number_of(first[-1]), "numbers go on, and what was not drawn before does not count"
        answer(connection, then)
        figures = connection.recv(timeout=10)
        while isinstance(figures, bytes) or json.loads(figures)["type"] != "figures":
            figures = connection.recv(timeout=10)
        assert json.loads(figures)["note"] == ""


def test_a_page_on_another_machine_can_only_watch(open_server: Server, wishes: Wishes) -> None:
    port = int(open_server.url.rsplit(":", 1)[1].strip("/"))
    elsewhere = socket.create_connection(("127.0.0.2", port), source_address=("127.0.0.3", 0))
    with look(open_server, sock=elsewhere) as connection:
        hello = next_hello(connection)
        assert not hello["changes"]
        assert hello["fixed"] == "this page is on another machine: it can only watch"
        next_frame(connection)
        connection.send(play())
        wait_until(lambda: _ended(connection))
        assert connection.close_code == 1008
    assert wishes.asked == [Wish("adaptive")]


def test_a_run_that_is_kept_cannot_be_changed(session: Session) -> None:
    player = playing(session, fixed="--save keeps one run")
    player.start()
    with Server(player, 0) as server, look(server) as connection:
        hello = next_hello(connection)
        assert (hello["changes"], hello["fixed"]) == (False, "--save keeps one run")
        connection.send(play())
        next_frame(connection)
        assert player.note == ""
    player.stop()


@pytest.mark.parametrize("message", ["hello", "{}", play(type="stop"), play(at_s=-1), play(more=1)])
def test_a_message_against_the_rules_ends_the_connection_only(open_server: Server, wishes: Wishes, message: str) -> None:
    with look(open_server) as connection:
        connection.send(message)
        wait_until(lambda: _ended(connection))
        assert connection.close_code == 1008
    with look(open_server) as connection:
        next_frame(connection)
    assert wishes.asked == [Wish("adaptive")]


def test_a_wish_has_256_bytes_at_most(open_server: Server, wishes: Wishes) -> None:
    with look(open_server) as connection:
        connection.send(play(engine="x" * 200))
        wait_until(lambda: _ended(connection))
        assert connection.close_code == 1009
    assert wishes.asked == [Wish("adaptive")]


def test_addresses_that_cannot_be(player: Player) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(OutputError, match=rf"^127\.0\.0\.1:{port}: cannot listen there: Address already in use$"):
            Server(player, port)
    for bind, message in (("0.0.0.0", "must be one address"), ("::", "must be one address"), ("here", "must be an IP address")):
        with pytest.raises(ConfigError, match=f"^--bind {bind}: {message}"):
            Server(player, 0, bind)
    with pytest.raises(ConfigError, match=r"^--web 70000: must be from 0 to 65535$"):
        Server(player, 70_000)
