# SPDX-License-Identifier: Apache-2.0
"""An engine's settings: those of a preset, with a file's changes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from ..errors import ConfigError, meant
from ..events import Events
from ..filters.config import FilterConfig
from ..recordings.formats.source import Sensor
from .config import RunConfig, load_toml, load_tracker, without_motion
from .engines import ENGINES
from .presets import AUTO_PAPER, for_sensor

__all__ = ["changeable", "changed", "engine_settings"]


def engine_settings(
    engine: str,
    sensor: Sensor,
    preset: str | None = None,
    config: Path | None = None,
    *,
    look: Callable[[], Iterable[Events]] | None = None,
    say: Callable[[str], object] = lambda line: None,
    mark: str = "",
) -> tuple[Any, FilterConfig]:
    """The settings of an engine of `ENGINES`, and the filters in front of it.

    Args:
        sensor: (width, height) in pixels.
        preset: one of the engine's; None: its first, but of "cot" the one for the sensor with a file that has registers of
            slots.
        config: a TOML file that overrides the preset.
        look: reads the recording; with it, `AUTO_PAPER` is a preset of "cot", too.
        say: is given a line on what was seen and chosen.
        mark: what messages have in front of an argument's name: `--` on the command line.

    Raises:
        ConfigError: no such engine or preset, or a file that cannot be used.
    """
    if engine not in ENGINES:
        raise ConfigError(f"{mark}engine {engine}: must be one of {', '.join(ENGINES)}{meant(engine, ENGINES)}")
    presets = ENGINES[engine].presets
    by_look = (AUTO_PAPER,) if engine == "cot" and look else ()
    known = (*presets, *by_look)
    if preset not in (None, *known):
        raise ConfigError(
            f"{mark}preset {preset}: must be one of {', '.join(known)} with {mark}engine {engine}{meant(str(preset), known)}"
        )
    of_slots = engine == "cot" and config is not None and preset is None and without_motion(config)
    name = for_sensor(sensor[0]).name if of_slots else preset or next(iter(presets))
    settings = _as_seen(name, look, sensor, say) if look and name in by_look else presets[name]
    if isinstance(settings, RunConfig):
        settings = load_toml(config, settings) if config else settings
        return settings, settings.filters
    filters = ENGINES[engine].filters.get(name, FilterConfig())
    return load_tracker(config, engine, settings, filters) if config else (settings, filters)


def changeable(engine: str, settings: Any) -> dict[str, Any]:
    """The settings that `changed` can change: those of a software tracker, or the registers of an array with motion.

    Raises:
        ConfigError: an array without motion, whose slots have registers of their own.
    """
    if not isinstance(settings, RunConfig):
        return {field.name: getattr(settings, field.name) for field in fields(settings)}
    motion = settings.cot.motion
    if not motion.enable:
        rule = "its slots have registers of their own, which stand in a file"
        raise ConfigError(f"engine {engine} with preset {settings.name}: no single setting can be changed: {rule}")
    return {field.name: getattr(motion, field.name) for field in fields(motion) if field.name != "enable"}


def changed(engine: str, settings: Any, changes: Mapping[str, Any]) -> Any:
    """An engine's settings with other values for some of `changeable`.

    Raises:
        ConfigError: no such setting, or a value outside its range.
    """
    if not changes:
        return settings
    known = changeable(engine, settings)
    for key in changes:
        if key not in known:
            raise ConfigError(f"{engine}.{key}: no such setting: must be one of {', '.join(known)}{meant(key, known)}")
    if isinstance(settings, RunConfig):
        return replace(settings, cot=replace(settings.cot, motion=replace(settings.cot.motion, **changes)))
    return replace(settings, **changes)


def _as_seen(name: str, look: Callable[[], Iterable[Events]], sensor: Sensor, say: Callable[[str], object]) -> RunConfig:
    from .auto.estimates import estimate
    from .auto_registers import auto_config, told

    seen = estimate(look(), sensor)
    config = auto_config(seen, name)
    say(told(seen, config))
    return config
