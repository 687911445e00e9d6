# SPDX-License-Identifier: Apache-2.0
"""The live view: its maximum event rate without drops, and the latency until an event is tracked and drawn.

Discs of `streams`, played repeatedly at increasing speed: without a viewer, with a client on the WebSocket that acknowledges
at once, and with the page in a browser. A rate is sustained if nothing is dropped before the tracker during the whole run and
playback does not fall behind.

Latencies are those of the last ten seconds of a run of thirteen, so the start of the page is not among them. Another process on
the machine spoils them: the best of three runs is given, with its load and the figures of the others.
"""

from __future__ import annotations

import os
import shutil
import struct
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

import streams
from evcot.events import Events
from evcot.filters.config import FilterConfig
from evcot.recordings.files import RecordingFile
from evcot.trackers.engines import ENGINES
from evcot_cosim.live.player import Player, Run, Wish
from evcot_cosim.live.server import Server
from evcot_cosim.live.session import Session
from evcot_cosim.live.sources import FileSource
from measure import Result, Skip

__all__ = ["measure"]

_RATES_M = (0.5, 1, 2, 4, 6, 8, 10, 12, 15, 20, 25, 30, 40)  # tried from below, until one is too much
_TRIES = 2  # of a rate, and one more: others on the machine may spoil one
_LATENCY_RATE_M = 1.0
_LATENCY_S = 13.0  # of which a `Latency` remembers the last ten
_LATENCY_TRIES = 3
_ROUND_EVENTS = 2_000_000
_BLOCK_EVENTS = 1 << 15
_PACKET_S = 0.005
_HELLO = {
    "name": "benchmark",
    "engine": "rct",
    "preset": "plain",
    "width": streams.WIDTH,
    "height": streams.HEIGHT,
    "speed": 1.0,
    "engines": {"rct": ["plain"]},
    "lanes": ["rct"],
    "seekable": False,
}


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """live_rate_*, live_cores_*, live_tracked_*, live_drawn_* without a viewer, with a client and with a browser."""
    events = streams.joined(_ROUND_EVENTS)
    seconds = 2.0 if quick else 5.0
    _run(events, 1.0, 1.0, _nobody)  # everything is compiled
    for name, looking in (("nobody", _nobody), ("client", _client), ("browser", _browser)):
        try:
            yield from _looked_at(name, events, seconds, looking)
        except Skip as reason:
            print(f"live, {name}: skipped: {reason}")


@dataclass(frozen=True)
class _Run:
    """Results of a run."""

    rate_m: float
    cores: float
    dropped: int
    slipped_s: float
    load: float
    tracked_ms: dict[str, float | None]
    drawn_ms: dict[str, float | None]

    @property
    def sustained(self) -> bool:
        """Whether nothing was dropped, and playback kept up."""
        return not self.dropped and self.slipped_s < 0.1


Looking = Callable[[Server], Any]


def _looked_at(name: str, events: Events, seconds: float, looking: Looking) -> Iterator[Result]:
    best, cores, first_lost = 0.0, 0.0, ""
    for rate_m in _RATES_M:
        tries = (_run(events, rate_m, seconds, looking) for _ in range(_TRIES))
        run = next((run for run in tries if run.sustained), None) or _run(events, rate_m, seconds, looking)
        if not run.sustained:
            first_lost = f"; at {rate_m:g} M events/s {run.dropped:,} were dropped, {run.slipped_s:.1f} s late"
            break
        best, cores = run.rate_m, run.cores
    how = f"without a drop for {seconds:g} s, on {cores:.2f} cores; {name} looks{first_lost}"
    yield Result(f"live_rate_{name}", best, "M events/s", how=how)
    runs = [_run(events, _LATENCY_RATE_M, 3.0 if seconds < 5 else _LATENCY_S, looking) for _ in range(_LATENCY_TRIES)]
    run = min(runs, key=lambda run: run.drawn_ms["p99"] or run.tracked_ms["p99"] or 0.0)
    how = f"CPU time of evcot itself at {_LATENCY_RATE_M:g} M events/s"
    yield Result(f"live_cores_{name}", run.cores, "cores", how=how)
    for what in ("tracked", "drawn"):
        for share in ("p50", "p99"):
            all_ms = [getattr(each, f"{what}_ms")[share] for each in runs]
            ms = getattr(run, f"{what}_ms")[share]
            if ms is not None:
                how = (
                    f"from a packet's first event, at {_LATENCY_RATE_M:g} M events/s in packets of {1e3 * _PACKET_S:g} ms; "
                    f"load average {run.load:.1f}; all tries: {', '.join(f'{each:.0f}' for each in all_ms)}"
                )
                yield Result(f"live_{what}_{name}_{share}", ms, "ms", how=how)


def _run(events: Events, rate_m: float, seconds: float, looking: Looking) -> _Run:
    """One run at a rate of so many million events a second."""
    sensor = streams.WIDTH, streams.HEIGHT
    engine = ENGINES["rct"]
    tracker = engine.start(engine.presets["plain"], FilterConfig(), sensor)
    source = FileSource(cast(RecordingFile, _again_and_again(events)), (0, None), rate_m)
    session = Session(source, tracker)
    player = Player(lambda _wish: lambda: Run(session, _HELLO), Wish("rct", "plain"))
    with ExitStack() as undo:
        if looking is not _nobody:
            undo.enter_context(looking(undo.enter_context(Server(player, port=0))))
        player.start()
        begin_cpu_s = time.process_time()
        time.sleep(seconds)
        cores = (time.process_time() - begin_cpu_s) / seconds
        summary, recent = session.summary(), session.figures()
        player.stop()
    rate, load = summary["events_per_s"] / 1e6, os.getloadavg()[0]
    return _Run(rate, cores, summary["dropped"], source.slipped_s, load, recent["tracked_ms"], recent["drawn_ms"])


def _again_and_again(events: Events) -> Any:
    """What `FileSource` asks of a file: the events for ever, each round after the one before."""

    def blocks(*_window: object, **_more: object) -> Iterator[Events]:
        shift_us = 0
        while True:
            for begin in range(0, len(events), _BLOCK_EVENTS):
                part = events[begin : begin + _BLOCK_EVENTS]
                yield Events(part.t_us + shift_us, part.x, part.y, part.p)
            shift_us += int(events.t_us[-1]) + 1

    first_us, sensor = int(events.t_us[0]), (streams.WIDTH, streams.HEIGHT)
    return SimpleNamespace(
        path=Path("discs"), sensor=sensor, t0_us=first_us, left_out=Counter(), blocks=blocks, __exit__=lambda *_: None
    )


def _nobody(_server: Server) -> Any:
    raise AssertionError("nobody looks")


@contextmanager
def _client(server: Server) -> Iterator[None]:
    """Receives every frame and acknowledges it at once."""
    try:
        from websockets.exceptions import ConnectionClosed
        from websockets.sync.client import connect
    except ImportError as error:
        raise Skip("websockets is not installed") from error
    with connect(
        server.url.replace("http", "ws") + "events", origin=cast(Any, server.url.rstrip("/")), compression=None
    ) as client:

        def receive() -> None:
            with suppress(ConnectionClosed):
                for message in client:
                    if not isinstance(message, bytes):
                        continue
                    client.send(struct.pack("<B3xI", 2, int(np.frombuffer(message, "<u4", 1, 4)[0])))

        thread = threading.Thread(target=receive, daemon=True)
        thread.start()
        yield


@contextmanager
def _browser(server: Server) -> Iterator[None]:
    """The page in Chromium, without a screen."""
    chromium = shutil.which("chromium")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError as error:
        raise Skip("Playwright is not installed") from error
    if chromium is None:
        raise Skip("Chromium is not installed")
    with sync_playwright() as tools:
        flags = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
        browser = tools.chromium.launch(executable_path=chromium, args=flags)
        browser.new_page(viewport={"width": 1280, "height": 800}).goto(server.url)
        yield
        browser.close()


if __name__ == "__main__":
    for result in measure(Path("build"), quick=False):
        print(f"{result.name:28}{result.value:10.2f} {result.unit:12}{result.how}")
