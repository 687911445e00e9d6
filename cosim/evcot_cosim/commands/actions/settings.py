# SPDX-License-Identifier: Apache-2.0
"""An engine's settings, from the options."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from dataclasses import asdict
from typing import Any

from evcot.errors import ConfigError, meant
from evcot.filters.config import FilterConfig
from evcot.hardware.modules import MODULES
from evcot.ranges import read_pair, read_value
from evcot.trackers.adaptive.estimates import ObservedTracker
from evcot.trackers.config import RunConfig
from evcot.trackers.engines import ENGINES
from evcot.trackers.settings import changeable, changed, engine_settings
from evcot.tracks.tracking import FilteredTracker, Tracker

__all__ = ["configured", "plain", "say_seen"]


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
        rule = f" with a key among {', '.join(known)}"
        key, text = read_pair("--set", setting, rule)
        if key not in known:
            raise ConfigError(f"--set {setting}: must be KEY=VALUE{rule}{_meant(key, known, options.engine, sensor)}")
        changes[key] = read_value(f"{options.engine}.{key}", text, known[key])
    return changed(options.engine, settings, changes)


def _meant(key: str, known: Iterable[str], engine: str, sensor: tuple[int, int]) -> str:
    """As `meant`: a key of this engine, else of another one, whose name is then given."""
    near = meant(key, known)
    others = (name for name in ENGINES if name != engine and name not in MODULES)
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
