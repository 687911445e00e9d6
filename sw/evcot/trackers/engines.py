# SPDX-License-Identifier: Apache-2.0
"""The registry of trackers by name, with their presets, behind one interface.

A tracker's own modules are imported when it is first used.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, NamedTuple

from ..hardware.modules import DEFAULT_MODULE, Module

if TYPE_CHECKING:
    from ..filters.config import FilterConfig
    from ..recordings.formats.source import Sensor
    from ..tracks.tracking import Tracker
    from .config import RunConfig

    Start = Callable[[Any, FilterConfig, Sensor], Tracker]

__all__ = ["DEFAULT", "ENGINES", "Engine"]


class _Parts(NamedTuple):
    """See `Engine`."""

    presets: Mapping[str, Any]
    start: Start
    filters: Mapping[str, FilterConfig] = {}


@dataclass(frozen=True)
class Engine:
    """A registered tracker.

    Attributes:
        title: display name.
        load: imports the tracker's modules; returns the rest.
    """

    title: str
    load: Callable[[], _Parts]

    @cached_property
    def _parts(self) -> _Parts:
        return self.load()

    @property
    def presets(self) -> Mapping[str, Any]:
        """name -> settings; the first is the default."""
        return self._parts.presets

    @property
    def start(self) -> Start:
        """A new tracker with these settings, these filters in front of it, and this sensor; RecordingError: it is too large."""
        begin = self._parts.start

        def start(settings: Any, filters: FilterConfig, sensor: Sensor) -> Tracker:
            from ..events import check_pixels

            check_pixels(*sensor)
            return begin(settings, filters, sensor)

        return start

    @property
    def filters(self) -> Mapping[str, FilterConfig]:
        """Name of a preset -> the filters that belong in front of it."""
        return self._parts.filters


def _software(make: Callable[[Any, int, int], Tracker]) -> Start:
    """Make the `start` of a software tracker: filters are put in front only if any is enabled."""
    from ..filters.run import filtered
    from ..tracks.tracking import FilteredTracker

    def start(settings: Any, filters: FilterConfig, sensor: Sensor) -> Tracker:
        tracker = make(settings, *sensor)
        return FilteredTracker(filtered((), filters, sensor).keep, tracker) if filters.enabled else tracker

    return start


def _rct() -> _Parts:
    from .rct import presets, tracker

    return _Parts(presets.PRESETS, _software(tracker.RctTracker), presets.FILTERS)


def _adaptive() -> _Parts:
    from .adaptive import config, estimates

    return _Parts(config.PRESETS, _software(estimates.ObservedTracker))


def _mean_shift() -> _Parts:
    from .mean_shift import config, tracker

    return _Parts(config.PRESETS, _software(lambda settings, *_: tracker.MeanShiftTracker(settings)))


def _frames() -> _Parts:
    from .frame_based import config, tracker

    return _Parts(config.PRESETS, _software(lambda settings, *_: tracker.FrameTracker(settings)))


def _golden(module: Module) -> _Parts:
    """A golden model has its filters inside, as the hardware has them."""
    from ..hardware.golden import GoldenTracker
    from . import presets

    def start(run: RunConfig, filters: FilterConfig, sensor: Sensor) -> Tracker:
        return GoldenTracker(replace(presets.fit(run, *sensor), filters=filters).device_config(*sensor))

    known = presets.presets_of(module)
    return _Parts(known, start, {name: run.filters for name, run in known.items()})


_GOLDEN: dict[Module, str] = {
    "cot_motion": "golden model of the default hardware: boxes follow size and speed",
    "cot_array": "golden model: square windows, every slot sees every event",
    "cot_chain": "golden model: square windows, trackers in a chain",
    "cot": "golden model of a single tracker",
}

ENGINES: dict[str, Engine] = {
    **{module: Engine(title, partial(_golden, module)) for module, title in _GOLDEN.items()},
    "adaptive": Engine("objects by motion, with settings estimated from the stream", _adaptive),
    "rct": Engine("Rectangular Cluster Tracker", _rct),
    "mean-shift": Engine("baseline: mean shift on packets of events", _mean_shift),
    "frames": Engine("baseline: connected components of frames", _frames),
}

DEFAULT = DEFAULT_MODULE
"""The engine of all commands and functions that track, with its first preset."""
