# SPDX-License-Identifier: Apache-2.0
"""An engine's settings, and the filters in front of a tracker, from the options."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from dataclasses import asdict, replace
from typing import Any

from evcot.errors import ConfigError, meant
from evcot.events import Events
from evcot.filters.config import FilterConfig
from evcot.filters.hot_pixels import Pixels, learn_hot_pixels, load_hot_pixels, save_hot_pixels
from evcot.hardware.modules import MODULES
from evcot.ranges import read_pair, read_value
from evcot.trackers.adaptive.estimates import ObservedTracker
from evcot.trackers.config import RunConfig
from evcot.trackers.engines import usable_engines
from evcot.trackers.settings import changeable, changed, engine_settings
from evcot.tracks.tracking import FilteredTracker, Tracker

from ..options import NUMBERS

__all__ = ["check_learning", "configured", "filters_from", "plain", "save_learned", "say_seen", "with_options"]


def filters_from(
    options: argparse.Namespace, base: FilterConfig, blocks: Iterable[Events], sensor: tuple[int, int]
) -> FilterConfig:
    """A configuration with what the options say on top.

    Args:
        blocks: the recording, from which hot pixels are learned where the options ask for it.

    Raises:
        ConfigError: as `check_learning`, a value outside its range, or a list of hot pixels that cannot be used.
    """
    check_learning(options)
    learned: Pixels = learn_hot_pixels(blocks, sensor) if options.learn_hot_pixels else ()
    options.learned = learned, sensor
    return with_options(options, base, sensor)


def with_options(options: argparse.Namespace, base: FilterConfig, sensor: tuple[int, int]) -> FilterConfig:
    """As `filters_from`, after it: the hot pixels that it found are used again."""
    listed = load_hot_pixels(options.hot_pixels, sensor) if options.hot_pixels else ()
    config = _on_top(base, options)
    return replace(config, hot_pixels=config.hot_pixels + listed + options.learned[0])


def check_learning(options: argparse.Namespace) -> None:
    """Raise ConfigError where hot pixels are to be saved that nobody finds."""
    if options.save_hot_pixels is not None and not options.learn_hot_pixels:
        raise ConfigError("--save-hot-pixels: must be given with --learn-hot-pixels")


def save_learned(options: argparse.Namespace) -> None:
    """Write the hot pixels that `filters_from` found, where the options ask for it.

    Raises:
        OutputError: the file cannot be written.
    """
    if options.save_hot_pixels is not None:
        learned, sensor = options.learned
        save_hot_pixels(options.save_hot_pixels, learned, sensor, force=options.force)


def _on_top(config: FilterConfig, options: argparse.Namespace) -> FilterConfig:
    """The configuration with what the options say."""
    given = {name: getattr(options, name) for name in ("region", "polarity", *(field for field, *_ in NUMBERS.values()))}
    return config.changed({name: value for name, value in given.items() if value is not None})


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
