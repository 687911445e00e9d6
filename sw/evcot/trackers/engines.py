# SPDX-License-Identifier: Apache-2.0
"""The registry of trackers by name, with their presets, behind one interface.

A tracker's own modules are imported when it is first used. Other packages add trackers with entry points of the group
`evcot.trackers`, see docs/plug_in.md.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

from ..errors import EngineError
from ..hardware.modules import DEFAULT_MODULE, Module

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from ..filters.config import FilterConfig
    from ..recordings.formats.source import Sensor
    from ..tracks.tracking import Tracker
    from .config import RunConfig

    Start = Callable[[Any, FilterConfig, Sensor], Tracker]

__all__ = ["DEFAULT", "ENGINES", "Engine", "usable_engines"]

_GROUP = "evcot.trackers"
_NAME = re.compile(r"[a-z][a-z0-9_-]*")
# What stands for something else where engines are named: in sweeps, in reports, in files of settings.
_TAKEN = ("filters", "fuzz", "hardware", "model", "motion", "preset", "rtl", "run", "shape", "slot", "software", "truth")


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
        plug_in: the entry point of a tracker of another package; None: it is evcot's.

    Raises:
        EngineError: by the other attributes, for a tracker of another package that cannot be used.
    """

    title: str
    load: Callable[[], _Parts]
    plug_in: EntryPoint | None = None

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

    @property
    def sources(self) -> list[Path]:
        """The Python files of the package that a tracker of another package comes from; empty for evcot's."""
        from .plug_in import plug_in_sources

        return [] if self.plug_in is None else plug_in_sources(self.plug_in)


def _software(make: Callable[[Any, int, int], Tracker]) -> Start:
    """Make the `start` of a software tracker: filters are put in front only if any is enabled."""
    from ..filters.run import filtered
    from ..tracks.tracking import FilteredTracker

    def start(settings: Any, filters: FilterConfig, sensor: Sensor) -> Tracker:
        tracker = make(settings, *sensor)
        return FilteredTracker(filtered((), filters, sensor).keep, tracker) if filters.enabled else tracker

    return start


def _rct() -> _Parts:
    from .rct import config, tracker

    return _Parts(config.PRESETS, _software(tracker.RctTracker), config.FILTERS)


def _adaptive() -> _Parts:
    from .adaptive import config, estimates

    return _Parts(config.PRESETS, _software(estimates.ObservedTracker))


def _mean_shift() -> _Parts:
    from .mean_shift import tracker

    return _Parts(tracker.PRESETS, _software(lambda settings, *_: tracker.MeanShiftTracker(settings)))


def _frames() -> _Parts:
    from . import frame_based

    return _Parts(frame_based.PRESETS, _software(lambda settings, *_: frame_based.FrameTracker(settings)))


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

_OWN: dict[str, Engine] = {
    **{module: Engine(title, partial(_golden, module)) for module, title in _GOLDEN.items()},
    "adaptive": Engine("objects by motion, with settings estimated from the stream", _adaptive),
    "rct": Engine("Rectangular Cluster Tracker", _rct),
    "mean-shift": Engine("baseline: mean shift on packets of events", _mean_shift),
    "frames": Engine("baseline: connected components of frames", _frames),
}


def _plugged(name: str, point: EntryPoint) -> _Parts:
    from .plug_in import PlugIn

    made = PlugIn(name, point)
    return _Parts({"default": made.settings}, _software(made.start))


def _refused(message: str) -> NoReturn:
    raise EngineError(message)


def _plug_ins() -> dict[str, Engine]:
    """The trackers of other packages. One whose name cannot be used is listed nevertheless, and says so when it is used."""
    from importlib.metadata import entry_points

    by_name: defaultdict[str, list[EntryPoint]] = defaultdict(list)
    for point in entry_points(group=_GROUP):
        by_name[point.name].append(point)
    found = {}
    for name, points in sorted(by_name.items()):
        packages = sorted({point.dist.name if point.dist else point.module for point in points})
        where, rule = f"engine {name} of package {packages[0]}", ""
        if name in _OWN:
            rule = f"evcot has an engine {name} itself: the package must name its entry point of {_GROUP} otherwise"
        elif len(points) > 1:
            rule = f"{' and '.join(packages[1:]) or 'the same package'} has one, too: one of them must be removed"
        elif not _NAME.fullmatch(name) or name in _TAKEN:
            rule = f"must be named with lower-case letters, digits, - and _, and not {', '.join(_TAKEN)}"
        load = partial(_refused, f"{where}: {rule}") if rule else partial(_plugged, where, points[0])
        shown = f"{name} of {packages[0]}" if name in _OWN else name
        found[shown] = Engine(f"tracker of package {packages[0]}", load, points[0])
    return found


class _Engines(Mapping[str, Engine]):
    """evcot's own trackers, then those of other packages, which are looked for when one is named, or all are listed."""

    @cached_property
    def _plugged(self) -> dict[str, Engine]:
        return _plug_ins()

    def __getitem__(self, name: str) -> Engine:
        return _OWN[name] if name in _OWN else self._plugged[name]

    def __iter__(self) -> Iterator[str]:
        yield from _OWN
        yield from self._plugged

    def __len__(self) -> int:
        return len(_OWN) + len(self._plugged)


ENGINES: Mapping[str, Engine] = _Engines()


def usable_engines() -> dict[str, Engine]:
    """Those of `ENGINES` that can be loaded; all are."""

    def is_usable(engine: Engine) -> bool:
        try:
            return bool(engine.presets)
        except EngineError:
            return False

    return {name: engine for name, engine in ENGINES.items() if is_usable(engine)}


DEFAULT = DEFAULT_MODULE
"""The engine of all commands and functions that track, with its first preset."""
