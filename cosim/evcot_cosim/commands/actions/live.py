# SPDX-License-Identifier: Apache-2.0
"""`evcot live`: events tracked and shown while they happen."""

from __future__ import annotations

import argparse
import json
import math
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from evcot.errors import ConfigError
from evcot.events import Events
from evcot.recordings.formats.source import Sensor
from evcot.trackers.engines import ENGINES
from evcot.tracks.tracking import Tracker

from ...live.camera import CameraSource
from ...live.dashboard import rows_of, show
from ...live.recorder import LogKeeper, Recorder
from ...live.server import Server
from ...live.session import Session
from ...live.sources import FileSource, LiveSource, NetworkSource
from ...tables import print_table
from ..options import sensor_from, window_from
from .counting import Counting
from .filters import filters_from, save_learned
from .opening import open_from
from .settings import configured, say_seen

__all__ = ["run"]

_HERE = "127.0.0.1"
_LINE_S = 1.0  # between lines of --json
_NAP_S = 0.05
_SPEEDS = (0.001, 1000.0)


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Run until the source ends, the time is over or somebody interrupts; 0."""
    _check(options)
    window = window_from(options)
    with ExitStack() as undo:
        source, blocks = _open(options, window)
        undo.callback(source.close)
        settings, filters = configured(options, source.sensor)
        filters = filters_from(options, filters, blocks(), source.sensor)
        start = ENGINES[options.engine].start
        waiting = f"getting {options.engine} ready (the first time takes longer)"
        with Counting(waiting, enabled=not (options.quiet or options.json)):
            _warm(start(settings, filters, source.sensor), source.sensor)
        log = LogKeeper(options.save_log, options.engine, force=options.force) if options.save_log else None
        if log is not None:
            undo.callback(log.drop)
        recorder = Recorder(options.save, source.sensor, force=options.force) if options.save else None
        if recorder is not None:
            undo.callback(recorder.drop)
        tracker = start(settings, filters, source.sensor)
        session = Session(source, tracker, recorder, log)
        hello = {
            "name": source.name, "engine": options.engine, "preset": options.preset or "default preset",
            "width": source.sensor[0], "height": source.sensor[1],
            "speed": options.speed if isinstance(source, FileSource) else 1.0,
        }  # fmt: skip
        server = (
            undo.enter_context(Server(session, hello, options.web, options.bind or _HERE)) if options.web is not None else None
        )
        _run(options, session, server.url if server else None)
    save_learned(options)
    say_seen(tracker, quiet=options.quiet)
    summary = session.summary()
    if options.json:
        _print_line({"kind": "summary"} | summary)
    elif not options.quiet:
        print_table(rows_of(summary))
    return 0


def _check(options: argparse.Namespace) -> None:
    if options.bind is not None and options.web is None:
        raise ConfigError(f"--bind {options.bind}: must be given with --web, which shows the page")
    for option, path in (("--save", options.save), ("--save-log", options.save_log)):
        if options.loop and path is not None:
            raise ConfigError(f"{option}: must not be given with --loop: the recording is there already")
    if not (math.isfinite(options.speed) and _SPEEDS[0] <= options.speed <= _SPEEDS[1]):
        raise ConfigError(f"--speed {options.speed:g}: must be from {_SPEEDS[0]:g} to {_SPEEDS[1]:g}")
    if options.for_s is not None and not 0 < options.for_s < 1e9:
        raise ConfigError(f"--for {options.for_s:g}: must be more than 0 seconds")


def _open(options: argparse.Namespace, window: tuple[int, int | None]) -> tuple[LiveSource, Callable[[], Iterator[Events]]]:
    """The source, and its events ahead of time where it is a file."""
    scheme, colon, rest = options.source.partition(":")
    if scheme not in ("tcp", "camera") or Path(options.source).exists():
        file = open_from(options, Path(options.source))
        return FileSource(file, window, options.speed, loop=options.loop), lambda: file.blocks(*window)
    for option, given in (
        ("--speed", options.speed != 1), ("--from", options.from_ms != 0), ("--to", options.to_ms is not None),
        ("--learn-hot-pixels", options.learn_hot_pixels), ("--loop", options.loop),
    ):  # fmt: skip
        if given:
            raise ConfigError(f"{option}: must not be given with {options.source}, which is no file")
    if scheme == "camera":
        return CameraSource(rest if colon else None), lambda: iter(())
    return NetworkSource(rest.removeprefix("//"), sensor_from(options)), lambda: iter(())


def _warm(tracker: Tracker, sensor: Sensor) -> None:
    """Have everything compiled before the first event comes: a blob that rests for a while does it."""
    n = 4_000
    random = np.random.default_rng(0)
    x, y = ((side / 2 + random.normal(0, 2, n)).clip(0, side - 1).astype(np.uint16) for side in sensor)
    tracker.feed(Events(np.arange(n, dtype=np.int64) * 20, x, y, random.integers(2, size=n).astype(np.uint8)))
    tracker.finish()


def _run(options: argparse.Namespace, session: Session, url: str | None) -> None:
    """Run the session until it ends, the time is over or somebody interrupts; what it keeps is then whole."""
    console = Console()
    session.start()
    try:
        with _ending(session, options.for_s):
            if options.json:
                _print_line({"kind": "start", "page": url, "source": session.source.name, "sensor": session.source.sensor})
                _print_figures(session)
            elif options.quiet or not console.is_terminal:
                if url is not None and not options.quiet:
                    print(f"evcot: the page is at {url}", file=sys.stderr, flush=True)
                _wait(session, math.inf)
            else:
                show(session, session.source.name, url, console)
    except KeyboardInterrupt:
        pass
    finally:
        session.stop()


def _print_figures(session: Session) -> None:
    while session.running:
        _wait(session, _LINE_S)
        _print_line({"kind": "figures"} | session.figures())


def _wait(session: Session, seconds: float) -> None:
    """Until the session ends, but not longer than this."""
    end_s = time.monotonic() + seconds
    while session.running and (rest_s := end_s - time.monotonic()) > 0:
        time.sleep(min(rest_s, _NAP_S))


def _print_line(told: dict[str, Any]) -> None:
    print(json.dumps(told, allow_nan=False), flush=True)


@contextmanager
def _ending(session: Session, for_s: float | None) -> Iterator[None]:
    """The session ends when the time is over or somebody asks the process to terminate."""
    before = signal.signal(signal.SIGTERM, lambda *_: session.end())
    timer = threading.Timer(for_s or 0, session.end)
    if for_s is not None:
        timer.start()
    try:
        yield
    finally:
        timer.cancel()
        signal.signal(signal.SIGTERM, before)
