# SPDX-License-Identifier: Apache-2.0
"""The sessions of `evcot live`: from the options, changed by what a page has chosen."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from evcot.events import Events
from evcot.filters.config import FilterConfig
from evcot.hardware.config import CotConfig, MotionConfig
from evcot.hardware.modules import MODULES
from evcot.trackers.engines import ENGINES, usable_engines
from evcot.trackers.presets import run_config
from evcot.trackers.settings import engine_settings
from evcot.tracks.tracking import Tracker

from ...live.player import Begin, Run, Wish
from ...live.recorder import LogKeeper, Recorder
from ...live.session import Session
from ...live.sources import FileSource, LiveSource
from ...live.tracker_thread import HARDWARE, Beside, hardware_beside, warm_up
from .settings import configured, filters_from, with_options

__all__ = ["Runs"]


class Runs:
    """Prepares sessions over one source.

    Args:
        blocks: the events ahead of time, where the source is a file; none of a stream.
        recorder, log: as of `Session`.

    Attributes:
        tracker: that of the newest session.
    """

    def __init__(
        self,
        options: argparse.Namespace,
        source: LiveSource,
        blocks: Callable[[], Iterator[Events]],
        recorder: Recorder | None,
        log: LogKeeper | None,
    ) -> None:
        self.tracker: Tracker | None = None
        self._options, self._source = options, source
        self._recorder, self._log = recorder, log
        self._given = configured(options, source.sensor)
        given_filters = filters_from(options, self._given[1], blocks(), source.sensor)
        self._given = self._given[0], given_filters
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
        start = ENGINES[wish.engine].start
        warm_up(start(settings, filters, sensor), sensor)
        tracker = start(settings, filters, sensor)
        beside = [self._beside()] if wish.hardware else []

        def begin() -> Run:
            if isinstance(self._source, FileSource):
                self._source.begin_s = wish.at_s
            self.tracker = tracker
            session = Session(self._source, tracker, self._recorder, self._log, beside=beside)
            return Run(session, self._hello(wish))

        return begin

    def _settings(self, wish: Wish) -> tuple[Any, FilterConfig]:
        if (wish.engine, wish.preset) == (self._options.engine, self._options.preset):
            return self._given
        settings, filters = engine_settings(wish.engine, self._source.sensor, wish.preset)
        return settings, with_options(self._options, filters, self._source.sensor)

    def _beside(self) -> Beside:
        """The default hardware, as `evcot cosim` runs it."""
        sensor = self._source.sensor
        if self._hardware is None:
            run = run_config(*sensor)
            run = replace(run, filters=with_options(self._options, run.filters, sensor))
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
