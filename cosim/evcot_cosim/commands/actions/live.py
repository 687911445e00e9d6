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
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console

from evcot.errors import ConfigError
from evcot.events import Events
from evcot.filters.config import FilterConfig
from evcot.hardware.config import CotConfig, MotionConfig
from evcot.hardware.modules import MODULES
from evcot.trackers.engines import ENGINES, usable_engines
from evcot.trackers.presets import run_config
from evcot.trackers.settings import engine_settings
from evcot.tracks.record import NO_NAMES
from evcot.tracks.tracking import Tracker

from ...live.dashboard import rows_of, show
from ...live.player import Begin, Player, Run, Wish
from ...live.recorder import LogKeeper, Recorder
from ...live.server import Server
from ...live.session import Session
from ...live.sources import CameraSource, FileSource, LiveSource, NetworkSource
from ...live.tracker_thread import HARDWARE, Beside, hardware_beside, warm_up
from ...tables import print_table
from ..options import sensor_from, window_from
from .files import open_from, weights_from
from .progress import Length
from .settings import configured, filters_from, say_seen
from .spinner import Counting

if TYPE_CHECKING:
    from evcot.recognition.weights import Weights

__all__ = ["run"]

_HERE = "127.0.0.1"
_LINE_S = 1.0  # between lines of --json
_NAP_S = 0.05
_PAGE_S = 60.0  # after the end of a file, for the first page to be opened
_SPEEDS = (0.001, 1000.0)


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Run until the source ends, the time is over or somebody interrupts; 0."""
    _check(options)
    window = window_from(options)
    with ExitStack() as undo:
        source, blocks = _open(options, window)
        undo.callback(source.close)
        weights = weights_from(options)
        names = weights.names if weights else NO_NAMES
        log = LogKeeper(options.save_log, options.engine, names, force=options.force) if options.save_log else None
        if log is not None:
            undo.callback(log.drop)
        recorder = Recorder(options.save, source.sensor, force=options.force) if options.save else None
        if recorder is not None:
            undo.callback(recorder.drop)
        runs = Runs(options, source, blocks, weights, recorder, log)
        hardware = " and the hardware" if options.with_hardware else ""
        waiting = f"preparing {options.engine}{hardware} (compiled the first time, up to a minute)"
        with Counting(waiting, enabled=not (options.quiet or options.json)):
            player = Player(runs.prepare, runs.first, _fixed(options))
        server = undo.enter_context(Server(player, options.web, options.bind or _HERE)) if options.web is not None else None
        if server is not None and isinstance(source, FileSource):
            undo.enter_context(_measured(options, source, window))
        _run(options, player, server)
    runs.filters.save_learned()
    if runs.tracker is not None:
        say_seen(runs.tracker, quiet=options.quiet)
    summary = player.run.session.summary()
    if options.json:
        _print_line({"kind": "summary"} | summary)
    elif not options.quiet:
        print_table(rows_of(summary))
    return 0


def _fixed(options: argparse.Namespace) -> str:
    """Why a page cannot choose what is played; nothing if it can."""
    for option, path in (("--save", options.save), ("--save-log", options.save_log)):
        if path is not None:
            return f"{option} keeps one run: another engine or place would not fit into it"
    return ""


def _measured(options: argparse.Namespace, source: FileSource, window: tuple[int, int | None]) -> Length:
    def found(_events: int, length_s: float) -> None:
        source.length_s = length_s

    return Length(lambda: open_from(options, Path(options.source)), window, found)


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


def _run(options: argparse.Namespace, player: Player, server: Server | None) -> None:
    """Play until all is over or somebody interrupts; what is kept is then whole."""
    console = Console()
    ended = threading.Event()
    over_s = 0.0

    def going_on() -> bool:
        """At the end of a file, an open page may want to see it again; a person at a terminal may be about to open one."""
        nonlocal over_s
        if ended.is_set() or player.running:
            return not ended.is_set()
        over_s = over_s or time.monotonic()
        if server is None or player.fixed or player.failed or not isinstance(player.run.session.source, FileSource):
            return False
        awaited = console.is_terminal and not server.seen and time.monotonic() - over_s < _PAGE_S
        return server.watched or awaited

    player.start()
    url = server.url if server else None
    try:
        with _ending(player, ended, options.for_s):
            if options.json:
                source = player.run.session.source
                _print_line({"kind": "start", "page": url, "source": source.name, "sensor": source.sensor})
                while going_on():
                    _wait(going_on, _LINE_S)
                    _print_line({"kind": "figures"} | player.run.session.figures())
            elif options.quiet or not console.is_terminal:
                if url is not None and not options.quiet:
                    print(f"evcot: the page is at {url}", file=sys.stderr, flush=True)
                _wait(going_on, math.inf)
            else:
                show(player, url, console, going_on)
    except KeyboardInterrupt:
        pass
    finally:
        player.stop()


def _wait(going_on: Callable[[], bool], seconds: float) -> None:
    """As long as it goes on, but not longer than this."""
    end_s = time.monotonic() + seconds
    while going_on() and (rest_s := end_s - time.monotonic()) > 0:
        time.sleep(min(rest_s, _NAP_S))


def _print_line(told: dict[str, Any]) -> None:
    print(json.dumps(told, allow_nan=False), flush=True)


@contextmanager
def _ending(player: Player, ended: threading.Event, for_s: float | None) -> Iterator[None]:
    """All is over when the time is, or when somebody asks the process to terminate."""

    def end() -> None:
        ended.set()
        player.end()

    before = signal.signal(signal.SIGTERM, lambda *_: threading.Thread(target=end).start())
    timer = threading.Timer(for_s or 0, end)
    if for_s is not None:
        timer.start()
    try:
        yield
    finally:
        timer.cancel()
        signal.signal(signal.SIGTERM, before)


class Runs:
    """Prepares sessions over one source.

    Args:
        blocks: the events ahead of time, where the source is a file; none of a stream.
        weights: of a classifier behind the engine that they are for; None: without one.
        recorder, log: as of `Session`.

    Attributes:
        tracker: that of the newest session.
        filters: what the options say about filters.
    """

    def __init__(
        self,
        options: argparse.Namespace,
        source: LiveSource,
        blocks: Callable[[], Iterator[Events]],
        weights: Weights | None,
        recorder: Recorder | None,
        log: LogKeeper | None,
    ) -> None:
        self.tracker: Tracker | None = None
        self._options, self._source = options, source
        self._weights, self._recorder, self._log = weights, recorder, log
        settings, filters = configured(options, source.sensor)
        self.filters = filters_from(options, blocks(), source.sensor)
        self._given = settings, self.filters.on(filters)
        self._hardware: CotConfig | MotionConfig | None = None

    @property
    def first(self) -> Wish:
        """What the options say."""
        return Wish(self._options.engine, self._options.preset, self._options.with_hardware)

    def prepare(self, wish: Wish) -> Begin:
        """See `Player`; the settings of the options are those of their engine and preset alone, filters are in front of all.

        Raises:
            ConfigError: no such engine or preset.
        """
        sensor = self._source.sensor
        settings, filters = self._settings(wish)
        warm_up(self._start(wish.engine, settings, filters), sensor)
        tracker = self._start(wish.engine, settings, filters)
        beside = [self._beside()] if wish.hardware else []

        def begin() -> Run:
            if isinstance(self._source, FileSource):
                self._source.begin_s = wish.at_s
            self.tracker = tracker
            session = Session(self._source, tracker, self._recorder, self._log, beside=beside)
            return Run(session, self._hello(wish))

        return begin

    def _start(self, engine: str, settings: Any, filters: FilterConfig) -> Tracker:
        """A new tracker; engines that a page chooses have a classifier if the weights are for them."""
        sensor = self._source.sensor
        if self._weights is None or engine not in (self._weights.tracker, self._options.engine):
            return ENGINES[engine].start(settings, filters, sensor)
        from evcot.recognition.tracker import start_classifying  # with Numba

        return start_classifying(engine, settings, filters, sensor, self._weights)

    def _settings(self, wish: Wish) -> tuple[Any, FilterConfig]:
        if (wish.engine, wish.preset) == (self._options.engine, self._options.preset):
            return self._given
        settings, filters = engine_settings(wish.engine, self._source.sensor, wish.preset)
        return settings, self.filters.on(filters)

    def _beside(self) -> Beside:
        """The default hardware, as `evcot cosim` runs it."""
        sensor = self._source.sensor
        if self._hardware is None:
            run = run_config(*sensor)
            run = replace(run, filters=self.filters.on(run.filters))
            self._hardware = run.device_config(*sensor)
        return hardware_beside(self._hardware, sensor)

    def _hello(self, wish: Wish) -> dict[str, Any]:
        source = self._source
        is_file = isinstance(source, FileSource)
        return {
            "name": source.name, "engine": wish.engine, "preset": wish.preset,
            "width": source.sensor[0], "height": source.sensor[1],
            "speed": self._options.speed if is_file else 1.0,
            "engines": {name: list(engine.presets) for name, engine in usable_engines().items()},
            "lanes": [wish.engine, *([HARDWARE] if wish.hardware else [])],
            "kinds": ["model" if wish.engine in MODULES else "software", *([HARDWARE] if wish.hardware else [])],
            "seekable": is_file,
        }  # fmt: skip
