# SPDX-License-Identifier: Apache-2.0
"""An engine's settings, and the filters in front of a tracker, from the options."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from evcot.errors import ConfigError, meant
from evcot.events import Events
from evcot.filters.config import FilterConfig
from evcot.filters.hot_pixels import Pixels, learn_hot_pixels, load_hot_pixels, save_hot_pixels
from evcot.hardware.modules import MODULES
from evcot.ranges import read_pair, read_value
from evcot.recordings.formats.source import Sensor
from evcot.trackers.adaptive.estimates import ObservedTracker
from evcot.trackers.config import RunConfig
from evcot.trackers.engines import usable_engines
from evcot.trackers.settings import changeable, changed, engine_settings
from evcot.tracks.tracking import FilteredTracker, Tracker

from ..options import NUMBERS

__all__ = ["FilterOptions", "check_learning", "configured", "filters_from", "plain", "say_seen"]


@dataclass(frozen=True)
class FilterOptions:
    """What the options say about filters, for any configuration.

    Attributes:
        changes: fields of `FilterConfig`, with their values.
        listed, learned: hot pixels of a file, and those that were found in the recording.
        sensor: of the recording.
        save: where the learned ones are written; None: nowhere.
        force: whether a file there is replaced.
    """

    changes: Mapping[str, Any]
    listed: Pixels
    learned: Pixels
    sensor: Sensor
    save: Path | None
    force: bool

    def on(self, base: FilterConfig) -> FilterConfig:
        """A configuration with the options on top; ConfigError for a value outside its range."""
        config = base.changed(self.changes)
        return replace(config, hot_pixels=config.hot_pixels + self.listed + self.learned)

    def save_learned(self) -> None:
        """Write the learned hot pixels, where the options ask for it; OutputError where the file cannot be written."""
        if self.save is not None:
            save_hot_pixels(self.save, self.learned, self.sensor, force=self.force)


def filters_from(options: argparse.Namespace, blocks: Iterable[Events], sensor: Sensor) -> FilterOptions:
    """What the options say about filters.

    Args:
        blocks: the recording, from which hot pixels are learned where the options ask for it.

    Raises:
        ConfigError: as `check_learning`, or a list of hot pixels that cannot be used.
    """
    check_learning(options)
    learned: Pixels = learn_hot_pixels(blocks, sensor) if options.learn_hot_pixels else ()
    listed: Pixels = load_hot_pixels(options.hot_pixels, sensor) if options.hot_pixels else ()
    given = {name: getattr(options, name) for name in ("region", "polarity", *(field for field, *_ in NUMBERS.values()))}
    changes = {name: value for name, value in given.items() if value is not None}
    save = options.save_hot_pixels
    return FilterOptions(changes, listed, learned, sensor, save, force=save is not None and options.force)


def check_learning(options: argparse.Namespace) -> None:
    """Raise ConfigError where hot pixels are to be saved that nobody finds."""
    if options.save_hot_pixels is not None and not options.learn_hot_pixels:
        raise ConfigError("--save-hot-pixels: must be given with --learn-hot-pixels")


def configured(options: argparse.Namespace, sensor: tuple[int, int]) -> tuple[Any, FilterConfig]:
    """The engine's settings and the filters in front: the preset, with the file's and then the options' changes."""
    settings, filters = engine_settings(options.engine, sensor, options.preset, options.config, mark="--")
    return _with_options(options, settings, sensor), filters


def _with_options(options: argparse.Namespace, settings: Any, sensor: tuple[int, int]) -> Any:
    """The settings with the values of --set."""
    if not options.set:
        return settings
    known = changeable(options.engine, settings)
    changes = {}
    for setting in options.set:
        rule = f" with a key among {', '.join(known)}" if known else f"; engine {options.engine} has no settings"
        key, text = read_pair("--set", setting, rule)
        if key not in known:
            raise ConfigError(f"--set {setting}: must be KEY=VALUE{rule}{_meant(key, known, options.engine, sensor)}")
        changes[key] = read_value(f"{options.engine}.{key}", text, known[key])
    return changed(options.engine, settings, changes)


def _meant(key: str, known: Iterable[str], engine: str, sensor: tuple[int, int]) -> str:
    """As `meant`: a key of this engine, else of another one, whose name is then given."""
    near = meant(key, known)
    others = (name for name in usable_engines() if name != engine and name not in MODULES)
    while not near and (other := next(others, None)) is not None:
        near = meant(key, asdict(engine_settings(other, sensor)[0])).replace("?", f" of --engine {other}?")
    return near


def plain(settings: Any) -> dict[str, Any]:
    """Settings as plain values."""
    return settings.to_dict() if isinstance(settings, RunConfig) else asdict(settings)


def say_seen(tracker: Tracker, *, quiet: bool) -> None:
    """Print what a tracker that follows the scene has seen of it, a line on stderr; nothing of another tracker."""
    inner = tracker.tracker if isinstance(tracker, FilteredTracker) else tracker
    if isinstance(inner, ObservedTracker) and not quiet:
        print(inner.estimates(), file=sys.stderr)
