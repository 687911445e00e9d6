# SPDX-License-Identifier: Apache-2.0
"""Server of the live page and its WebSocket. A page acknowledges each drawn frame, which gives back-pressure.

A page on this machine may also say what to play; one on another machine can only watch.
"""

from __future__ import annotations

import asyncio
import ipaddress
import json
import logging
import os
import socket
import threading
import time
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from http import HTTPStatus
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.errors import ConfigError, OutputError
from evcot.templating import html_templates

from ..report.page import SCREEN, hash_of, inline_modules, inline_styles
from . import PORT
from .messages import FrameMaker, drawn_number, pack_frame, wish_in
from .player import Player, Run
from .queues import Waiting
from .session import Session, Step

__all__ = ["Page", "Server", "page"]


_OWN = ("protocol", "rail", "main")  # in the order in which they need each other


@dataclass(frozen=True)
class Page:
    """The HTTP response for a browser."""

    body: bytes
    headers: Mapping[str, str]


def page() -> Page:
    """The page; its headers allow only its own script, and connections only to its own origin."""
    script = "\n".join([inline_modules(SCREEN), *(_source(f"{name}.js") for name in _OWN)])
    environment = html_templates("evcot_cosim.live", "evcot_cosim.report")
    body = (
        environment.get_template("live.html.j2")
        .render(style=inline_styles("style", "screen") + _source("live.css"), script=script)
        .encode()
    )
    policy = f"default-src 'none'; script-src 'sha256-{hash_of(script)}'; style-src 'unsafe-inline'; img-src data:"
    policy += "; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    return Page(
        body,
        {
            "Content-Type": "text/html; charset=utf-8",
            "Content-Length": str(len(body)),
            "Content-Security-Policy": policy,
            "X-Frame-Options": "DENY",
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer",
            "Cache-Control": "no-store",
        },
    )


def _source(name: str) -> str:
    return (files("evcot_cosim.live") / "templates" / name).read_text(encoding="utf-8")


_FRAMES_HZ = 60
_UNDRAWN_MAX = 2  # frames sent to a viewer but not yet drawn
_FIGURES_S = 0.5
_VIEWERS_MAX = 8
_MESSAGE_BYTES_MAX = 256  # longest message of a page
_HERE = ("127.0.0.1", "::1")
_REFUSED = 1008  # the code of WebSocket for a message against the rules
_START_S = 10.0
_GOODBYE_S = 1.0  # for the pages to receive the end of the run
_NAP_S = 0.02
_SOCKET_PATH = "/events"


class Server:
    """Shows what is played on a page of its own, to browsers on this machine. A context manager.

    Args:
        player: what is played; pages may change it.
        port: 0 for any free port.
        bind: address to listen on. Only pages from this address, and from this machine's own names, may connect.

    Attributes:
        url: URL of the page.

    Raises:
        ConfigError: the extra `live` is not installed, or an address that no browser can name.
        OutputError: the address is not available.
    """

    def __init__(self, player: Player, port: int = PORT, bind: str = "127.0.0.1") -> None:
        _check_installed()
        self._player = player
        self._listening = _listening(bind, port)
        self._port = self._listening.getsockname()[1]
        host = f"[{bind}]" if ":" in bind else bind
        self.url = f"http://{host}:{self._port}/"
        self._hosts = [f"{name}:{self._port}" for name in dict.fromkeys((host, "127.0.0.1", "localhost"))]
        self._origins: list[Any] = [f"http://{name}" for name in self._hosts]
        self._page = page()
        self._viewers = 0
        self._seen = False
        self._loop = asyncio.new_event_loop()
        self._ended = asyncio.Event()
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self) -> Server:
        self._thread.start()
        self._ready.wait(_START_S)
        return self

    def __exit__(self, *_: object) -> None:
        self._loop.call_soon_threadsafe(self._ended.set)
        self._thread.join()
        self._listening.close()

    @property
    def watched(self) -> bool:
        """Whether a page is open."""
        return self._viewers > 0

    @property
    def seen(self) -> bool:
        """Whether a page has ever been open."""
        return self._seen

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._serve())
        finally:
            self._loop.close()

    async def _serve(self) -> None:
        from websockets.asyncio.server import serve

        async with serve(
            self._serve_viewer, sock=self._listening, origins=self._origins, process_request=self._answer,
            logger=_quiet_log(),
            compression=None, max_size=_MESSAGE_BYTES_MAX, server_header=None, close_timeout=1,
        ):  # fmt: skip
            self._ready.set()
            await self._ended.wait()
            for _ in range(round(_GOODBYE_S / _NAP_S)):
                if not self._viewers:
                    break
                await asyncio.sleep(_NAP_S)

    def _answer(self, connection: Any, request: Any) -> Any:
        """The response to an HTTP request: the page, or None to continue with a WebSocket handshake.

        A request for another host is refused: a page of that host, whose name was made to lead here, must not read this one.
        """
        if request.headers.get_all("Host") not in [[host] for host in self._hosts]:
            return connection.respond(HTTPStatus.MISDIRECTED_REQUEST, "not this host\n")
        if request.path == _SOCKET_PATH:
            return None
        if request.path != "/":
            return connection.respond(HTTPStatus.NOT_FOUND, "not here\n")
        response = connection.respond(HTTPStatus.OK, "")
        for name in ("Content-Type", "Content-Length"):
            del response.headers[name]
        response.headers.update(self._page.headers)
        response.body = self._page.body
        return response

    async def _serve_viewer(self, connection: Any) -> None:
        """Serve one page from connection to disconnection."""
        from websockets.exceptions import ConnectionClosed

        if self._viewers >= _VIEWERS_MAX:
            await connection.close(1013, f"{_VIEWERS_MAX} pages are open already")
            return
        self._viewers += 1
        self._seen = True
        _send_at_once(connection)
        undrawn = _Undrawn()
        may_change = connection.remote_address[0] in (*_HERE, connection.local_address[0])
        reading = asyncio.ensure_future(self._read(connection, undrawn, may_change))
        try:
            while await self._show_run(connection, self._player.run, undrawn, may_change, reading):
                pass
        finally:
            self._viewers -= 1
            reading.cancel()
            with suppress(ConnectionClosed, asyncio.CancelledError):
                await reading

    async def _show_run(
        self, connection: Any, run: Run, undrawn: _Undrawn, may_change: bool, reading: asyncio.Future[None]
    ) -> bool:
        """Show one session; returns whether another has taken its place, in contrast to the page having gone."""
        from websockets.exceptions import ConnectionClosed

        async with self._subscription(run.session) as inbox:
            undrawn.begin(run.session)
            changes = may_change and not self._player.fixed
            why = self._player.fixed if may_change else "this page is on another machine: it can only watch"
            hello = {"type": "hello", **run.hello, "labels": run.session.labels}
            hello |= {"changes": changes, "fixed": "" if changes else why}
            await connection.send(json.dumps(hello))
            work = [
                self._send_frames(connection, run.session, inbox, undrawn),
                self._send_figures(connection, run.session, inbox),
                self._say_goodbye(connection, run.session, inbox),
                self._until_another(run),
            ]
            tasks = [asyncio.ensure_future(each) for each in work]
            another = tasks[-1]
            try:
                done, _ = await asyncio.wait([*tasks, reading], return_when=asyncio.FIRST_COMPLETED)
                return done == {another}
            finally:
                for task in tasks:
                    task.cancel()
                for task in tasks:
                    with suppress(ConnectionClosed, asyncio.CancelledError):
                        await task

    @asynccontextmanager
    async def _subscription(self, session: Session) -> AsyncIterator[Waiting[Step]]:
        inbox = session.subscribe()
        try:
            yield inbox
        finally:
            session.unsubscribe(inbox)

    async def _until_another(self, run: Run) -> None:
        while self._player.run is run:
            await asyncio.sleep(_NAP_S)

    async def _read(self, connection: Any, undrawn: _Undrawn, may_change: bool) -> None:
        """Process a page's messages until it disconnects; one that is against the rules ends the connection."""
        async for message in connection:
            if isinstance(message, bytes):
                undrawn.drawn(drawn_number(message))
                continue
            wish = wish_in(message) if may_change else None
            if wish is None:
                await connection.close(_REFUSED, "not a message that this page may send")
                return
            self._player.ask(wish)

    async def _send_frames(self, connection: Any, session: Session, inbox: Waiting[Step], undrawn: _Undrawn) -> None:
        maker = FrameMaker(session.source.sensor, undrawn.next)
        due_s = time.perf_counter()
        while True:
            await undrawn.wait()
            due_s = max(due_s + 1 / _FRAMES_HZ, time.perf_counter())
            await asyncio.sleep(due_s - time.perf_counter())
            taken = inbox.take()
            if taken is None:
                await self._ended.wait()
            elif taken.items:
                frame = maker.make(taken.items, session.clusters, session.beside)
                undrawn.sent(frame.number, frame.arrived_s)
                await connection.send(pack_frame(frame, session.first_us))

    async def _send_figures(self, connection: Any, session: Session, inbox: Waiting[Step]) -> None:
        while True:
            await connection.send(self._figures(session, inbox))
            await asyncio.sleep(_FIGURES_S)

    def _figures(self, session: Session, inbox: Waiting[Step]) -> str:
        told = {"undrawn": inbox.lost, "running": session.running and not self._ended.is_set(), "note": self._player.note}
        place = {name: getattr(session.source, name, None) for name in ("place_s", "length_s")}
        return json.dumps({"type": "figures", **session.figures(), **place, **told})

    async def _say_goodbye(self, connection: Any, session: Session, inbox: Waiting[Step]) -> None:
        """Send the last figures when all is over, and close the connection with a code that a failure does not have."""
        await self._ended.wait()
        await connection.send(self._figures(session, inbox))
        await connection.close(1000, "ended")


class _Undrawn:
    """Frames sent to a viewer but not yet drawn.

    Attributes:
        next: number of the next frame: numbers go on from session to session.
    """

    def __init__(self) -> None:
        self.next = 0
        self._session: Session | None = None
        self._arrived_s: dict[int, NDArray[np.float64]] = {}
        self._fewer = asyncio.Event()

    def begin(self, session: Session) -> None:
        """Frames are those of another session from now on."""
        self._session = session
        self._arrived_s.clear()
        self._fewer.set()

    def sent(self, number: int, arrived_s: NDArray[np.float64]) -> None:
        self._arrived_s[number] = arrived_s
        self.next = number + 1

    async def wait(self) -> None:
        """Wait until another frame may be sent."""
        while len(self._arrived_s) >= _UNDRAWN_MAX:
            self._fewer.clear()
            await self._fewer.wait()

    def drawn(self, number: int | None) -> None:
        """The page reports that it has drawn a frame."""
        if number in self._arrived_s and self._session is not None:
            self._session.drawn.add(time.perf_counter() - self._arrived_s.pop(number))
            self._fewer.set()


def _send_at_once(connection: Any) -> None:
    """Let TCP not hold back a short message until the one before is acknowledged, which takes the other side up to 40 ms.

    asyncio does so itself only for sockets made with the number of TCP, which `socket.create_server` leaves at 0.
    """
    connection.transport.get_extra_info("socket").setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)


def _quiet_log() -> logging.Logger:
    """A logger that discards the messages of websockets about failed connections."""
    log = logging.getLogger(__name__)
    log.addHandler(logging.NullHandler())
    log.propagate = False
    return log


def _check_installed() -> None:
    try:
        import websockets.asyncio.server  # noqa: F401
    except ImportError as error:
        raise ConfigError("--web: websockets must be installed: pip install 'evcot[live]'") from error


def _listening(bind: str, port: int) -> socket.socket:
    try:
        address = ipaddress.ip_address(bind)
    except ValueError as error:
        raise ConfigError(f"--bind {bind}: must be an IP address of this machine") from error
    if address.is_unspecified:
        raise ConfigError(f"--bind {bind}: must be one address, which a browser can name")
    if not 0 <= port < 65536:
        raise ConfigError(f"--web {port}: must be from 0 to 65535")
    try:
        return socket.create_server((bind, port), family=socket.AF_INET6 if address.version == 6 else socket.AF_INET)
    except OSError as error:
        raise OutputError(f"{bind}:{port}: cannot listen there: {os.strerror(error.errno or 0)}") from error
